// SPDX-License-Identifier: Apache-2.0
// A benchmark's figure: PREFIX.svg and PREFIX.png.
#pragma once

#include <string>
#include <string_view>

#include "majak/draw/figure.hpp"
#include "majak/io/atomic_file.hpp"
#include "majak/io/png.hpp"

namespace majak::bench {

inline void write_file(const std::string& path, std::string_view bytes) {
  io::AtomicFile file(path);
  file.write(bytes);
  file.commit();
}

inline void write_picture(const std::string& prefix, const draw::Figure& figure) {
  write_file(prefix + ".svg", draw::figure_svg(figure));
  write_file(prefix + ".png", io::encode_png(draw::figure_image(figure)));
}

}  // namespace majak::bench
