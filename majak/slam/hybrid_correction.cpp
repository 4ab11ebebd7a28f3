// SPDX-License-Identifier: Apache-2.0
// How the hybrid corrects its map backwards, and takes that back.
#include <algorithm>
#include <limits>
#include <span>
#include <utility>

#include "majak/slam/hybrid.hpp"

namespace majak::slam {
namespace {

constexpr double kMovedReach = 0.1;  // m, by which matching may better a corrected pose
constexpr double kSamePlace = 1.0;   // m
constexpr double kJudged = 4;        // m of way over which the fit since a closure is averaged
constexpr double kEvidence = 0.2;    // share of returns that must meet old ground to judge by

}  // namespace

/// Old key scan at a place, of the newest visit to it.
std::size_t Hybrid::visit_at(const Pose2& T_map_robot) const {
  const auto away = [&](std::size_t k) {
    return (chain_.keys()[k].T_map_robot.translation() - T_map_robot.translation()).norm();
  };
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < drawn_; ++k) nearest = std::min(nearest, away(k));
  std::size_t visit = drawn_ - 1;
  while (away(visit) > nearest + kSamePlace) --visit;
  return visit;
}

// Where the error that shows at the newest key scan began to gather: at the visit, or later, when
// the robot was tracked on ground as old as that. Loops on the way that are closed err as a whole:
// the steps within them are taken as certain (MATH 24.4).
std::size_t Hybrid::error_begin(std::size_t visit, std::vector<Mat3>& steps) const {
  for (std::size_t k = chain_.keys().size() - 1; options_.keep_loops && k > visit;) {
    const std::size_t anchor = anchors_[k];
    if (anchor <= visit) return k;
    if (anchor == k)
      --k;
    else
      for (; k > anchor; --k) steps[k].setZero();
  }
  return visit;
}

void Hybrid::close(std::size_t visit, const Place& place) {
  const KeyScans& keys = chain_.keys();
  const std::size_t at = keys.size() - 1;
  std::vector<Mat3> steps = steps_;
  const std::size_t first = error_begin(visit, steps);
  Snapshot before{first, at, {}, particles_, doubt_.on, agreement_, agreement_};
  for (std::size_t k = first; k <= at; ++k) before.poses.push_back(keys[k].T_map_robot);
  corrections_.push_back(
      {keys[at].scan,
       keys[visit].scan,
       way_[at] - way_[visit],
       (place.T_map_robot.translation() - keys[at].T_map_robot.translation()).norm(),
       at - first + 1,
       {}});
  const auto loop = std::span(steps).subspan(first);
  start_move(first, share_out(before.poses, loop, place.T_map_robot), true);
  stand_on(visit);
  begin_anew(place);
  snapshot_ = std::move(before);
  rumour_.reset(), told_ = 0;
}

// Do the scans since a correction fit the map it made?
void Hybrid::judge() {
  if (!snapshot_) return;
  if (driven() - way_[snapshot_->at] > options_.probation) return snapshot_.reset();
  const KeyScan& key = chain_.keys().back();
  const Fit fit = fit_of(key.points, key.T_map_robot);
  if (fit.on + fit.through < kEvidence) return;
  const double way = way_.back() - way_[way_.size() - 2];
  snapshot_->since += std::min(way / kJudged, 1.0) * (fit.agreement() - snapshot_->since);
  if (snapshot_->since < snapshot_->before - options_.fall) take_back();
}

void Hybrid::take_back() {
  const KeyScans& keys = chain_.keys();
  Snapshot before = std::move(*snapshot_);
  snapshot_.reset();
  corrections_.back().undone = keys.back().scan;
  quiet_ = {keys[before.first].T_map_robot.translation(), driven() + options_.quiet};
  particles_ = std::move(before.particles);
  doubt_ = {spreads_[before.ground], before.ground};
  for (std::size_t k = before.at + 1; k < keys.size(); ++k) {
    const Pose2 step = between(keys[k - 1].T_front_robot, keys[k].T_front_robot);
    before.poses.push_back(before.poses.back() * step);
    spread(k);
  }
  std::fill(held_.begin() + static_cast<std::ptrdiff_t>(before.at) + 1, held_.end(), 0);
  for (std::size_t k = before.at; k < keys.size(); ++k) anchors_[k] = k;
  agreement_ = before.before;
  start_move(before.first, std::move(before.poses), false);
}

void Hybrid::start_move(std::size_t first, std::vector<Pose2> targets, bool refine) {
  const std::size_t count = targets.size();
  move_ = Move{first, first + count - 1,           std::move(targets), count, refine, 0,
               first, map::SurfelMap(options_.map)};
}

// Poses from the newest back, so that the robot is right at once; then the map from its beginning,
// as it would have grown had they been known.
void Hybrid::work(std::size_t budget) {
  KeyScans& keys = chain_.keys();
  for (; move_ && budget > 0; --budget, ++touched_) {
    Move& m = *move_;
    if (m.unmoved > 0) {
      --m.unmoved;
      keys[m.first + m.unmoved].T_map_robot = m.targets[m.unmoved];
    } else if (m.next < keys.size() && way_[m.drawn] + options_.old_way <= way_[m.next]) {
      match::add_to(m.map, keys[m.drawn].points, keys[m.drawn].T_map_robot);
      ++m.drawn;
    } else if (m.next < keys.size()) {
      rework(m.next++);
    } else {
      most_bytes_ = std::max(most_bytes_, map_.bytes() + m.map.bytes());
      std::swap(map_, m.map);
      drawn_ = m.drawn;
      move_.reset();
    }
  }
}

void Hybrid::rework(std::size_t k) {
  KeyScans& keys = chain_.keys();
  if (k > move_->at)
    keys[k].T_map_robot =
        keys[k - 1].T_map_robot * between(keys[k - 1].T_front_robot, keys[k].T_front_robot);
  if (move_->refine) hold(k, move_->map, kMovedReach);
}

}  // namespace majak::slam
