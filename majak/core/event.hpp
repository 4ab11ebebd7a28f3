// SPDX-License-Identifier: Apache-2.0
// Event: one thing that the robot reported at one time.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "majak/core/pose2.hpp"
#include "majak/core/time.hpp"

namespace majak {

/// A beam that met nothing within the sensor's range.
inline constexpr float kNoReturn = std::numeric_limits<float>::infinity();
/// A beam of which nothing is known (damaged value, dazzled, masked).
inline constexpr float kInvalidRange = std::numeric_limits<float>::quiet_NaN();

/// In a site whose edits are applied, a range below zero: free so far, but what ended the beam does
/// not count, because a person erased it.
constexpr float erased(float range) { return -range; }

/// One turn of a 2-D laser. Beam i points to start_angle + i * angle_step in the laser's frame
/// (x ahead, counter-clockwise positive) and was fired at time + beam_time(i).
struct Scan {
  Time time = 0;                      ///< the log's own stamp
  double start_angle = 0;             ///< rad, direction of beam 0
  double angle_step = 0;              ///< rad between neighbouring beams
  float max_range = 0;                ///< m; returns lie strictly below
  Pose2 T_robot_laser;                ///< mounting
  int laser = 0;                      ///< 0 front, 1 rear, ... as the log numbers them
  std::vector<float> ranges;          ///< m; kNoReturn and kInvalidRange are not finite; erased()
  std::vector<float> intensities;     ///< raw units, empty or one a beam
  std::optional<Pose2> T_odom_robot;  ///< odometry that the log states in the scan's own record

  double angle(std::size_t beam) const {
    return start_angle + static_cast<double>(beam) * angle_step;
  }
};

/// The robot's own dead reckoning.
struct Odometry {
  Time time = 0;
  Pose2 T_odom_robot;
  std::optional<double> speed;      ///< m/s along x, as the log states it
  std::optional<double> turn_rate;  ///< rad/s, as the log states it
};

/// Wheel speed and steering of an Ackermann drive.
struct WheelMotion {
  Time time = 0;
  double speed = 0;     ///< m/s forward at the middle of the rear axle
  double steering = 0;  ///< rad, left positive
};

/// A satellite fix in the plane, metres in a local frame.
struct GpsFix {
  Time time = 0;
  double east = 0;   ///< m
  double north = 0;  ///< m
  double sigma = 0;  ///< m, standard deviation of each axis; 0 where the receiver does not say
};

/// A beacon that a sensor on the robot has seen: how far off, in which direction, or both.
struct BeaconSighting {
  Time time = 0;
  int beacon = -1;                ///< its number; -1 where it does not say who it is
  std::optional<double> range;    ///< m from the sensor
  std::optional<double> bearing;  ///< rad in the sensor's frame, counter-clockwise from ahead
  double range_sigma = 0;         ///< m
  double bearing_sigma = 0;       ///< rad
  Pose2 T_robot_sensor;           ///< mounting
};

/// Where the robot really was (simulator, or a reference system).
struct Truth {
  Time time = 0;
  Pose2 T_world_robot;
};

using Event = std::variant<Scan, Odometry, WheelMotion, GpsFix, BeaconSighting, Truth>;

inline Time time_of(const Event& event) {
  return std::visit([](const auto& e) { return e.time; }, event);
}

}  // namespace majak
