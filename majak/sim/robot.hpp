// SPDX-License-Identifier: Apache-2.0
// A robot that drives along a path: where it truly is at any time, and where its wheels make it
// believe it is.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "majak/core/options.hpp"
#include "majak/core/time.hpp"
#include "majak/motion/drive.hpp"
#include "majak/sim/tour.hpp"

namespace majak::sim {

enum class DriveKind : std::uint8_t { differential, ackermann, omnidirectional };

struct RobotOptions {
  DriveKind drive = DriveKind::differential;
  double speed = 0.6;                 ///< m/s, at most
  double acceleration = 0.5;          ///< m/s^2
  double turn_rate = 1.0;             ///< rad/s, at most
  double track = 0.4;                 ///< m, differential
  double wheelbase = 0.4;             ///< m, Ackermann
  double max_steering = radians(40);  ///< rad, Ackermann
  double arm = 0.25;                  ///< m, omnidirectional

  // Systematic: what the odometry believes per true value. 1 is right.
  double left_scale = 1;   ///< left wheel; the one wheel of an Ackermann; wheel 1 of an omni drive
  double right_scale = 1;  ///< right wheel; wheels 2 and 3 of an omni drive
  double track_scale = 1;  ///< track, wheelbase or arm
  double steering_scale = 1;   ///< of the steering sensor, Ackermann
  double steering_offset = 0;  ///< rad, Ackermann
  // Systematic, drawn once a run: one sigma.
  double scale_sigma = 0.005;     ///< common to all wheels
  double unequal_sigma = 0.001;   ///< each wheel on its own
  double track_sigma = 0.01;      ///< of the track, wheelbase or arm
  double steering_sigma = 0.002;  ///< rad, offset of the steering sensor
  // Random: sigma grows with the root of the way rolled.
  double slip = 0.005;            ///< m per sqrt(m), each wheel
  double steering_noise = 0.002;  ///< rad, each reading, Ackermann
  double encoder_step = 0.0005;   ///< m rolled a tick, 0 for none

  int slips = 0;                  ///< times at which the wheels turn more than the robot moves
  int bumps = 0;                  ///< times at which something pushes the robot
  bool wrong_direction = false;   ///< the odometry counts the way it backs as a way ahead
  double steering_stuck_at = 0;   ///< s from the start: the sensor stays at its last reading ...
  double steering_stuck_for = 0;  ///< s, ... for so long; 0: it never sticks
  /// Ackermann: the robot reports the speed of its fixed axle, where the encoder then sits, and its
  /// steering, but no poses.
  bool reports_steering = false;
};
void describe(OptionFields& fields, RobotOptions& options);

/// No wheel noise at all: the odometry is right.
RobotOptions perfect_wheels(RobotOptions options = {});

/// The state at one tick; the twist is held until the next one, so the way between is an arc.
struct RobotState {
  Pose2 T_world_robot;
  Vec3 twist;            ///< m/s, m/s, rad/s in the robot's axes
  Pose2 T_odom_robot;    ///< starts at zero
  double speed = 0;      ///< m/s, as the wheels say, averaged over a quarter of a second
  double turn_rate = 0;  ///< rad/s, as the wheels say
  double rolled = 0;     ///< m, way ahead that the wheels have counted so far
  double steered = 0;    ///< rad, sum of all ticks' readings of the steering so far
};

/// What the wheels counted and the robot did not do (slip), or the other way round (bump).
struct Disturbance {
  Duration begin = 0, end = 0;  ///< from the start of the run
  bool bump = false;
  Vec3 twist = Vec3::Zero();  ///< m, m, rad in all
};

/// A finished drive.
class RobotRun {
 public:
  static constexpr Duration kTick = kSecond / 50;

  explicit RobotRun(std::vector<RobotState> states, std::vector<Disturbance> disturbances = {})
      : states_(std::move(states)), disturbances_(std::move(disturbances)) {}

  Duration duration() const { return static_cast<Duration>(states_.size() - 1) * kTick; }
  /// Times are counted from the start and held to [0, duration].
  Pose2 truth(Duration time) const;
  Pose2 odometry(Duration time) const;
  /// What the wheels' counter shows, m, and the readings of the steering added up, rad s.
  Vec2 counted(Duration time) const;
  const RobotState& state(Duration time) const { return states_[index(time)]; }
  const std::vector<RobotState>& states() const { return states_; }
  double path_length() const;  ///< m, of the truth
  const std::vector<Disturbance>& disturbances() const { return disturbances_; }

 private:
  std::size_t index(Duration time) const;
  std::vector<RobotState> states_;
  std::vector<Disturbance> disturbances_;
};

/// Drives the path from its first point to its last. Throws Error when the robot cannot follow it.
RobotRun drive_path(const Path& path, const RobotOptions& options, std::uint64_t seed);

}  // namespace majak::sim
