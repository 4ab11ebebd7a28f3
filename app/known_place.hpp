// SPDX-License-Identifier: Apache-2.0
// The known map that a command is given, and a start on it.
#pragma once

#include <optional>
#include <string>

#include "majak/core/pose2.hpp"
#include "majak/core/site.hpp"
#include "majak/localize/place.hpp"

namespace majak::app {

struct KnownPlace {
  localize::PlacePtr place;
  std::optional<Site> site;  ///< where it is a run's
  Pose2 T_world_map;         ///< of a map file whose picture lies turned
};

/// resolution: m a pixel, of a bare picture. Throws Error that names the file.
/// `on`: "grid", or "segments" for those of a run; a file of walls is always segments.
KnownPlace read_known_place(const std::string& map, double resolution,
                            const std::string& on = "grid");

/// "x,y,degrees". Throws Error.
Pose2 start_pose(const std::string& text);

}  // namespace majak::app
