// SPDX-License-Identifier: Apache-2.0
#include "majak/localize/tracking_errors.hpp"

#include <algorithm>
#include <cmath>

namespace majak::localize {
namespace {

constexpr double kScanGain = 0.06;        // of a scan that is learnt from, in a running mean
constexpr double kWheelGain = 0.02;       // of any scan that fits
constexpr double kReturnsMemory = 0.998;  // share of a sum that is left after the next scan
constexpr double kStepsMemory = 0.98;
constexpr double kOffsetGain = 0.002;
constexpr double kEnough = 500;  // returns of a kind, before they tell of the noise
constexpr double kLeast = 0.05;  // share of the surface's own variance

void follow(match::Spread& sum, const match::Spread& seen) {
  sum.weight = kReturnsMemory * sum.weight + seen.weight;
  sum.square = kReturnsMemory * sum.square + seen.square;
  sum.cos2 = kReturnsMemory * sum.cos2 + seen.cos2;
}

}  // namespace

Mat3 TrackingErrors::share(double place, double turn, const Mat3& claimed) {
  const double p = std::sqrt(place);
  const Mat3 s = Vec3(p, p, std::sqrt(turn)).asDiagonal();
  return s * claimed * s;
}

void TrackingErrors::learn_scan(const match::Jackknife& seen, double offset) {
  const double claimed = seen.claimed(0, 0) + seen.claimed(1, 1);
  if (!(claimed > 0 && seen.claimed(2, 2) > 0)) return;
  const double shown = seen.covariance(0, 0) + seen.covariance(1, 1);
  scan_place_ += kScanGain * (shown / claimed - scan_place_);
  scan_turn_ += kScanGain * (seen.covariance(2, 2) / seen.claimed(2, 2) - scan_turn_);
  learn_returns(seen);
  learn_ranges(seen, offset);
}

void TrackingErrors::learn_wheels(const Vec3& correction, const Mat3& claimed) {
  const double place = claimed(0, 0) + claimed(1, 1), turn = claimed(2, 2);
  if (!(place > 0 && turn > 0)) return;
  wheel_place_ += kWheelGain * (correction.head<2>().squaredNorm() / place - wheel_place_);
  wheel_turn_ += kWheelGain * (correction.z() * correction.z() / turn - wheel_turn_);
}

// r^2 = beam cos^2 + surface, from two kinds of returns.
void TrackingErrors::learn_returns(const match::Jackknife& seen) {
  follow(head_on_, seen.head_on);
  follow(grazing_, seen.grazing);
  if (head_on_.weight < kEnough || grazing_.weight < kEnough) return;
  const double head_on = head_on_.square / head_on_.weight;
  const double cos2 = head_on_.cos2 / head_on_.weight;
  const double less = head_on - grazing_.square / grazing_.weight;
  const double beam = std::max(0.0, less / (cos2 - grazing_.cos2 / grazing_.weight));
  const double all = head_on + beam * (1 - cos2);
  if (!(all > 0)) return;
  returns_.surface = std::max(kLeast, 1 - beam / all);
  returns_.beam = 1 - returns_.surface;
}

void TrackingErrors::learn_ranges(const match::Jackknife& seen, double offset) {
  steps_ = kStepsMemory * steps_ + seen.steps;
  steps_weight_ = kStepsMemory * steps_weight_ + seen.steps_weight;
  scans_ += 1;
  const double gain = std::max(1 / scans_, kOffsetGain), off = offset - offset_mean_;
  offset_mean_ += gain * off;
  offset_variance_ += gain * ((1 - gain) * off * off - offset_variance_);
  const double step = steps_weight_ > 0 ? std::max(0.0, steps_ / steps_weight_) : 0;
  of_ranges_ = (step + offset_variance_) * seen.by_step;
}

}  // namespace majak::localize
