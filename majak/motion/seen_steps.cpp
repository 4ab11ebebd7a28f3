// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/seen_steps.hpp"

#include <algorithm>

namespace majak::motion {

Vec3 velocity_between(const std::vector<Vec3>& twists, const std::vector<SeenStep>& steps,
                      std::size_t i) {
  const std::size_t a = i > 0 ? i - 1 : 0, b = std::min(i, twists.size() - 1);
  return (twists[a] + twists[b]) / (steps[a].seconds + steps[b].seconds);
}

std::vector<SeenStep> seen_steps(const std::vector<LaserPose>& laser,
                                 const std::vector<WheelSample>& wheels,
                                 const DriveCorrection& correction, const Pose2& D,
                                 double wheelbase) {
  const WheelPath path(wheels, correction, wheelbase);
  std::vector<SeenStep> out;
  std::vector<Vec3> twists;
  for (std::size_t i = 1; i < laser.size(); ++i) {
    const auto from = path.at(laser[i - 1].time), to = path.at(laser[i].time);
    if (!from || !to) continue;
    SeenStep step;
    step.wheels = D.inverse() * between(from->pose, to->pose) * D;
    step.laser = between(laser[i - 1].T_map_robot, laser[i].T_map_robot);
    step.way = to->way - from->way, step.turn = to->turn - from->turn;
    step.split_way_before = from->split_way, step.split_turn_before = from->split_turn;
    step.split_way_after = to->split_way, step.split_turn_after = to->split_turn;
    step.doubt_before = from->doubt, step.doubt_after = to->doubt;
    step.seconds = to_seconds(laser[i].time - laser[i - 1].time);
    step.end = i;
    step.broken = from->in_jump || to->jumps != from->jumps;
    twists.push_back(log(step.wheels));
    out.push_back(step);
  }
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i].velocity_before = velocity_between(twists, out, i);
    out[i].velocity_after = velocity_between(twists, out, i + 1);
  }
  return out;
}

}  // namespace majak::motion
