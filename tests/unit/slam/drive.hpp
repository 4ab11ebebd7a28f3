// SPDX-License-Identifier: Apache-2.0
// Key scans of a drive through an ASCII room, with the drift that a front end has.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "majak/slam/key_scan.hpp"
#include "tests/support/ascii_room.hpp"

namespace majak::slam {

/// A corridor around a block; no side looks like another.
inline const fixture::AsciiRoom& ring() {
  static const fixture::AsciiRoom r({
      "##############################", "###......#.............#######",
      "##..........................##", "##.a........................##",
      "##.......................b..##", "##......###########.........##",
      "#.......###########......#####", "#......############.....######",
      "##.....############.....######", "##.....###########.........###",
      "###....###########..........##", "###....###########.........###",
      "##.....###########......######", "##.....#####.#####......######",
      "##..........................##", "##..d.......................##",
      "##.......................c..##", "####......#..........#......##",
      "####......#..........#....####", "##############################",
  });
  return r;
}

/// What the front end drifts by.
struct Drift {
  double scale = 1.005;
  double turn = 0.002;  ///< rad a metre
};

struct Drive {
  KeyScans keys;
  std::vector<Pose2> truth;

  Pose2 error(std::size_t key) const {
    return between(between(truth[0], truth[key]),
                   between(keys[0].T_map_robot, keys[key].T_map_robot));
  }
};

/// From place to place, straight on and turning on the spot, a key scan every quarter metre or 10
/// degrees.
inline Drive drive(const fixture::AsciiRoom& room, const std::string& places,
                   const Drift& drift = {}) {
  Drive d;
  fixture::Laser laser;
  laser.noise = 0.005;
  const auto add = [&](const Pose2& T) {
    KeyScan key;
    key.scan = d.keys.size();
    laser.seed = static_cast<int>(key.scan) + 1;
    key.points = match::scan_points(room.scan(T, laser), {}, true);
    if (!d.truth.empty()) {
      Vec3 step = log(between(d.truth.back(), T));
      step.z() += drift.turn * step.head<2>().norm();
      step.head<2>() *= drift.scale;
      key.T_previous_predicted = exp(step);
      key.T_front_robot = d.keys.back().T_front_robot * key.T_previous_predicted;
    }
    key.T_map_robot = key.T_front_robot;
    key.match_information = key.motion_information = Vec3(1e5, 1e5, 1e6).asDiagonal();
    d.keys.push_back(key);
    d.truth.push_back(T);
  };
  Pose2 at = room.pose(places[0]);
  for (std::size_t i = 1; i < places.size(); ++i) {
    const Vec2 way = room.place(places[i]) - at.translation();
    const double heading = std::atan2(way.y(), way.x()),
                 turn = i == 1 ? 0 : angle_diff(heading, at.theta);
    const int turns = static_cast<int>(std::abs(turn) / 0.17);
    for (int k = 1; k <= turns; ++k)
      add({at.x, at.y, wrap_angle(at.theta + turn * k / (turns + 1))});
    const int steps = static_cast<int>(way.norm() / 0.25);
    for (int k = 0; k < steps; ++k) {
      const Vec2 p = at.translation() + way * k / steps;
      add({p.x(), p.y(), heading});
    }
    at = {room.place(places[i]).x(), room.place(places[i]).y(), heading};
  }
  return d;
}

}  // namespace majak::slam
