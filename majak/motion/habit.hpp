// SPDX-License-Identifier: Apache-2.0
// Without odometry: the robot goes on as it went. There are four ways to say so, by time or by scan
// (stamps that come in bursts tell no velocity), from the last motion or from the mean of a few;
// the one that has foretold best is used, and its rms error is how sure it is.
#pragma once

#include <array>
#include <cstddef>

#include "majak/core/pose2.hpp"
#include "majak/core/time.hpp"

namespace majak::motion {

class Habit {
 public:
  Habit();
  struct Prediction {
    Pose2 T_previous_robot;
    double sigma_translation = 0;  ///< m, of each axis
    double sigma_rotation = 0;     ///< rad
  };

  /// Motion up to a scan that comes `time` after the last one.
  Prediction predict(Duration time) const;

  /// The motion that was found then. `trusted`: it tells how good the predictions are.
  void observe(const Pose2& T_previous_robot, Duration time, bool trusted);

  /// What was found is no motion to go on with.
  void forget();

 private:
  static constexpr std::size_t kKept = 4;
  struct Motion {
    Vec3 twist = Vec3::Zero();
    double time = 0;  ///< s
  };
  std::array<Vec3, 4> candidates(double time) const;

  std::array<Motion, kKept> motions_{};  // the newest first
  std::size_t count_ = 0;
  std::array<double, 4> translation2_, rotation2_;  // mean square errors of the candidates
};

}  // namespace majak::motion
