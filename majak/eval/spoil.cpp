// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/spoil.hpp"

#include <cmath>
#include <optional>

#include "majak/core/random.hpp"

namespace majak::eval {
namespace {

/// One chain of odometry poses, its steps disturbed one by one.
class WornChain {
 public:
  WornChain(double factor, const WheelWear& wear, std::uint64_t seed, std::uint64_t chain)
      : factor_(factor), wear_(wear), seed_(seed), chain_(chain) {
    scale_ = 1 + factor * wear.scale * RandomStream(seed, chain).normal();
  }

  Pose2 operator()(const Pose2& T_odom_robot) {
    if (before_)
      worn_ = worn_ * disturbed(between(*before_, T_odom_robot));
    else
      worn_ = T_odom_robot;
    before_ = T_odom_robot;
    return worn_;
  }

 private:
  Pose2 disturbed(Pose2 step) {
    RandomStream random(seed_, chain_ + 2, ++steps_);
    const double way = std::sqrt(step.translation().norm()), turn = std::sqrt(std::abs(step.theta));
    step.x = scale_ * step.x + factor_ * wear_.way * way * random.normal();
    step.y = scale_ * step.y + factor_ * wear_.way * way * random.normal();
    step.theta +=
        factor_ * (wear_.turn * way * random.normal() + wear_.spin * turn * random.normal());
    return step;
  }

  double factor_, scale_ = 1;
  WheelWear wear_;
  std::uint64_t seed_, chain_, steps_ = 0;
  std::optional<Pose2> before_;
  Pose2 worn_;
};

}  // namespace

std::vector<Event> with_worn_wheels(std::vector<Event> events, double factor, std::uint64_t seed,
                                    const WheelWear& wear) {
  WornChain records(factor, wear, seed, 0), scans(factor, wear, seed, 1);
  const double scale = 1 + factor * wear.scale * RandomStream(seed).normal();
  for (Event& event : events) {
    if (auto* odometry = std::get_if<Odometry>(&event)) {
      odometry->T_odom_robot = records(odometry->T_odom_robot);
    } else if (auto* scan = std::get_if<Scan>(&event); scan && scan->T_odom_robot) {
      scan->T_odom_robot = scans(*scan->T_odom_robot);
    } else if (auto* wheels = std::get_if<WheelMotion>(&event)) {
      wheels->speed *= scale;
    }
  }
  return events;
}

std::vector<Event> with_stray_returns(std::vector<Event> events, double share, std::uint64_t seed) {
  std::uint64_t scans = 0;
  for (Event& event : events) {
    auto* scan = std::get_if<Scan>(&event);
    if (!scan) continue;
    RandomStream random(seed, ++scans);
    for (float& range : scan->ranges)
      if (std::isfinite(range) && random.uniform() < share)
        range *= static_cast<float>(random.uniform(0.05, 1));
  }
  return events;
}

std::vector<Event> without_wheels(std::vector<Event> events) {
  std::erase_if(events, [](const Event& event) {
    return std::holds_alternative<Odometry>(event) || std::holds_alternative<WheelMotion>(event);
  });
  for (Event& event : events)
    if (auto* scan = std::get_if<Scan>(&event)) scan->T_odom_robot.reset();
  return events;
}

std::vector<Event> first_part(std::vector<Event> events, double share) {
  if (share >= 1) return events;
  const auto is_scan = [](const Event& event) { return std::holds_alternative<Scan>(event); };
  std::size_t scans = 0, kept = 0;
  for (const Event& event : events) scans += is_scan(event);
  const auto most = static_cast<std::size_t>(std::ceil(share * static_cast<double>(scans)));
  std::size_t end = 0;
  while (end < events.size() && kept < most) kept += is_scan(events[end++]);
  events.resize(end);
  return events;
}

}  // namespace majak::eval
