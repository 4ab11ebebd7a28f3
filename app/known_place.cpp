// SPDX-License-Identifier: Apache-2.0
#include "app/known_place.hpp"

#include <fmt/core.h>

#include <utility>

#include "majak/core/error.hpp"
#include "majak/io/known_map_files.hpp"
#include "majak/io/number.hpp"
#include "majak/map/segment_map.hpp"

namespace majak::app {

namespace {

localize::PlacePtr place_of(const io::MapInput& input, bool on_segments) {
  if (!input.segments.empty()) return localize::place_of(input.segments);
  if (on_segments && !input.site)
    throw Error("--on segments needs a run or a file of walls, not a picture");
  if (on_segments) return localize::place_of(map::build_segments(*input.site).walls());
  return input.site ? localize::place_of(*input.site) : localize::place_of(*input.known);
}

}  // namespace

KnownPlace read_known_place(const std::string& map, double resolution, const std::string& on) {
  io::MapInput input = io::read_map(map, resolution);
  KnownPlace known{nullptr, std::nullopt, input.T_world_map};
  try {
    known.place = place_of(input, on == "segments");
  } catch (const Error& e) {  // it does not know which file this is
    throw Error(fmt::format("{}: {}", map, e.what()));
  }
  known.site = std::move(input.site);
  return known;
}

Pose2 start_pose(const std::string& text) {
  double v[3] = {};
  const char *p = text.c_str(), *const end = p + text.size();
  for (int i = 0; i < 3 && p != nullptr; ++i) {
    p = io::parse_decimal(p, end, v[i]);
    if (p != nullptr && i < 2) p = *p == ',' ? p + 1 : nullptr;
  }
  const Pose2 pose{v[0], v[1], radians(v[2])};
  if (p != end || !pose.finite())
    throw Error(fmt::format(
        "--start {}: write x, y in m and the heading in degrees, as in 2.5,1,90", text));
  return {pose.x, pose.y, wrap_angle(pose.theta)};
}

}  // namespace majak::app
