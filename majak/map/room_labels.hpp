// SPDX-License-Identifier: Apache-2.0
// Names of rooms: by rule, and as people gave them. A name hangs on a place in the map's frame, not
// on the number of a room, so that it survives when the map is made anew.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "majak/map/topology.hpp"

namespace majak::map {

struct RoomLabel {
  std::string text;
  Vec2 at = Vec2::Zero();     ///< m, map frame
  std::vector<Vec2> outline;  ///< of the room when it was named, map frame; may be empty
};

enum class LabelFate : std::uint8_t {
  kept,   ///< its point lies in the room that has most of the old one
  moved,  ///< its point does not (the map was shifted, a wall was moved): the overlap decided
  lost,   ///< no room is there any more
};
const char* name_of(LabelFate fate);

struct LabelMatch {
  int room = -1;
  LabelFate fate = LabelFate::lost;
  double overlap = 0;  ///< share of the old outline's area that is the room's now, 0 ... 1
};

/// One for each label. A room that has at least half of the old outline's floor gets its label;
/// else the room at the label's point, if that has any of the old one's floor or there was no
/// outline.
std::vector<LabelMatch> match_labels(const Topology& topology, std::span<const RoomLabel> labels);

/// "corridor 1", "room 7" (by kind, in order), or what people say; of several labels in one room
/// the last one counts.
std::vector<std::string> room_names(const Topology& topology,
                                    std::span<const RoomLabel> labels = {});

/// Why a room has its kind: "1.8 m wide and 16 times as long", for people.
std::string evidence_of(const Room& room);

/// A label for the room at p. Throws Error where none is.
RoomLabel label_at(const Topology& topology, const Vec2& p_map, std::string text);

}  // namespace majak::map
