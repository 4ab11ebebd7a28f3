// SPDX-License-Identifier: Apache-2.0
// A hall that looks like itself nowhere, and what a laser sees in it.
#pragma once

#include "majak/core/event.hpp"
#include "majak/localize/place.hpp"
#include "tests/support/ascii_map.hpp"

namespace majak::fixture {

inline map::KnownMap twice_as_fine(const map::KnownMap& map) {
  map::KnownMap fine = map;
  fine.resolution /= 2, fine.width *= 2, fine.height *= 2;
  fine.cells.clear();
  for (int iy = 0; iy < fine.height; ++iy)
    for (int ix = 0; ix < fine.width; ++ix) fine.cells.push_back(map.at(ix / 2, iy / 2));
  return fine;
}

/// 12 x 5.2 m.
inline const localize::PlacePtr& hall() {
  static const localize::PlacePtr place =
      localize::place_of(twice_as_fine(ascii_map({"##############################",  //
                                                  "#............#...............#",  //
                                                  "#............#...............#",  //
                                                  "#............#...............#",  //
                                                  "#............#......###......#",  //
                                                  "#...................###......#",  //
                                                  "#............................#",  //
                                                  "#............................#",  //
                                                  "####.........#...............#",  //
                                                  "   #.........#...............#",  //
                                                  "   #.........######..#########",  //
                                                  "   #.........#    #..#        ",  //
                                                  "   ###########    ####        "},
                                                 0.4)));
  return place;
}

/// All around from a laser at the robot's middle, without noise.
inline Scan seen_from(const Pose2& T_map_robot, int beams = 120) {
  Scan scan;
  scan.start_angle = -kPi;
  scan.angle_step = 2 * kPi / beams;
  scan.max_range = 8;
  for (int i = 0; i < beams; ++i) {
    const double angle = T_map_robot.theta + scan.angle(static_cast<std::size_t>(i));
    const double range =
        hall()->distances.cast(T_map_robot.translation(), {std::cos(angle), std::sin(angle)}, 8);
    scan.ranges.push_back(range < 8 ? static_cast<float>(range) : kNoReturn);
  }
  return scan;
}

}  // namespace majak::fixture
