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

/// One or two sentences (plain text): can this map be trusted, and where not.
std::string verdict_in_words(const Site& site, const io::Figures& figures);

}  // namespace majak::draw
