// SPDX-License-Identifier: Apache-2.0
// Folders of results, and figures into them.
#pragma once

#include <filesystem>
#include <string>

#include "majak/draw/figure.hpp"

namespace majak::app {

/// Throws Error when there can be no such folder.
void make_folder(const std::filesystem::path& folder);

/// Where the results of a log go by default: its name without endings, and what was done.
std::string results_folder(const std::filesystem::path& log, const char* suffix);

/// NAME.svg and NAME.png.
void write_figure(const std::filesystem::path& folder, const std::string& name,
                  const draw::Figure& figure);

}  // namespace majak::app
