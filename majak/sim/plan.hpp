// SPDX-License-Identifier: Apache-2.0
// Worlds drawn as plans: in a text file or as a picture.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "majak/sim/world.hpp"

namespace majak::sim {

/// A text plan, one character a cell, the first line at the top:
///   '#' wall    ' ' or '.' floor    'o' a round post
///   '>' '^' '<' 'v' where the robot starts, and which way it faces    'S' starts to the right
///   '1' ... '9', 'A' ... 'R', 'T' ... 'Z' places to visit, in this order
/// A line that begins with ';' is a comment; "; cell 0.25" states the size of a cell in metres.
/// Without a start the robot stands in the middle of the widest place of the largest enclosed
/// floor. `name` is used in messages; `cell` (m) of more than 0 overrules the file.
/// Throws Error (name:line:column) for an unknown character, or when there is no wall or no floor.
Scene parse_plan(std::string_view text, const std::string& name, double cell = 0);

/// parse_plan() or parse_picture() of a file, told apart by its content. Throws Error when it
/// cannot be read.
Scene read_plan(const std::filesystem::path& path, double cell = 0);

/// A PNG picture: darker than half is wall. `cell` is the size of a pixel in m, 0 for 0.05.
Scene parse_picture(std::string_view png, const std::string& name, double cell = 0);

inline constexpr double kTextCell = 0.5;      // m
inline constexpr double kPictureCell = 0.05;  // m

}  // namespace majak::sim
