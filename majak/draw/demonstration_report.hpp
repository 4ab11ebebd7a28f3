// SPDX-License-Identifier: Apache-2.0
// report.html of the demonstration: its figures, what they were measured against, the map with
// everything seen on it, errors over time and range, consistency, what happened. One file.
#pragma once

#include <string>

#include "majak/eval/demonstration.hpp"

namespace majak::draw {

struct DemonstrationPage {
  std::string log;      ///< its name, for people
  std::string version;  ///< of the program
};

std::string demonstration_html(const eval::Demonstration& demonstration,
                               const DemonstrationPage& page);

}  // namespace majak::draw
