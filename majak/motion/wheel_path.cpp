// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/wheel_path.hpp"

#include <algorithm>
#include <cmath>

namespace majak::motion {

std::vector<WheelSample> wheel_samples(const std::vector<Odometry>& odometry, bool reversed) {
  std::vector<WheelSample> out;
  out.reserve(odometry.size());
  for (std::size_t i = 0; i < odometry.size(); ++i) {
    out.push_back({odometry[i].time, Vec3::Zero(), 0, false});
    if (i == 0) continue;
    Pose2 step = between(odometry[i - 1].T_odom_robot, odometry[i].T_odom_robot);
    if (reversed) step = turned_round(step, odometry[i].speed.value_or(0));
    out.back().jump = leaps(step, std::abs(to_seconds(odometry[i].time - odometry[i - 1].time)));
    if (!out.back().jump) out.back().twist = log(step);
  }
  return out;
}

std::vector<WheelSample> wheel_samples(const std::vector<WheelMotion>& wheels, double wheelbase) {
  std::vector<WheelSample> out;
  out.reserve(wheels.size());
  for (std::size_t i = 0; i < wheels.size(); ++i) {
    out.push_back({wheels[i].time, Vec3::Zero(), 0, false});
    if (i == 0) continue;
    const WheelMotion& held = wheels[i - 1];
    const double way = held.speed * std::max(0.0, to_seconds(wheels[i].time - held.time));
    out.back().steering = held.steering;
    out.back().twist = {way, 0, way * std::tan(held.steering) / wheelbase};
  }
  return out;
}

WheelPath::WheelPath(const std::vector<WheelSample>& samples, const DriveCorrection& correction,
                     double wheelbase)
    : lag_(from_seconds(correction.lag)) {
  times_.reserve(samples.size()), twists_.reserve(samples.size()), points_.reserve(samples.size());
  Point point;
  for (const WheelSample& s : samples) {
    Vec3 raw = s.twist;
    if (wheelbase > 0)
      raw.z() = raw.x() * std::tan(s.steering + correction.steering_offset) / wheelbase;
    const Vec3 twist = corrected(correction, raw);
    times_.push_back(times_.empty() ? s.time : std::max(times_.back(), s.time));
    twists_.push_back(twist);
    point.pose = point.pose * exp(twist);
    point.way += twist.head<2>().norm(), point.turn += std::abs(twist.z());
    point.jumps += s.jump;
    points_.push_back(point);
  }
}

std::optional<WheelPath::Point> WheelPath::at(Time laser_time) const {
  const Time time = laser_time + lag_;
  if (times_.empty() || time < times_.front() || time > times_.back()) return std::nullopt;
  const auto i = static_cast<std::size_t>(std::lower_bound(times_.begin(), times_.end(), time) -
                                          times_.begin());
  Point point = points_[i];
  if (i == 0 || times_[i] == time) return point;
  const double part =
      static_cast<double>(time - times_[i - 1]) / static_cast<double>(times_[i] - times_[i - 1]);
  const Vec3 left = (part - 1) * twists_[i];  // back from the sample after
  point.pose = point.pose * exp(left);
  point.in_jump = point.jumps != points_[i - 1].jumps;
  point.way -= left.head<2>().norm(), point.turn -= std::abs(left.z());
  const double split = part * (1 - part);
  point.split_way = split * twists_[i].head<2>().norm();
  point.split_turn = split * std::abs(twists_[i].z());
  const Vec3& after = twists_[std::min(i + 1, twists_.size() - 1)];
  point.doubt = split * (after - twists_[i - 1]).cwiseAbs();
  return point;
}

}  // namespace majak::motion
