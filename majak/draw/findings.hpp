// SPDX-License-Identifier: Apache-2.0
// What a run found out, in plain words: for the report and for the terminal.
#pragma once

#include <string>
#include <vector>

#include "majak/core/site.hpp"
#include "majak/io/summary.hpp"

namespace majak::draw {

/// Sentences (plain text) on the robot's odometry and the laser's mounting.
std::vector<std::string> odometry_in_words(const Site& site);

/// What people corrected, "3 edits by hand: 2 walls, 1 turn."; empty where nothing.
std::string edits_in_words(const Site& site);

/// A few sentences (plain text): can this map be trusted, and where not; what was corrected.
std::string verdict_in_words(const Site& site, const io::Figures& figures);

}  // namespace majak::draw
