// SPDX-License-Identifier: Apache-2.0
// Figures into files.
#pragma once

#include <filesystem>
#include <string>

#include "majak/draw/figure.hpp"

namespace majak::app {

/// Throws Error when there can be no such folder.
void make_folder(const std::filesystem::path& folder);

/// NAME.svg and NAME.png.
void write_figure(const std::filesystem::path& folder, const std::string& name,
                  const draw::Figure& figure);

}  // namespace majak::app
