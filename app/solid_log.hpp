// SPDX-License-Identifier: Apache-2.0
// The log of a run once more, for what a second laser, out of the plane, has seen.
#pragma once

#include <optional>
#include <string>

#include "majak/core/site.hpp"
#include "majak/map/solid_points.hpp"

namespace CLI {
class App;
}

namespace majak::app {

struct SolidLog {
  std::string log;   ///< empty: there is none
  std::string look;  ///< "up", "left", ...; empty: as `mounting` says
  std::string tilt;  ///< a file of lines "seconds radians", of a laser that nods
  map::LaserMounting mounting;
  map::SolidPointsOptions points;
};
void describe(OptionFields& fields, SolidLog& log);

void add_solid_log(CLI::App& command, SolidLog& log);

/// Nothing without a log. Throws Error when that laser has no scan in it.
std::optional<map::SolidCloud> read_cloud(const Site& site, const SolidLog& log);

}  // namespace majak::app
