// SPDX-License-Identifier: Apache-2.0
#include "majak/localize/plausibility.hpp"

#include <algorithm>
#include <cmath>

namespace majak::localize {
namespace {

constexpr int kMemory = 8;  // looks that the misfit is the mean of
constexpr std::size_t kLeastReturns = 10;
constexpr double kLeap = 0.75, kLeapTurn = 0.35;  // m, rad

}  // namespace

void Plausibility::add(const FedScan& scan, const Pose2& T_map_robot) {
  const Pose2 leap = between(T_map_robot_ * scan.T_previous_robot, T_map_robot);
  T_map_robot_ = T_map_robot;
  if (leap.translation().norm() > kLeap || std::abs(leap.theta) > kLeapTurn) {
    looks_ = 0;
    accepted_ = false;
  }
  way_ += scan.T_previous_robot.translation().norm();
  turned_ += std::abs(scan.T_previous_robot.theta);
  if (looks_ > 0 && way_ < options_.step && turned_ < options_.turn) return;
  const match::Beams beams = match::beams(scan.scan);
  if (beams.returns < kLeastReturns) return;
  way_ = turned_ = 0;
  ++looks_;
  const double misfit = pose_fit(*place_, beams, T_map_robot).misfit();
  if (looks_ == 1) misfit_ = 0;
  misfit_ += (misfit - misfit_) / std::min(looks_, kMemory);
  accepted_ = accepted_ || (looks_ >= options_.probation && misfit_ < options_.good);
}

Health Plausibility::at_best() const {
  if (misfit_ > options_.lost && looks_ >= options_.least) return Health::lost;
  return misfit_ > options_.poor || !accepted_ ? Health::degraded : Health::ok;
}

void Plausibility::limit(Estimate& estimate) const {
  estimate.health = std::max(estimate.health, at_best());
}

void describe(OptionFields& f, PlausibilityOptions& o) {
  f.add("plausibility.step", o.step, {"m", "driven between two looks", 0, 10});
  f.add("plausibility.turn", o.turn, {"rad", "or turned", 0, 4});
  f.add("plausibility.probation", o.probation,
        {"1", "looks at least before a place just found is called ok", 1, 1000});
  f.add("plausibility.good", o.good, {"1", "mean misfit that they must come to", 0, 1.5});
  f.add("plausibility.least", o.least, {"1", "looks before a place is given up", 1, 1000});
  f.add("plausibility.poor", o.poor,
        {"1", "mean misfit from which on the health is degraded", 0, 1.5});
  f.add("plausibility.lost", o.lost,
        {"1", "mean misfit from which on the place is given up", 0, 1.5});
}

}  // namespace majak::localize
