// SPDX-License-Identifier: Apache-2.0
#include "majak/map/segment_map.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>

#include "majak/core/option_range.hpp"
#include "majak/map/edits.hpp"
#include "majak/map/scan_choice.hpp"

namespace majak::map {
namespace {

/// Along a direction from a place.
struct Extent {
  double low, high;
};

Extent extent_of(const Segment& s, const Vec2& origin, const Vec2& direction) {
  const double a = direction.dot(s.a - origin), b = direction.dot(s.b - origin);
  return {std::min(a, b), std::max(a, b)};
}

/// How far the line of `s` is to the left of `origin`, looking along `direction`, at way u.
double offset_at(const Segment& s, const Vec2& origin, const Vec2& direction, double u) {
  const Vec2 n = s.normal(), from = s.middle() - origin;
  return (n.dot(from) - u * n.dot(direction)) / n.dot(Segment::left_of(direction));
}

/// Of (offset, turn) at the place of the line that is nearest to p.
Eigen::Matrix2d covariance_near(const Segment& s, const Vec2& p) {
  const double way = s.direction().dot(p - s.middle());
  const Eigen::Matrix2d lever = (Eigen::Matrix2d() << 1, way, 0, 1).finished();
  return lever * s.covariance * lever.transpose();
}

double turn_between(const Segment& from, const Segment& to) {
  const Vec2 f = from.direction(), t = to.direction();
  return std::atan2(Segment::left_of(f).dot(t), f.dot(t));
}

/// The returns of a scan by bearing from its first beam, counter-clockwise.
struct Returns {
  struct Beam {
    double bearing, angle, range;  // rad in [0, 2 pi), rad in the laser's frame, m
  };
  double start;
  std::vector<Beam> beams;

  Returns(const Scan& scan, double max_range) : start(scan.start_angle) {
    for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
      const double range = scan.ranges[i];
      if (!std::isfinite(range) || range <= 0 || range > max_range) continue;
      beams.push_back({bearing_of(scan.angle(i)), scan.angle(i), range});
    }
    std::sort(beams.begin(), beams.end(),
              [](const Beam& a, const Beam& b) { return a.bearing < b.bearing; });
  }
  double bearing_of(double angle) const {
    const double turn = wrap_angle(angle - start);
    return turn < 0 ? turn + 2 * kPi : turn;
  }
  /// Calls visit(beam) for those from bearing `low` on over `span`.
  template <class Visit>
  void between(double low, double span, const Visit& visit) const {
    const auto from =
        std::lower_bound(beams.begin(), beams.end(), low,
                         [](const Beam& beam, double bearing) { return beam.bearing < bearing; });
    for (auto b = from; b != beams.end() && b->bearing <= low + span; ++b) visit(*b);
    for (auto b = beams.begin(); b != from && b->bearing <= low + span - 2 * kPi; ++b) visit(*b);
  }
};

struct Evidence {
  int pass = 0, end = 0;  // beams
};

/// What the beams that meet the inner part of a segment (laser frame) tell of it.
Evidence evidence(const Returns& returns, const Segment& s, const SegmentMapOptions& o) {
  Evidence found;
  const double turn = wrap_angle(std::atan2(s.b.y(), s.b.x()) - std::atan2(s.a.y(), s.a.x()));
  const Vec2& right = turn < 0 ? s.b : s.a;
  const Vec2 n = s.normal(), t = s.direction(), middle = s.middle();
  const double half = s.length() / 2 - std::min(o.removal_margin, s.length() / 4);
  returns.between(returns.bearing_of(std::atan2(right.y(), right.x())), std::abs(turn),
                  [&](const Returns::Beam& beam) {
                    const Vec2 u(std::cos(beam.angle), std::sin(beam.angle));
                    const double steep = std::abs(n.dot(u));
                    if (steep < std::sin(o.scan.grazing)) return;
                    const double way = n.dot(middle) / n.dot(u);
                    if (way <= 0 || std::abs(t.dot(way * u - middle)) > half) return;
                    const double behind = (beam.range - way) * steep;
                    found.pass += behind > o.removal_margin;
                    found.end += std::abs(behind) <= o.removal_margin;
                  });
  return found;
}

}  // namespace

bool same_wall(const Segment& a, const Segment& b, const SegmentMapOptions& o) {
  const Segment &longer = a.length() >= b.length() ? a : b, &other = &longer == &a ? b : a;
  const Vec2 origin = longer.middle(), direction = longer.direction();
  const double turn = turn_between(longer, other);
  if (std::abs(turn) > kPi / 4) return false;
  const Extent one = extent_of(longer, origin, direction),
               two = extent_of(other, origin, direction);
  const double low = std::max(one.low, two.low), high = std::min(one.high, two.high);
  if (low - high > o.max_gap) return false;
  const auto apart = [&](double u) { return offset_at(other, origin, direction, u); };
  if (o.correspondence == Correspondence::thresholds)
    return std::abs(turn) <= o.max_angle &&
           std::max(std::abs(apart(low)), std::abs(apart(high))) <= o.max_distance;
  const double u = (low + high) / 2;
  const Vec2 place = origin + u * direction, difference(apart(u), turn);
  Eigen::Matrix2d sum = covariance_near(longer, place) + covariance_near(other, place);
  sum(0, 0) += o.pose_sigma * o.pose_sigma;
  sum(1, 1) += o.heading_sigma * o.heading_sigma;
  return difference.dot(sum.inverse() * difference) <= o.chi2;
}

Segment fused(const Segment& a, const Segment& b) {
  const Vec2 origin = a.middle(), t = a.direction(), n = a.normal();
  const double s = t.dot(b.middle() - origin);
  const Vec2 measured(n.dot(b.middle() - origin), turn_between(a, b));
  const Eigen::Matrix2d lever = (Eigen::Matrix2d() << 1, s, 0, 1).finished();
  // As a gain, so that either may be exact; and both, by a micrometre.
  const Eigen::Matrix2d sum_of_both =
      lever * a.covariance * lever.transpose() + b.covariance + 1e-12 * Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d gain = a.covariance * lever.transpose() * sum_of_both.inverse();
  const Eigen::Matrix2d left = a.covariance - gain * lever * a.covariance;
  const Eigen::Matrix2d covariance = (left + left.transpose()) / 2;
  const Vec2 change = gain * measured;

  const Vec2 foot = origin + change.x() * n;
  const Vec2 along = (t + std::tan(change.y()) * n).normalized();
  const Extent one = extent_of(a, foot, along), two = extent_of(b, foot, along);
  Segment sum;
  sum.a = foot + std::min(one.low, two.low) * along;
  sum.b = foot + std::max(one.high, two.high) * along;
  sum.sigma_a = one.low <= two.low ? a.sigma_a : b.sigma_a;
  sum.sigma_b = one.high >= two.high ? a.sigma_b : b.sigma_b;
  const double way = along.dot(sum.middle() - foot);
  const Eigen::Matrix2d to_middle = (Eigen::Matrix2d() << 1, way, 0, 1).finished();
  sum.covariance = to_middle * covariance * to_middle.transpose();
  sum.points = a.points + b.points;
  sum.scans = a.scans + b.scans;
  return sum;
}

SegmentMap::SegmentMap(const SegmentMapOptions& options, const std::vector<Segment>& known)
    : options_(options), segments_(known), passed_(known.size(), 0) {}

std::vector<Segment> SegmentMap::approximate(const Scan& scan, const Pose2& T_map_robot) const {
  std::vector<Segment> seen = extract_segments(scan, options_.scan);
  for (Segment& s : seen) s = moved(T_map_robot, s);
  return seen;
}

std::vector<SegmentPair> SegmentMap::find_pairs(const std::vector<Segment>& seen) const {
  std::vector<SegmentPair> pairs;
  for (std::size_t k = 0; k < seen.size(); ++k) {
    const Segment& s = seen[k];
    const Vec2 low = s.a.cwiseMin(s.b).array() - options_.max_gap;
    const Vec2 high = s.a.cwiseMax(s.b).array() + options_.max_gap;
    for (std::size_t i = 0; i < segments_.size(); ++i) {
      const Segment& m = segments_[i];
      const bool near = (m.a.cwiseMax(m.b).array() >= low.array()).all() &&
                        (m.a.cwiseMin(m.b).array() <= high.array()).all();
      if (near && (m.b - m.a).dot(s.b - s.a) > 0) pairs.push_back({i, k});
    }
  }
  return pairs;
}

std::vector<SegmentPair> SegmentMap::keep_good(const std::vector<SegmentPair>& pairs,
                                               const std::vector<Segment>& seen) const {
  std::vector<std::optional<SegmentPair>> best(seen.size());
  std::vector<double> overlap(seen.size());
  for (const SegmentPair& pair : pairs) {
    const Segment &m = segments_[pair.map], &s = seen[pair.seen];
    if (!same_wall(m, s, options_)) continue;
    const Vec2 origin = s.middle(), direction = s.direction();
    const Extent one = extent_of(m, origin, direction), two = extent_of(s, origin, direction);
    const double common = std::min(one.high, two.high) - std::max(one.low, two.low);
    if (best[pair.seen] && common <= overlap[pair.seen]) continue;
    best[pair.seen] = pair;
    overlap[pair.seen] = common;
  }
  std::vector<SegmentPair> kept;
  for (const auto& pair : best)
    if (pair) kept.push_back(*pair);
  return kept;
}

std::vector<Segment> SegmentMap::remove_passed(const Scan& scan, const Pose2& T_map_robot,
                                               std::vector<SegmentPair>& pairs) {
  for (const SegmentPair& pair : pairs) passed_[pair.map] = -1;  // matched: not asked
  const Pose2 T_laser_map = (T_map_robot * scan.T_robot_laser).inverse();
  const Returns returns(scan, options_.scan.max_range);
  std::vector<std::size_t> gone;
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    if (passed_[i] < 0) {
      passed_[i] = 0;
      continue;
    }
    const Segment s = moved(T_laser_map, segments_[i]);
    if (distance_to(s, Vec2::Zero()) > options_.scan.max_range) continue;
    const auto [pass, end] = evidence(returns, s, options_);
    if (pass >= options_.removal_beams && pass > end) {
      if (++passed_[i] >= options_.removal_scans) gone.push_back(i);
    } else if (end > 0 && end >= pass) {
      passed_[i] = 0;
    }
  }
  std::vector<Segment> removed;
  for (const std::size_t i : gone) removed.push_back(segments_[i]);
  for (auto i = gone.rbegin(); i != gone.rend(); ++i) erase(*i);
  for (SegmentPair& pair : pairs)
    pair.map -= static_cast<std::size_t>(std::lower_bound(gone.begin(), gone.end(), pair.map) -
                                         gone.begin());
  return removed;
}

int SegmentMap::update(const std::vector<Segment>& seen, const std::vector<SegmentPair>& pairs) {
  std::vector<bool> matched(seen.size(), false);
  std::vector<std::size_t> changed;
  for (const SegmentPair& pair : pairs) {
    Segment& m = segments_[pair.map];
    m = fused(m, seen[pair.seen]);
    // Two pieces of one wall in one scan are one sight of it.
    const bool again = std::find(changed.begin(), changed.end(), pair.map) != changed.end();
    if (again) m.scans -= seen[pair.seen].scans;
    if (!again) changed.push_back(pair.map);
    matched[pair.seen] = true;
  }
  for (std::size_t k = 0; k < seen.size(); ++k) {
    if (matched[k]) continue;
    changed.push_back(segments_.size());
    segments_.push_back(seen[k]);
    passed_.push_back(0);
  }
  // From the back: a merged one vanishes into one of a lower number.
  std::sort(changed.begin(), changed.end());
  int merged = 0;
  for (auto i = changed.rbegin(); i != changed.rend(); ++i)
    if (*i < segments_.size()) merged += merge_with_others(*i);
  return merged;
}

int SegmentMap::merge_with_others(std::size_t changed) {
  int merged = 0;
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    if (i == changed || !same_wall(segments_[i], segments_[changed], options_)) continue;
    const auto [low, high] = std::minmax(i, changed);
    segments_[low] = fused(segments_[low], segments_[high]);
    passed_[low] = 0;
    erase(high);
    changed = low;
    i = static_cast<std::size_t>(-1);  // it may touch others now
    ++merged;
  }
  return merged;
}

void SegmentMap::erase(std::size_t index) {
  segments_.erase(segments_.begin() + static_cast<std::ptrdiff_t>(index));
  passed_.erase(passed_.begin() + static_cast<std::ptrdiff_t>(index));
}

SegmentSteps SegmentMap::add(const Scan& scan, const Pose2& T_map_robot) {
  const auto count = [](const auto& list) { return static_cast<int>(list.size()); };
  SegmentSteps steps;
  steps.time = scan.time;
  const std::vector<Segment> seen = approximate(scan, T_map_robot);
  std::vector<SegmentPair> pairs = find_pairs(seen);
  steps.pairs = count(pairs);
  pairs = keep_good(pairs, seen);
  steps.removed = count(remove_passed(scan, T_map_robot, pairs));
  steps.merged = update(seen, pairs);
  steps.seen = count(seen);
  steps.kept = count(pairs);
  steps.inserted = steps.seen - steps.kept;
  steps.in_map = count(segments_);
  return steps;
}

std::vector<Segment> SegmentMap::walls() const {
  std::vector<Segment> walls;
  for (const Segment& s : segments_)
    if (s.scans >= static_cast<std::size_t>(options_.min_scans)) walls.push_back(s);
  return walls;
}

SegmentMap build_segments(const Site& site, const SegmentMapOptions& options,
                          std::vector<SegmentSteps>* log, const std::vector<Segment>& known) {
  require_in_range(options);
  SegmentMap map(options, known);
  for_spaced_scans(site, options.key_spacing, options.key_turn, [&](const PosedScan& posed) {
    const SegmentSteps steps = map.add(posed.scan, posed.estimate.T_map_robot);
    if (log) log->push_back(steps);
  });
  std::vector<Segment> walls = drawn_walls(site, static_cast<std::size_t>(options.min_scans));
  if (!options.refinement.enabled || !known.empty()) {
    if (walls.empty()) return map;
    walls.insert(walls.begin(), map.segments().begin(), map.segments().end());
    return SegmentMap(options, walls);
  }
  const std::vector<Segment> seen = refined(site, map.walls(), options);
  walls.insert(walls.begin(), seen.begin(), seen.end());
  return SegmentMap(options, walls);
}

}  // namespace majak::map
