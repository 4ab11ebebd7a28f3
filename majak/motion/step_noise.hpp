// SPDX-License-Identifier: Apache-2.0
// Noise of steps that wheels and laser both have seen: the laser errs at each pose anew, the wheels
// by a random walk. Neighbouring steps share a pose, so their errors hang together; this is undone
// exactly, as a Kalman filter does it (docs/MATH.md "Calibration").
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "majak/core/pose2.hpp"
#include "majak/motion/seen_steps.hpp"

namespace majak::motion {

/// The defaults are what is usual.
struct StepNoise {
  double laser_translation = 0.003, laser_rotation = 0.0015;  ///< m, rad of a pose, each axis
  double ahead = 0.01;                                        ///< m per sqrt(m) rolled
  double aside = 0.005;                                       ///< m per sqrt(m)
  double turn_of_way = 0.01;                                  ///< rad per sqrt(m)
  double turn_of_turn = 0.01;                                 ///< rad per sqrt(rad)

  double jitter = 0.003;  ///< s (or scans) between the stamps of a pose by laser and wheels

  /// Of a pose between two steps.
  Mat3 pose(const Vec3& velocity, const Vec3& doubt) const;
  Mat3 wheels(double way, double turn) const;
};

/// The errors as independent innovations, and what they say of the wheels.
class WhitenedSteps {
 public:
  /// A step whose normalised square is above `gate` is taken for broken.
  WhitenedSteps(const std::vector<SeenStep>& steps, const StepNoise& noise,
                double gate = std::numeric_limits<double>::infinity());

  /// Anew with another noise; the steps are those of the constructor.
  void weigh(const std::vector<SeenStep>& steps, const StepNoise& noise,
             double gate = std::numeric_limits<double>::infinity());

  std::size_t size() const { return steps_.size(); }
  const Vec3& innovation(std::size_t i) const { return steps_[i].v; }
  /// Its normalised square; chi-square with 3 degrees of freedom if the noise is right.
  double nis(std::size_t i) const { return steps_[i].nis; }
  bool broken(std::size_t i) const { return steps_[i].broken; }
  const Mat3& weight(std::size_t i) const { return steps_[i].S_inverse; }
  /// Turns the rows of step i into those of its innovation; `before`: the turned rows of step i
  /// - 1.
  template <class Rows>
  Rows whiten(std::size_t i, const Rows& rows, const Rows& before) const {
    return rows - steps_[i].gain * before;
  }
  /// The wheels' part of each error, the mean of what it can be after all is seen.
  std::vector<Vec3> wheel_errors() const;
  double log_likelihood() const;

 private:
  struct Step {
    Vec3 error, v;
    Mat3 S_inverse, gain;
    Mat3 Q, A;               ///< of the wheels; Ad(step^-1)
    Mat3 B_before, B_after;  ///< what interpolation shares out at its ends
    double log_det = 0, nis = 0;
    bool broken = false;
  };
  std::vector<Step> steps_;
};

/// How finely the noise is sought: by this factor at first, at last by one above `last`.
struct NoiseSearch {
  double first = 2, last = 1.03;
};

/// The most likely noise, from `start`.
StepNoise learn_noise(const std::vector<SeenStep>& steps, const StepNoise& start,
                      const NoiseSearch& search = {});

}  // namespace majak::motion
