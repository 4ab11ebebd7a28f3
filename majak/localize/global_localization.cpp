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

void describe(OptionFields& f, GlobalOptions& o) {
  f.add("global.effective", o.effective, {"1", "beams that err by themselves", 0.1, 1000});
  f.add("global.through_wall", o.fit.through_wall,
        {"nat", "against a beam that would have passed through a wall", 0, 100});
  f.add("global.wall", o.fit.wall, {"m", "by which such a beam must end beyond it", 0, 10});
  f.add("global.elsewhere", o.elsewhere,
        {"1", "mean likelihood of a beam at a place that the map does not show", 1e-6, 1});
  match::GlobalSearchOptions& s = o.search;
  f.add("global.cell", s.cell, {"m", "of the finest grid that is searched", 0.01, 2});
  f.add("global.sigma", s.sigma, {"m", "of a return off its surface", 0.005, 2});
  f.add("global.random", s.random,
        {"1", "likelihood of any return against that of a perfect one", 4e-4, 0.99});
  f.add("global.reach", s.reach, {"m", "returns farther off are left out", 0.5, 1000});
  f.add("global.returns", s.returns, {"1", "of a scan that are looked at", 10, 250});
  f.add("global.most", s.most, {"1", "places that are told", 1, 10000});
  f.add("global.apart", s.apart, {"m", "nearer ones are one place", 0, 100});
  f.add("global.apart_turn", s.apart_turn, {"rad", "likewise", 0, 4});
  f.add("global.worse", s.worse,
        {"1", "mean fit below the best from which on a place is not told", 0, 1});
  f.add("global.blocks", s.blocks, {"1", "opened at most; then the search ends early", 1, 1e9});
}

}  // namespace majak::localize
