// SPDX-License-Identifier: Apache-2.0
#include "app/named_rooms.hpp"

#include <fmt/core.h>

#include <optional>

#include "majak/core/error.hpp"
#include "majak/io/known_map_files.hpp"
#include "majak/io/number.hpp"
#include "majak/io/topology_files.hpp"
#include "majak/map/edits.hpp"
#include "majak/map/occupancy_grid.hpp"

namespace majak::app {
namespace {

std::optional<Vec2> parse_point(const std::string& text) {
  double v[2] = {};
  const char *p = text.c_str(), *const end = p + text.size();
  for (int i = 0; i < 2 && p != nullptr; ++i) {
    p = io::parse_decimal(p, end, v[i]);
    if (p != nullptr && i < 1) p = *p == ',' ? p + 1 : nullptr;
  }
  const Vec2 point(v[0], v[1]);
  if (p != end || !point.allFinite()) return std::nullopt;
  return point;
}

}  // namespace

NamedRooms read_named_rooms(const std::string& run, const map::TopologyOptions& options) {
  const io::MapInput input = io::read_map(run);
  NamedRooms rooms;
  rooms.known = input.site ? map::known_map(map::build_occupancy_grid(*input.site)) : *input.known;
  rooms.topology = map::build_topology(rooms.known, options);
  rooms.labels = io::read_labels(labels_path(run));
  rooms.names = map::room_names(rooms.topology, rooms.labels);
  rooms.allowed = rooms.known;
  if (input.site) map::forbid(rooms.allowed, *input.site);
  return rooms;
}

std::filesystem::path labels_path(const std::filesystem::path& run) {
  return (std::filesystem::is_directory(run) ? run : run.parent_path()) / "labels.json";
}

bool looks_like_point(const std::string& text) { return parse_point(text).has_value(); }

Vec2 point_in(const std::string& text, const std::string& what) {
  if (const auto point = parse_point(text)) return *point;
  throw Error(fmt::format("{} {}: write x, y in m, as in 2.5,1", what, text));
}

}  // namespace majak::app
