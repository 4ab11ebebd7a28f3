// SPDX-License-Identifier: Apache-2.0
// Edit: one correction that a person made to a map. Edits are kept beside what was measured and are
// applied when the map is used (map/edits), so that each can be undone and a new optimisation loses
// none of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "majak/core/pose2.hpp"

namespace majak {

enum class EditKind : std::uint8_t {
  erase,        ///< polygon: returns inside do not count, such as traces of people
  wall,         ///< a line from point to point where nothing may be missing, such as glass
  forbidden,    ///< polygon where a robot must not go
  crop,         ///< polygon: only returns inside count
  turn,         ///< the whole map, about its origin
  closure_off,  ///< a closure that is not to be used
};
inline constexpr int kEditKinds = 6;

/// "erase", "wall", "forbidden", "crop", "turn", "closure_off".
constexpr const char* name_of(EditKind kind) {
  constexpr const char* kNames[kEditKinds] = {"erase", "wall", "forbidden",
                                              "crop",  "turn", "closure_off"};
  return kNames[static_cast<int>(kind)];
}

/// A point of the map as the robot saw it at a scan: when that scan's pose changes, it goes along.
struct AnchoredPoint {
  std::size_t scan = 0;         ///< index into Site::scans
  Vec2 p_robot = Vec2::Zero();  ///< m, in the frame of the robot there
  bool operator==(const AnchoredPoint&) const = default;
};

struct Edit {
  std::int64_t id = 0;  ///< larger than those of all edits before it
  EditKind kind = EditKind::erase;
  std::vector<AnchoredPoint> points;  ///< of polygons and lines, each on a key scan near it
  double radians = 0;                 ///< of a turn, counter-clockwise
  std::size_t from = 0, to = 0;       ///< of a closure: indices into Site::scans
  bool operator==(const Edit&) const = default;
};

}  // namespace majak
