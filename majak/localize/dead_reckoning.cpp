// SPDX-License-Identifier: Apache-2.0
#include "majak/localize/dead_reckoning.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "majak/motion/drive_correction.hpp"

namespace majak::localize {
namespace {

constexpr double kUnsure = 0.5;             // rad, sigma of the heading (MATH 6.2)
constexpr Duration kLongestHold = kSecond;  // beyond this nobody knows what the wheels did

class DeadReckoning {
 public:
  DeadReckoning(const DeadReckoningOptions& options, const Pose2& start)
      : options_(options),
        T_map_robot_(start),
        by_odometry_(motion::constant_covariance(options.noise)),
        by_wheels_(motion::constant_covariance(options.car, {options.wheelbase})) {}

  std::optional<Estimate> add(const Event& event) {
    if (const auto* odometry = std::get_if<Odometry>(&event)) {
      records_ = false;
      return add_pose(odometry->time, odometry->T_odom_robot);
    }
    if (const auto* wheels = std::get_if<WheelMotion>(&event)) return add_wheels(*wheels);
    const auto* scan = std::get_if<Scan>(&event);
    if (scan == nullptr || !scan->T_odom_robot || !records_) return std::nullopt;
    return add_pose(scan->time, *scan->T_odom_robot);
  }

  Localization finish() { return std::move(result_); }

 private:
  std::optional<Estimate> add_pose(Time time, const Pose2& T_odom_robot) {
    if (last_wheels_) return skip("odometry beside wheel speed and steering: not used");
    if (!T_odom_robot.finite()) return skip("odometry that is no number: left out");
    const auto last = std::exchange(last_pose_, {{time, T_odom_robot}});
    if (!last) return estimate(time);
    const Pose2 step = between(last->second, T_odom_robot);
    if (motion::leaps(step, std::abs(to_seconds(time - last->first))))
      result_.report.count("jump of the odometry: the step is left out");
    else
      move_by_odometry(log(step));
    return estimate(time);
  }

  std::optional<Estimate> add_wheels(const WheelMotion& wheels) {
    if (last_pose_) return skip("wheel speed and steering beside odometry: not used");
    if (!std::isfinite(wheels.speed) || !(std::abs(wheels.steering) < kPi / 2))
      return skip("wheel speed or steering out of all bounds: left out");
    if (last_wheels_ && wheels.time < last_wheels_->time)
      return skip("wheel record older than the one before: left out");
    const auto last = std::exchange(last_wheels_, wheels);
    if (!last) return estimate(wheels.time);
    Duration hold = wheels.time - last->time;
    if (hold > kLongestHold) {
      result_.report.count("gap between wheel records: bridged at constant speed for a second");
      hold = kLongestHold;
    }
    const double way = to_seconds(hold) * 0.5 * (last->speed + wheels.speed);
    const double steering = 0.5 * (last->steering + wheels.steering);
    move_by_wheels({way / std::cos(steering), steering});
    return estimate(wheels.time);
  }

  void move_by_odometry(const Vec3& twist) {
    T_map_robot_ = T_map_robot_ * exp(twist);
    by_odometry_.move(twist, motion::random_part(options_.noise, twist),
                      motion::constant_part(twist));
  }

  void move_by_wheels(const motion::Ackermann::Wheels& wheels) {
    const motion::Ackermann drive{options_.wheelbase};
    const Vec3 twist = drive.forward(wheels);
    T_map_robot_ = T_map_robot_ * exp(twist);
    by_wheels_.move(twist, motion::random_part(options_.car, drive, wheels),
                    drive.by_parameters(wheels));
  }

  Estimate estimate(Time time) {
    Estimate e{.time = time, .T_map_robot = T_map_robot_};
    const auto& uncertainty = last_wheels_ ? by_wheels_ : by_odometry_;
    e.covariance = motion::in_map_axes(uncertainty.covariance(), T_map_robot_.theta);
    if (e.covariance(2, 2) > kUnsure * kUnsure)
      result_.report.count("heading unsure by over 0.5 rad: no ellipse holds the position then");
    if (options_.never_shrink) {
      const double missing = largest_trace_ - e.covariance.trace();
      if (missing > 0) e.covariance.topLeftCorner<2, 2>().diagonal().array() += missing / 2;
      largest_trace_ = std::max(largest_trace_, e.covariance.trace());
    }
    result_.estimates.push_back(e);
    return e;
  }

  std::optional<Estimate> skip(const char* why) {
    result_.report.count(why);
    return std::nullopt;
  }

  DeadReckoningOptions options_;
  Pose2 T_map_robot_;
  motion::PathUncertainty by_odometry_, by_wheels_;  // one of them, whichever the log has
  double largest_trace_ = 0;
  bool records_ = true;  // the scans' own, until there is a stream of odometry
  std::optional<std::pair<Time, Pose2>> last_pose_;
  std::optional<WheelMotion> last_wheels_;
  Localization result_;
};

}  // namespace

void describe(OptionFields& fields, DeadReckoningOptions& o) {
  fields.add("dead_reckoning.wheelbase", o.wheelbase,
             {"m", "of a car that reports speed and steering", 0.05, 20});
  fields.add("dead_reckoning.never_shrink", o.never_shrink,
             {"", "keep the ellipse where a way back would make it smaller again"});
  motion::describe(fields, o.noise);
  motion::describe(fields, o.car);
}

Localizer dead_reckoning(const DeadReckoningOptions& options, const Pose2& start) {
  const auto method = std::make_shared<DeadReckoning>(options, start);
  return {[method](const Event& event) { return method->add(event); },
          [method] { return method->finish(); }};
}

}  // namespace majak::localize
