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
    p.fit = pose_fit(*place_, beams, p.T_map_robot, options_.fit);
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
