// SPDX-License-Identifier: Apache-2.0
#include "majak/localize/scan_feed.hpp"

#include <utility>

namespace majak::localize {
namespace {

constexpr std::size_t kPatience = 20;  // scans that may wait for odometry

Mat3 covariance_of(double translation, double rotation) {
  return Vec3(translation * translation, translation * translation, rotation * rotation)
      .asDiagonal();
}

}  // namespace

void ScanFeed::add(const Event& event) {
  if (const auto* odometry = std::get_if<Odometry>(&event)) {
    odometry_.add(*odometry);
  } else if (const auto* wheels = std::get_if<WheelMotion>(&event)) {
    odometry_.add(*wheels);
  } else if (const auto* scan = std::get_if<Scan>(&event); scan && scan->laser == 0) {
    odometry_.add(*scan);
    waiting_.push_back(*scan);
  }
}

std::optional<FedScan> ScanFeed::next() {
  if (waiting_.empty() || !(ended_ || odometry_.ready(handed_out_) || waiting_.size() > kPatience))
    return std::nullopt;
  FedScan fed{std::move(waiting_.front()), {}, Mat3::Zero(), false};
  waiting_.pop_front();
  before_last_ = std::exchange(last_time_, fed.scan.time);
  if (handed_out_ > 0) {
    if (const auto wheels = odometry_.predict(handed_out_)) {
      fed.by_wheels = true;
      fed.T_previous_robot = wheels->T_previous_robot;
      fed.covariance = covariance_of(wheels->sigma_translation, wheels->sigma_rotation);
    } else {
      const auto habit = habit_.predict(last_time_ - before_last_);
      fed.T_previous_robot = habit.T_previous_robot;
      fed.covariance = covariance_of(habit.sigma_translation, habit.sigma_rotation);
    }
  }
  ++handed_out_;
  return fed;
}

void ScanFeed::observe(const Pose2& T_previous_robot, bool trusted) {
  if (handed_out_ < 2) return;
  odometry_.observe(handed_out_ - 1, T_previous_robot, trusted);
  if (trusted)
    habit_.observe(T_previous_robot, last_time_ - before_last_, true);
  else
    habit_.forget();
}

}  // namespace majak::localize
