// SPDX-License-Identifier: Apache-2.0
#include "majak/localize/global_localization.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "majak/match/point_to_line.hpp"
#include "majak/match/scan_points.hpp"

namespace majak::localize {
namespace {

constexpr std::size_t kLeastReturns = 10;
constexpr double kTogether = 4;  // returns that err as one

}  // namespace

GlobalLocalization::GlobalLocalization(PlacePtr place, const GlobalOptions& options)
    : place_(std::move(place)),
      options_(options),
      search_(place_->known, place_->distances, options.search) {}

// Beams that end behind a wall count against a pose: something stands where they passed.
PoseFit GlobalLocalization::weigh(const match::Beams& beams, const Pose2& T_map_robot) const {
  if (beams.returns == 0) return {};
  match::PoseArrays pose;
  pose.resize(1);
  pose.set(0, T_map_robot);
  std::uint32_t cost = 0;
  place_->likelihood.costs(beams, pose, 0, 1, &cost);
  const Vec2 laser = T_map_robot * beams.laser;
  const double c = std::cos(T_map_robot.theta), s = std::sin(T_map_robot.theta);
  int through = 0;
  for (std::size_t i = 0; i < beams.returns; ++i) {
    const double reach = beams.range[i] - options_.wall;
    const Vec2 direction(c * beams.cos[i] - s * beams.sin[i], s * beams.cos[i] + c * beams.sin[i]);
    through += reach > 0 && place_->distances.cast(laser, direction, reach) < reach;
  }
  const auto n = static_cast<double>(beams.returns);
  return {cost * match::LikelihoodField::kUnit / n + options_.through_wall * through / n,
          through / n};
}

GlobalAnswer GlobalLocalization::find(const Scan& scan) const {
  GlobalAnswer answer;
  const match::Beams beams = match::beams(scan);
  if (beams.returns < kLeastReturns) return answer;
  const auto found = search_.find(match::beams(scan, {.most = 0}));
  answer.complete = found.complete;
  const match::ScanPoints points = match::scan_points(scan, {}, false);
  const double none = std::exp(options_.effective * std::log(options_.elsewhere));
  double sum = none;
  for (const match::FittingPlace& place : found.places) {
    match::PosePrior loose{place.T_map_robot, Mat3::Zero()};
    loose.information.diagonal() << 25, 25, 100;
    const match::Match fitted = match::align(points, place_->surfaces, loose, {});
    FoundPlace p;
    p.T_map_robot = fitted.T_map_robot;
    p.covariance = (fitted.information / kTogether + 1e-6 * Mat3::Identity()).inverse();
    p.score = fitted.score;
    p.fit = weigh(beams, p.T_map_robot);
    p.probability = std::exp(-options_.effective * p.fit.cost);
    sum += p.probability;
    answer.places.push_back(p);
  }
  for (FoundPlace& p : answer.places) p.probability /= sum;
  answer.elsewhere = none / sum;
  std::stable_sort(
      answer.places.begin(), answer.places.end(),
      [](const FoundPlace& a, const FoundPlace& b) { return a.probability > b.probability; });
  return answer;
}

}  // namespace majak::localize
