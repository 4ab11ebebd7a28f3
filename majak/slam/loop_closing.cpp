// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/loop_closing.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "majak/slam/chain.hpp"

namespace majak::slam {
namespace {

constexpr std::size_t kCachedSubmaps = 24;
constexpr std::size_t kSubmapPoints = 300;
constexpr double kNearer = 0.2;  // overlap that a place far from where the way ends must have more
// A closure that tells no more than expected waits for the next one that does: on a place that is
// known well the graph need not be solved anew every few metres.
constexpr double kStrain = 3.0;
constexpr double kShortCut = 1.0;  // m, of way that a closure counts for

map::SurfelMapOptions submap_map_options() {
  map::SurfelMapOptions o;
  o.cell = 0.10;
  o.reach = 0.40;
  o.merge_radius = 0.08;
  return o;
}

std::size_t bearing_of(const Vec2& p) {
  const double turn = std::atan2(p.y(), p.x()) / (2 * kPi);
  return static_cast<std::size_t>(
      std::clamp(static_cast<int>((turn + 0.5) * View::kBearings), 0, View::kBearings - 1));
}

View view_of(const KeyScan& key, const Pose2& T_submap_robot) {
  View view;
  view.T_submap_laser = T_submap_robot * key.T_robot_laser;
  const Vec2 laser = key.T_robot_laser.translation();
  const double turned = key.T_robot_laser.theta;
  const Eigen::Matrix2d R = Eigen::Rotation2Dd(-turned).toRotationMatrix();
  for (std::size_t i = 0; i < key.points.size(); ++i) {
    const Vec2 p = R * (Vec2(key.points.x[i], key.points.y[i]) - laser);
    const auto range = static_cast<float>(p.norm());
    const std::size_t b = bearing_of(p);
    view.nearest[b] = view.nearest[b] == 0 ? range : std::min(view.nearest[b], range);
    view.farthest[b] = std::max(view.farthest[b], range);
  }
  return view;
}

// Returns of one submap as another's laser should see them: on the surface it saw (agree), or in
// front of it, where its beam passed through (contradict).
struct Comparison {
  int agree = 0, contradict = 0, total = 0;

  void add(const match::ScanPoints& points, const Pose2& T_seen_points,
           const std::vector<View>& views) {
    std::vector<std::uint8_t> agrees(points.size(), 0), contradicts(points.size(), 0);
    for (const View& view : views) {
      const Pose2 T_laser_points = view.T_submap_laser.inverse() * T_seen_points;
      const Eigen::Matrix2d R = Eigen::Rotation2Dd(T_laser_points.theta).toRotationMatrix();
      const Vec2 t = T_laser_points.translation();
      for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec2 p = R * Vec2(points.x[i], points.y[i]) + t;
        const double range = p.norm();
        const Vec2 normal = R * Vec2(points.nx[i], points.ny[i]);
        if (normal.squaredNorm() > 0 && std::abs(normal.dot(p)) < 0.3 * range)
          continue;  // grazing: no telling
        const std::size_t b = bearing_of(p);
        if (view.farthest[b] == 0) continue;
        const double tolerance = 0.15 + 0.015 * range;
        if (range > view.nearest[b] - tolerance && range < view.farthest[b] + tolerance)
          agrees[i] = 1;
        else if (range < view.nearest[b] - 2 * tolerance)
          contradicts[i] = 1;
      }
    }
    total += static_cast<int>(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      agree += agrees[i];
      contradict += contradicts[i] && !agrees[i];
    }
  }
};

Mat3 to_axes_of(const Pose2& pose, const Mat3& information_map) {
  const double c = std::cos(pose.theta), s = std::sin(pose.theta);
  Mat3 r;
  r << c, -s, 0, s, c, 0, 0, 0, 1;
  const Mat3 information = r.transpose() * information_map * r;
  return 0.5 * (information + information.transpose()) + 1e-3 * Mat3::Identity();
}

// Every 2nd ... nth surfel, so that a query costs the same wherever it is.
match::ScanPoints thinned(const map::SurfelMap& map) {
  match::ScanPoints points;
  const auto& surfels = map.surfels();
  const std::size_t stride = surfels.size() / kSubmapPoints + 1;
  for (std::size_t i = 0; i < surfels.size(); i += stride) {
    points.x.push_back(surfels[i].x), points.y.push_back(surfels[i].y);
    points.nx.push_back(surfels[i].nx), points.ny.push_back(surfels[i].ny);
  }
  return points;
}

}  // namespace

std::size_t LoopCloser::anchor_key(std::size_t submap) const {
  return submap * static_cast<std::size_t>(options_.submap_keys) +
         static_cast<std::size_t>(options_.submap_keys) / 2;
}

std::size_t LoopCloser::submap_of(std::size_t key) const {
  return std::min(key / static_cast<std::size_t>(options_.submap_keys), anchors_.size() - 1);
}

void LoopCloser::update(KeyScans& keys, bool last_call) {
  const std::size_t margin = last_call ? 0 : static_cast<std::size_t>(options_.submap_margin);
  while (next_is_complete(keys, margin)) look(keys, add_submap(keys));
  if (!last_call) return;
  settle();
  place(keys);
}

void LoopCloser::replay(KeyScans& keys, const std::vector<Closure>& known) {
  auto next = known.begin();
  while (next_is_complete(keys, 0)) {
    const std::size_t query = add_submap(keys);
    bool moves = false;
    for (; next != known.end() && next->to_key <= anchor_key(query); ++next)
      moves |= accept(keys, *next, query);
    if (moves) settle();
  }
  settle();
  place(keys);
}

// A submap is complete when the key scans of its margin are there.
bool LoopCloser::next_is_complete(const KeyScans& keys, std::size_t margin) const {
  return anchor_key(anchors_.size()) + static_cast<std::size_t>(options_.submap_keys) / 2 +
             margin <=
         keys.size();
}

std::size_t LoopCloser::add_submap(const KeyScans& keys) {
  const std::size_t index = anchors_.size(), key = anchor_key(index);
  if (index == 0) {
    anchors_.push_back(keys[key].T_map_robot);
    ways_.add_place(0);
  } else {
    const std::size_t before = anchor_key(index - 1);
    const Pose2 step = between(keys[before].T_front_robot, keys[key].T_front_robot);
    double way = 0;
    for (std::size_t k = before + 1; k <= key; ++k) {
      const Pose2 d = between(keys[k - 1].T_front_robot, keys[k].T_front_robot);
      way += std::hypot(d.x, d.y) + 0.2 * std::abs(d.theta) +
             (keys[k].weak_step ? options_.weak_step : 0);
    }
    anchors_.push_back(anchors_.back() * step);
    ways_.add_place(way);
    graph_.edges.push_back({static_cast<int>(index) - 1, static_cast<int>(index), step,
                            chain_information(keys, before, key), false});
  }
  graph_.poses.push_back(anchors_.back());
  return index;
}

std::vector<std::size_t> LoopCloser::candidates(std::size_t query,
                                                const std::vector<double>& ways) const {
  std::vector<std::pair<double, std::size_t>> ranked;
  for (std::size_t t = 0; t < query; ++t) {
    if (ways_.driven(query) - ways_.driven(t) < 2.0 * options_.near) continue;
    const Pose2 d = between(anchors_[t], anchors_[query]);
    const double far = std::hypot(d.x, d.y);
    const double reach =
        options_.near + std::min(2.0 * options_.drift_translation * ways[t], options_.max_window);
    if (far < reach) ranked.push_back({far, t});
  }
  std::sort(ranked.begin(), ranked.end());
  std::vector<std::size_t> chosen;
  for (const auto& [far, t] : ranked) {
    const auto near = [t = t](std::size_t c) { return c + 3 > t && t + 3 > c; };
    if (std::any_of(chosen.begin(), chosen.end(), near)) continue;  // the same visit
    chosen.push_back(t);
    if (static_cast<int>(chosen.size()) == options_.candidates) break;
  }
  return chosen;
}

std::vector<graph::Edge> LoopCloser::closure_edges(double weight) const {
  std::vector<graph::Edge> edges;
  for (const Closure& c : accepted_)
    if (!c.off)
      edges.push_back({static_cast<int>(c.from_key), static_cast<int>(c.to_key), c.T_from_to,
                       weight * c.information, true});
  return edges;
}

void LoopCloser::look(const KeyScans& keys, std::size_t query) {
  const auto ways = ways_.from(query);
  const auto places = candidates(query, ways);
  const bool starving = ways_.driven(query) - last_closure_ > options_.starving;
  bool moves = false;
  for (const std::size_t target : places) {
    Closure closure;
    bool found = try_close(keys, query, target, ways[target], false, closure);
    if (!found && starving && target == places.front())
      found = try_close(keys, query, target, ways[target], true, closure);
    if (!found) continue;
    const bool certain = closure.agreement >= options_.certain_agreement &&
                         closure.overlap >= options_.certain_overlap;
    if (closure.searched && !certain && !confirmed(closure)) {
      pending_.push_back(closure);
      continue;
    }
    moves |= accept(keys, closure, query);
  }
  if (moves) settle();
}

// Into the graph, unless it is switched off; true: it tells so much that this cannot wait.
bool LoopCloser::accept(const KeyScans& keys, Closure closure, std::size_t query) {
  closure.off = switched_off(keys[closure.from_key].scan, keys[closure.to_key].scan);
  accepted_.push_back(closure);
  if (closure.off) return false;
  const auto n = static_cast<std::size_t>(options_.submap_keys);
  graph_.edges.push_back({static_cast<int>(closure.from_key / n),
                          static_cast<int>(closure.to_key / n), closure.T_from_to,
                          closure.information, true});
  ways_.add_short_cut(closure.from_key / n, closure.to_key / n, kShortCut);
  last_closure_ = ways_.driven(query);
  waiting_ = true;
  return strain(closure) > kStrain;
}

// chi2 with 3 degrees of freedom of a closure at the anchors' present poses.
double LoopCloser::strain(const Closure& closure) const {
  const auto n = static_cast<std::size_t>(options_.submap_keys);
  const Pose2 T = between(anchors_[closure.from_key / n], anchors_[closure.to_key / n]);
  const Vec3 e = between(closure.T_from_to, T).vector();
  return e.dot(closure.information * e);
}

void LoopCloser::settle() {
  if (!waiting_) return;
  optimizer_.optimize(graph_);
  anchors_ = graph_.poses;
  waiting_ = false;
}

bool LoopCloser::switched_off(std::size_t from_scan, std::size_t to_scan) const {
  const auto& off = options_.switched_off;
  return std::find(off.begin(), off.end(), std::pair{from_scan, to_scan}) != off.end();
}

// A second closure, nearby and found on its own, must tell the same correction.
bool LoopCloser::confirmed(const Closure& closure) const {
  const auto n = static_cast<std::size_t>(options_.submap_keys);
  const std::size_t q = closure.to_key / n, t = closure.from_key / n;
  const auto agrees = [&](const Closure& other) {
    const std::size_t oq = other.to_key / n, ot = other.from_key / n;
    if (other.off || oq == q || oq + 6 < q) return false;
    const Pose2 around =
        between(anchors_[t], anchors_[ot]) * other.T_from_to * between(anchors_[oq], anchors_[q]);
    const Pose2 off = between(closure.T_from_to, around);
    return std::hypot(off.x, off.y) < 0.4 && std::abs(off.theta) < 0.06;
  };
  return std::any_of(pending_.begin(), pending_.end(), agrees) ||
         std::any_of(accepted_.begin(), accepted_.end(), agrees);
}

bool LoopCloser::try_close(const KeyScans& keys, std::size_t query, std::size_t target, double way,
                           bool search, Closure& closure) {
  const auto to = submap(keys, query), from = submap(keys, target);
  const Pose2 guess = between(anchors_[target], anchors_[query]);
  double sigma = 0.05 + options_.drift_translation * way;
  double turn = options_.drift_rotation * std::sqrt(way);
  closure.searched = search || sigma > 0.35;
  if (closure.searched) {
    sigma = std::max(sigma, 0.35), turn = std::max(turn, 0.06);
    if (!from->pyramid)
      from->pyramid = std::make_unique<match::LikelihoodPyramid>(
          from->map, Vec2::Zero(),
          match::LikelihoodPyramidOptions{.max_translation = options_.max_window});
    // Beyond a step not to be trusted any heading is possible.
    const double rotation = way >= options_.weak_step ? std::max(3 * turn, options_.weak_rotation)
                                                      : std::min(3 * turn, 0.8);
    const match::SearchWindow window{std::min(3 * sigma, options_.max_window),
                                     std::min(rotation, kPi)};
    const auto found =
        match::search(to->points, *from->pyramid, guess, window, options_.search_score);
    // Walls that repeat fit in many places; where the way says the robot is, fewer returns may do.
    Closure here = closure;
    const bool fits_here = fits(*from, *to, guess, here);
    const bool fits_there = found && fits(*from, *to, found->T_map_robot, closure);
    if (fits_here && (!fits_there || here.overlap + kNearer > closure.overlap)) closure = here;
    return fits_here || fits_there;
  }
  return fits(*from, *to, guess, closure);
}

bool LoopCloser::fits(const Submap& from, const Submap& to, const Pose2& guess,
                      Closure& closure) const {
  match::AlignOptions align;
  align.gate = 0.4;
  align.final_gate = 0.20;
  align.max_iterations = 20;
  const match::Match m = match::align(to.points, from.map, {guess, Mat3::Zero()}, align);
  if (!m.converged || m.score < 0.2) return false;
  // One empty corridor looks like another: found by searching, it has to fix the place all round.
  if (closure.searched && !match::holds_all_round(m.information)) return false;

  Comparison comparison;
  comparison.add(to.points, m.T_map_robot, from.views);
  comparison.add(from.points, m.T_map_robot.inverse(), to.views);
  const int compared = comparison.agree + comparison.contradict;
  closure.agreement = compared > 0 ? static_cast<double>(comparison.agree) / compared : 0;
  closure.overlap = static_cast<double>(comparison.agree) / std::max(comparison.total, 1);
  closure.from_key = from.anchor;
  closure.to_key = to.anchor;
  closure.T_from_to = m.T_map_robot;
  closure.information = 0.1 * to_axes_of(m.T_map_robot, m.information);
  return closure.agreement >= options_.agreement && closure.overlap >= options_.overlap;
}

// Key scans go with the anchor of their submap, or with its neighbour where a step that is not to
// be trusted lies between.
void LoopCloser::place(KeyScans& keys) const {
  if (anchors_.empty()) return;
  const auto n = static_cast<std::size_t>(options_.submap_keys);
  const auto trusted = [&](std::size_t from, std::size_t to) {
    for (std::size_t k = from + 1; k <= to; ++k)
      if (keys[k].weak_step) return false;
    return true;
  };
  for (std::size_t k = 0; k < keys.size(); ++k) {
    std::size_t a = std::min(k / n, anchors_.size() - 1), key = anchor_key(a);
    if (a > 0 && !trusted(k, key) && trusted(anchor_key(a - 1), k)) key = anchor_key(--a);
    if (a + 1 < anchors_.size() && !trusted(key, k) && trusted(k, anchor_key(a + 1)))
      key = anchor_key(++a);
    keys[k].T_map_robot = anchors_[a] * between(keys[key].T_front_robot, keys[k].T_front_robot);
  }
}

std::shared_ptr<Submap> LoopCloser::submap(const KeyScans& keys, std::size_t index) {
  for (const auto& [i, s] : cache_)
    if (i == index) return s;
  auto s = std::make_shared<Submap>(
      Submap{0, 0, 0, map::SurfelMap(submap_map_options()), {}, {}, nullptr});
  s->anchor = anchor_key(index);
  const auto half = static_cast<std::size_t>(options_.submap_keys / 2 + options_.submap_margin);
  s->first = s->anchor > half ? s->anchor - half : 0;
  s->last = std::min(keys.size(), s->anchor + half);
  for (std::size_t k = s->anchor; k > s->first; --k)  // a submap does not reach over a weak step
    if (keys[k].weak_step) s->first = k;
  for (std::size_t k = s->anchor + 1; k < s->last; ++k)
    if (keys[k].weak_step) s->last = k;
  for (std::size_t k = s->first; k < s->last; k += 2) {
    const Pose2 T_submap_robot = between(keys[s->anchor].T_front_robot, keys[k].T_front_robot);
    match::add_to(s->map, keys[k].points, T_submap_robot);
    if ((k - s->first) % 8 == 0) s->views.push_back(view_of(keys[k], T_submap_robot));
  }
  s->points = thinned(s->map);
  cache_.emplace_back(index, s);
  if (cache_.size() > kCachedSubmaps) cache_.pop_front();
  return s;
}

}  // namespace majak::slam
