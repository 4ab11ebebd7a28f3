// SPDX-License-Identifier: Apache-2.0
#include "majak/localize/find_and_track.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "majak/localize/on_scans.hpp"

namespace majak::localize {
namespace {

constexpr double kSamePlace = 0.6, kSameTurn = 0.25;  // m, rad: off what was foretold
constexpr double kForgotten = 1e-4;                   // probability of a place that is dropped
constexpr double kMemory = 50;                        // scans, of the usual score
constexpr std::pair kFoundWithin{0.1, 0.05};          // m, rad
constexpr double kClearly = 0.9, kBetter = 0.1;       // probability, share of returns

bool near(const Pose2& a, const Pose2& b) {
  return (a.translation() - b.translation()).norm() < kSamePlace &&
         std::abs(angle_diff(a.theta, b.theta)) < kSameTurn;
}

}  // namespace

FindAndTrack::FindAndTrack(PlacePtr place, const GlobalOptions& global,
                           const TrackingOptions& tracking, const FindOptions& options,
                           const PlausibilityOptions& plausibility)
    : place_(place),
      tracking_(tracking),
      options_(options),
      global_(place, global),
      plausibility_(place, plausibility) {}

Estimate FindAndTrack::add(const FedScan& scan) {
  way_ += scan.T_previous_robot.translation().norm();
  turned_ += std::abs(scan.T_previous_robot.theta);
  return tracker_ ? track(scan) : look(scan);
}

// ---- Looking ---------------------------------------------------------------------------------

Estimate FindAndTrack::look(const FedScan& scan) {
  for (Followed& h : hypotheses_) h.T_map_robot = h.T_map_robot * scan.T_previous_robot;
  if (looked_ && !moved()) return unsure(scan.scan.time);
  looked_ = true;
  way_ = turned_ = 0;
  weigh(global_.find(scan.scan));
  if (hypotheses_.empty()) return unsure(scan.scan.time);
  const Followed& best = hypotheses_.front();
  const bool at_once = best.probability > options_.at_once && best.misfit < options_.poor / 2;
  const bool by_and_by = best.probability > options_.sure && best.looks >= options_.looks &&
                         best.misfit < options_.poor;
  return at_once || by_and_by ? begin(scan) : unsure(scan.scan.time);
}

// The likeliest place is tracked from here on.
Estimate FindAndTrack::begin(const FedScan& scan) {
  TrackingOptions close = tracking_;
  close.start_sigma = kFoundWithin.first, close.start_turn = kFoundWithin.second;
  tracker_.emplace(place_, close, hypotheses_.front().T_map_robot);
  plausibility_.begin_anew();
  usual_score_ = 0;
  doubted_ = 0;
  FedScan here = scan;
  here.T_previous_robot = {};
  Estimate estimate = tracker_->add(here);
  plausibility_.add(here, estimate.T_map_robot);
  plausibility_.limit(estimate);
  return estimate;
}

// Prior: the hypotheses as they were; a place that none of them foretold may be new.
void FindAndTrack::weigh(const GlobalAnswer& answer) {
  std::vector<Followed> next;
  double sum = 0;
  const bool first = hypotheses_.empty();
  const auto evidence = [&](double p) { return first ? p : std::pow(p, options_.own); };
  const double elsewhere = std::max(elsewhere_, options_.elsewhere);
  for (const FoundPlace& place : answer.places) {
    double prior = first ? 1 : options_.newcomer * elsewhere;
    int looks = 1;
    for (const Followed& h : hypotheses_)
      if (near(h.T_map_robot, place.T_map_robot)) {
        prior = std::max(prior, h.probability);
        looks = std::max(looks, h.looks + 1);
      }
    next.push_back({{place.T_map_robot, place.covariance, prior * evidence(place.probability)},
                    looks,
                    place.fit.misfit()});
    sum += next.back().probability;
  }
  const double none = evidence(answer.elsewhere) * (first ? 1 : elsewhere);
  sum += none;
  elsewhere_ = none / sum;
  for (Followed& h : next) h.probability /= sum;
  std::erase_if(next, [](const Followed& h) { return h.probability < kForgotten; });
  std::stable_sort(next.begin(), next.end(), [](const Followed& a, const Followed& b) {
    return a.probability > b.probability;
  });
  hypotheses_ = std::move(next);
}

// The likeliest place, with all the others in its covariance. Not found yet is lost.
Estimate FindAndTrack::unsure(Time time) const {
  Estimate e;
  e.time = time;
  e.health = Health::lost;
  if (hypotheses_.empty()) return e;
  const Pose2& best = e.T_map_robot = hypotheses_.front().T_map_robot;
  e.covariance = hypotheses_.front().covariance;
  for (const Hypothesis& h : hypotheses_) {
    const Vec3 off(h.T_map_robot.x - best.x, h.T_map_robot.y - best.y,
                   angle_diff(h.T_map_robot.theta, best.theta));
    e.covariance += h.probability * off * off.transpose();
  }
  return e;
}

// ---- Tracking --------------------------------------------------------------------------------

Estimate FindAndTrack::track(const FedScan& scan) {
  Estimate estimate = tracker_->add(scan);
  plausibility_.add(scan, estimate.T_map_robot);
  plausibility_.limit(estimate);
  if (estimate.health != Health::lost && !carried_away(scan, estimate)) return estimate;
  tracker_.reset();
  hypotheses_.clear();
  elsewhere_ = 1;
  looked_ = false;
  FedScan here = scan;
  here.T_previous_robot = {};
  estimate = look(here);
  estimate.health = Health::lost;  // said once, even where it is found again at once
  return estimate;
}

// Where the scan fits worse than usual, the whole map is asked; when another place fits clearly
// better several times in a row, the robot is there.
bool FindAndTrack::carried_away(const FedScan& scan, Estimate& estimate) {
  const double score = tracker_->match().score;
  const bool doubtful = score < usual_score_ - options_.doubt || score < tracking_.lost_score;
  if (!doubtful) {
    usual_score_ += (score - usual_score_) / (usual_score_ == 0 ? 1 : kMemory);
    doubted_ = 0;
    asked_ = false;
  } else if (!asked_ || moved()) {
    asked_ = true;
    const GlobalAnswer answer = global_.find(scan.scan);
    double here = 0;
    for (const FoundPlace& p : answer.places)
      if (near(p.T_map_robot, estimate.T_map_robot)) here = std::max(here, p.probability);
    const bool better = !answer.places.empty() && answer.places.front().probability > kClearly &&
                        here < 1 - kClearly && answer.places.front().score > score + kBetter;
    doubted_ = better ? doubted_ + 1 : 0;
  }
  if (doubted_ > 0) estimate.health = Health::degraded;
  if (moved()) way_ = turned_ = 0;
  return doubted_ >= options_.witnesses;
}

void describe(OptionFields& f, FindOptions& o) {
  f.add("find.sure", o.sure, {"1", "probability from which on a place is tracked", 0.5, 1});
  f.add("find.step", o.step, {"m", "driven between two looks", 0, 10});
  f.add("find.turn", o.turn, {"rad", "or turned", 0, 4});
  f.add("find.newcomer", o.newcomer, {"1", "prior of a place that is new", 0, 1});
  f.add("find.elsewhere", o.elsewhere, {"1", "least prior of none of the places", 0, 1});
  f.add("find.looks", o.looks, {"1", "in a row in which a place must be told", 1, 100});
  f.add("find.own", o.own,
        {"1", "share of a look's evidence that the looks before had not", 0.01, 1});
  f.add("find.doubt", o.doubt,
        {"1", "drop of the fit from which on another place is looked for", 0, 1});
  f.add("find.at_once", o.at_once, {"1", "probability with which one look is enough", 0.5, 1});
  f.add("find.poor", o.poor, {"1", "misfit from which on a place is not tracked", 0, 1.5});
  f.add("find.witnesses", o.witnesses, {"1", "looks that must favour another place", 1, 100});
}

Localizer find_and_track(const PlacePtr& place, const GlobalOptions& global,
                         const TrackingOptions& tracking, const FindOptions& options,
                         const PlausibilityOptions& plausibility) {
  return on_scans([method = FindAndTrack(place, global, tracking, options, plausibility)](
                      const FedScan& scan, Localization& result) mutable -> Step {
    const bool tracked = method.tracking();
    const Estimate estimate = method.add(scan);
    if (!method.tracking()) result.hypotheses.push_back({estimate.time, method.hypotheses()});
    return {estimate, tracked && method.tracking() && estimate.health == Health::ok};
  });
}

}  // namespace majak::localize
