// SPDX-License-Identifier: Apache-2.0
// How a laser stands on the robot whose scans do not lie in the plane: upright, tilted down at the
// ground ahead, or nodding. A log of the plane does not say it; who made the log does.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "majak/core/options.hpp"
#include "majak/core/pose3.hpp"
#include "majak/core/time.hpp"

namespace majak::map {

/// The laser sweeps the x-y plane of its own frame, beam 0 deg along x, counter-clockwise.
struct LaserMounting {
  int laser = 1;                 ///< as Scan::laser numbers it
  double x = 0, y = 0, z = 0.5;  ///< m, ahead of the robot's point, to its left, above the floor
  double roll = 0;               ///< rad, about the robot's x, the first turn
  double pitch = radians(-90);   ///< rad, about the robot's y, the second; negative looks up
  double yaw = 0;                ///< rad, about the robot's z, the third

  /// `tilt`: rad, added to the pitch; of a nodding laser.
  Pose3 T_robot_laser(double tilt = 0) const {
    return {rotation_of(roll, pitch + tilt, yaw), {x, y, z}};
  }
};

inline void describe(OptionFields& fields, LaserMounting& o) {
  fields.add("mounting.laser", o.laser, {"", "number of the laser out of the plane", 0, 9});
  fields.add("mounting.x", o.x, {"m", "ahead of the robot's point", -10, 10});
  fields.add("mounting.y", o.y, {"m", "to its left", -10, 10});
  fields.add("mounting.z", o.z, {"m", "above the floor", -10, 100});
  fields.add("mounting.roll", o.roll, {"rad", "about the robot's x, first", -3.2, 3.2});
  fields.add("mounting.pitch", o.pitch, {"rad", "about its y, second; negative: up", -3.2, 3.2});
  fields.add("mounting.yaw", o.yaw, {"rad", "about its z, third", -3.2, 3.2});
}

/// "up": sweeps from the robot's right over the ceiling to its left; "left", "right": sweeps from
/// the floor to the ceiling on that side; "down": the plane cuts the ground ahead, 20 deg below
/// level; "level". Everything else as in `mounting`. Throws Error that lists the names.
LaserMounting looking(const std::string& where, LaserMounting mounting = {});

/// The tilt of a nodding laser over time: between two samples it changes evenly.
class TiltTrack {
 public:
  TiltTrack() = default;
  /// Stamps and rad; sorted here, equal stamps keep the first.
  explicit TiltTrack(std::vector<std::pair<Time, double>> samples);
  /// rad; held at the ends, 0 without samples.
  double at(Time time) const;
  bool empty() const { return samples_.empty(); }
  const std::vector<std::pair<Time, double>>& samples() const { return samples_; }

 private:
  std::vector<std::pair<Time, double>> samples_;
};

}  // namespace majak::map
