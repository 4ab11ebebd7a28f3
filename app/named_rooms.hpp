// SPDX-License-Identifier: Apache-2.0
// The rooms of a run with the names that people gave them (labels.json beside its site.majak).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "majak/core/options.hpp"
#include "majak/map/room_labels.hpp"
#include "majak/map/topology.hpp"

namespace majak::app {

struct NamedRooms {
  map::KnownMap known;
  map::KnownMap allowed;  ///< the same without the zones that are forbidden by hand
  map::Topology topology;
  std::vector<map::RoomLabel> labels;
  std::vector<std::string> names;  ///< one a room
};

/// `run`: a run's folder, its site.majak, or a map file. Throws Error.
NamedRooms read_named_rooms(const std::string& run, const map::TopologyOptions& options = {});

std::filesystem::path labels_path(const std::filesystem::path& run);

/// "2.5,1" as a point in m. Throws Error that names `what`.
Vec2 point_in(const std::string& text, const std::string& what);
bool looks_like_point(const std::string& text);

}  // namespace majak::app
