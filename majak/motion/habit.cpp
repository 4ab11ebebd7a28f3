// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/habit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace majak::motion {
namespace {

constexpr double kMemory = 0.02;               // share of the newest error in the mean
constexpr double kFirst = 0.05 * 0.05;         // m^2, rad^2: before anything is known
constexpr double kLeast = 0.01, kMost = 0.05;  // m, rad: bounds of the rms error that is believed
constexpr double kWiden = 2.0;                 // sigma over rms: errors have heavy tails
constexpr double kRatio = 3.0;                 // times longer or shorter intervals are bursts

double sigma_of(double square) { return kWiden * std::clamp(std::sqrt(square), kLeast, kMost); }

}  // namespace

Habit::Habit() {
  translation2_.fill(kFirst);
  rotation2_.fill(kFirst);
}

// By scan from the last motion, by scan from the mean; by time from the last, by time from the
// mean.
std::array<Vec3, 4> Habit::candidates(double time) const {
  if (count_ == 0) return {Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  Vec3 sum = Vec3::Zero();
  double span = 0;
  for (std::size_t i = 0; i < count_; ++i) sum += motions_[i].twist, span += motions_[i].time;
  const Vec3 &last = motions_[0].twist, mean = sum / static_cast<double>(count_);
  const auto stretched = [&](const Vec3& twist, double lasted) {
    const double ratio = lasted > 0 ? time / lasted : 0;
    return ratio > 1 / kRatio && ratio < kRatio ? Vec3(ratio * twist) : twist;
  };
  return {last, mean, stretched(last, motions_[0].time),
          stretched(mean, span / static_cast<double>(count_))};
}

Habit::Prediction Habit::predict(Duration time) const {
  const auto best = [](const std::array<double, 4>& squares) {
    // Equal errors: the last motion by time.
    std::size_t b = 2;
    for (std::size_t i = 0; i < squares.size(); ++i)
      if (squares[i] < squares[b]) b = i;
    return b;
  };
  const auto all = candidates(to_seconds(time));
  const std::size_t t = best(translation2_), r = best(rotation2_);
  const Vec3 twist(all[t].x(), all[t].y(), all[r].z());
  return {exp(twist), sigma_of(count_ == 0 ? kFirst : translation2_[t]),
          sigma_of(count_ == 0 ? kFirst : rotation2_[r])};
}

void Habit::observe(const Pose2& T_previous_robot, Duration time, bool trusted) {
  if (trusted) {
    const auto all = candidates(to_seconds(time));
    for (std::size_t i = 0; i < all.size(); ++i) {
      const Pose2 error = between(exp(all[i]), T_previous_robot);
      const auto learn = [](double& square, double e2) {
        square = square * (1 - kMemory) + kMemory * e2;
      };
      learn(translation2_[i], std::min(0.5 * error.translation().squaredNorm(), kFirst));
      learn(rotation2_[i], std::min(error.theta * error.theta, kFirst));
    }
  }
  std::move_backward(motions_.begin(), motions_.end() - 1, motions_.end());
  motions_[0] = {log(T_previous_robot), to_seconds(time)};
  count_ = std::min(count_ + 1, kKept);
}

void Habit::forget() { count_ = 0; }

}  // namespace majak::motion
