// SPDX-License-Identifier: Apache-2.0
// How much do scans, wheels and the laser err on this map? Learnt while tracking, from what the
// residuals and the corrections of the scans do; no number of any laser, map or robot is told.
#pragma once

#include "majak/core/pose2.hpp"
#include "majak/match/jackknife.hpp"
#include "majak/match/point_to_line.hpp"

namespace majak::localize {

class TrackingErrors {
 public:
  /// After a scan that fits. `offset`: m, by which the laser reads too long, as known by now.
  void learn_scan(const match::Jackknife& seen, double offset);
  /// By how much a scan moved the pose that the wheels had predicted, and by how much it would have
  /// if `claimed` were right (covariances of the prediction less that of the pose).
  void learn_wheels(const Vec3& correction, const Mat3& claimed);

  /// The covariance that a scan gives to a pose, from that which matching claims.
  Mat3 of_scan(const Mat3& claimed) const { return share(scan_place_, scan_turn_, claimed); }
  /// The same for a step of the wheels.
  Mat3 of_wheels(const Mat3& claimed) const { return share(wheel_place_, wheel_turn_, claimed); }
  /// Of the pose, because the laser's error changes with the range: the next scan does not make it
  /// less.
  const Mat3& of_ranges() const { return of_ranges_; }
  /// How a return's variance depends on its incidence.
  const match::ReturnNoise& returns() const { return returns_; }

 private:
  static Mat3 share(double place, double turn, const Mat3& claimed);
  void learn_returns(const match::Jackknife& seen);
  void learn_ranges(const match::Jackknife& seen, double offset);

  double scan_place_ = 1, scan_turn_ = 1, wheel_place_ = 1, wheel_turn_ = 1;  // of variances
  match::Spread head_on_, grazing_;
  match::ReturnNoise returns_;
  double steps_ = 0, steps_weight_ = 0;                       // of the error over ranges
  double scans_ = 0, offset_mean_ = 0, offset_variance_ = 0;  // m, m^2, from place to place
  Mat3 of_ranges_ = Mat3::Zero();
};

}  // namespace majak::localize
