// SPDX-License-Identifier: Apache-2.0
#include "app/write_figure.hpp"

#include <fmt/core.h>

#include <system_error>

#include "majak/core/error.hpp"
#include "majak/io/atomic_file.hpp"
#include "majak/io/png.hpp"

namespace majak::app {

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    throw Error(fmt::format("{}: cannot make this folder: {}", folder.string(), error.message()));
}

std::string results_folder(const std::filesystem::path& log, const char* suffix) {
  std::filesystem::path name = log.has_filename() ? log.filename() : log.parent_path().filename();
  while (name.has_extension()) name = name.stem();
  return name.string() + suffix;
}

void write_figure(const std::filesystem::path& folder, const std::string& name,
                  const draw::Figure& figure) {
  io::write_file_atomically(folder / (name + ".svg"), draw::figure_svg(figure));
  io::write_file_atomically(folder / (name + ".png"), io::encode_png(draw::figure_image(figure)));
}

}  // namespace majak::app
