// SPDX-License-Identifier: Apache-2.0
// A benchmark's figure: PREFIX.svg and PREFIX.png.
#pragma once

#include <string>

#include "majak/draw/figure.hpp"
#include "majak/io/atomic_file.hpp"
#include "majak/io/png.hpp"

namespace majak::bench {

inline void write_picture(const std::string& prefix, const draw::Figure& figure) {
  io::write_file_atomically(prefix + ".svg", draw::figure_svg(figure));
  io::write_file_atomically(prefix + ".png", io::encode_png(draw::figure_image(figure)));
}

}  // namespace majak::bench
