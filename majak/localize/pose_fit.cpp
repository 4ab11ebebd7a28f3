// SPDX-License-Identifier: Apache-2.0
#include "majak/localize/pose_fit.hpp"

#include <algorithm>
#include <cmath>

namespace majak::localize {

PoseFit pose_fit(const Place& place, const match::Beams& beams, const Pose2& T_map_robot,
                 const PoseFitOptions& options) {
  if (beams.returns == 0) return {};
  match::PoseArrays pose;
  pose.resize(1);
  pose.set(0, T_map_robot);
  std::uint32_t cost = 0;
  place.likelihood.costs(beams, pose, 0, 1, &cost);
  const Vec2 laser = T_map_robot * beams.laser;
  const double c = std::cos(T_map_robot.theta), s = std::sin(T_map_robot.theta);
  const double near = std::max(options.at_wall, 1.5 * place.known.resolution);
  int at_wall = 0, through = 0;
  for (std::size_t i = 0; i < beams.returns; ++i) {
    at_wall += place.distances.at(T_map_robot * Vec2(beams.x[i], beams.y[i])) < near;
    const double reach = beams.range[i] - options.wall;
    const Vec2 direction(c * beams.cos[i] - s * beams.sin[i], s * beams.cos[i] + c * beams.sin[i]);
    through += reach > 0 && place.distances.cast(laser, direction, reach) < reach;
  }
  const auto n = static_cast<double>(beams.returns);
  return {cost * match::LikelihoodField::kUnit / n + options.through_wall * through / n,
          at_wall / n, through / n};
}

}  // namespace majak::localize
