// SPDX-License-Identifier: Apache-2.0
// Where landmarks stand: lines `x y radius`, m, as `majak simulate --landmarks` writes them; #
// begins a comment.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "majak/core/pose2.hpp"

namespace majak::io {

/// Places alone. Throws Error, with the line, where one is no such line or there is none at all.
std::vector<Vec2> parse_landmarks(std::string_view text, const std::string& name);

/// parse_landmarks() of a file, plain, gzip or bzip2.
std::vector<Vec2> read_landmarks(const std::filesystem::path& path);

}  // namespace majak::io
