// SPDX-License-Identifier: Apache-2.0
// Pilot: which twist keeps a robot of a given drive on its path. Looks half a metre ahead (a car: a
// wheelbase) and drives the arc that leads there (pure pursuit, Coulter 1992); where the path turns
// sharply, a differential drive backs out and spins, a car shunts to and fro.
#pragma once

#include "majak/sim/robot.hpp"

namespace majak::sim {

class Pilot {
 public:
  Pilot(const Path& path, const RobotOptions& options) : path_(path), options_(options) {}

  /// The twist (m/s, m/s, rad/s) to hold for the next `dt` seconds. Obeys speed, acceleration,
  /// turn rate and steering limits.
  Vec3 next_twist(const Pose2& T_world_robot, double dt);

  /// At the end of the path, and at rest.
  bool finished() const { return arrived_ && twist_.norm() < 1e-9; }

 private:
  enum class Mode { follow, back_out, spin, shunt };

  void advance(const Vec2& here);
  Vec3 pursue(double heading_error, double distance, double dt);
  Vec3 turn_on_the_spot(double heading_error, double dt);
  Vec3 shunt(double heading_error, double dt);
  Vec3 slide(double heading_error, double dt);
  double approach(double value, double goal, double step) const;
  double speed_allowed() const;

  const Path& path_;
  const RobotOptions& options_;
  Mode mode_ = Mode::follow;
  std::size_t at_ = 0;  ///< index of the path's point that was passed last
  bool arrived_ = false;
  Vec3 twist_ = Vec3::Zero();
  double steering_ = 0;   ///< rad, Ackermann
  double turn_sign_ = 1;  ///< the way round, chosen once a turn
  double gear_ = -1;      ///< of a shunt
  double driven_ = 0;     ///< m in this gear
};

}  // namespace majak::sim
