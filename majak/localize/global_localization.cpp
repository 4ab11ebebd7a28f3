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

}  // namespace

GlobalLocalization::GlobalLocalization(PlacePtr place, const GlobalOptions& options)
    : place_(std::move(place)),
      options_(options),
      search_(place_->known, place_->distances, options.search) {}

GlobalAnswer GlobalLocalization::find(const Scan& scan) const {
  GlobalAnswer answer;
  const match::Beams all = match::beams(scan, {.most = 0}), beams = match::beams(scan);
  if (beams.returns < kLeastReturns) return answer;
  const auto found = search_.find(all);
  answer.complete = found.complete;
  const match::ScanPoints points = match::scan_points(scan, {}, false);
  match::PoseArrays pose;
  pose.resize(1);
  std::vector<double> costs;  // nat, of one beam in the mean
  for (const match::FittingPlace& place : found.places) {
    match::PosePrior loose{place.T_map_robot, Mat3::Zero()};
    loose.information.diagonal() << 25, 25, 100;
    const match::Match fitted = match::align(points, place_->surfaces, loose, {});
    Hypothesis h;
    h.T_map_robot = fitted.T_map_robot;
    h.score = fitted.score;
    h.covariance = (fitted.information / 4 + 1e-6 * Mat3::Identity()).inverse();
    pose.set(0, h.T_map_robot);
    std::uint32_t cost = 0;
    place_->likelihood.costs(beams, pose, 0, 1, &cost);
    // Beams that end behind a wall, or come back from nowhere where a wall stands.
    const Vec2 laser = h.T_map_robot * beams.laser;
    const double c = std::cos(h.T_map_robot.theta), s = std::sin(h.T_map_robot.theta);
    int through = 0;
    for (std::size_t i = 0; i < beams.returns; ++i) {
      const double reach = beams.range[i] - options_.wall;
      if (reach <= 0) continue;
      const Vec2 direction(c * beams.cos[i] - s * beams.sin[i],
                           s * beams.cos[i] + c * beams.sin[i]);
      through += place_->distances.cast(laser, direction, reach) < reach;
    }
    h.through = through / static_cast<double>(beams.returns);
    costs.push_back(cost * match::LikelihoodField::kUnit / static_cast<double>(beams.returns) +
                    options_.through_wall * h.through);
    answer.hypotheses.push_back(h);
  }
  // Log weights, the unknown place among them.
  double sum = std::exp(options_.effective * std::log(options_.elsewhere));
  const double none = sum;
  for (std::size_t k = 0; k < costs.size(); ++k)
    sum += answer.hypotheses[k].probability = std::exp(-options_.effective * costs[k]);
  for (Hypothesis& h : answer.hypotheses) h.probability /= sum;
  answer.elsewhere = none / sum;
  std::stable_sort(
      answer.hypotheses.begin(), answer.hypotheses.end(),
      [](const Hypothesis& a, const Hypothesis& b) { return a.probability > b.probability; });
  return answer;
}

}  // namespace majak::localize
