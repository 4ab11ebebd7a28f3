// SPDX-License-Identifier: Apache-2.0
#include "majak/map/relations.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace majak::map {
namespace {

/// Segments by the squares that their boxes touch.
class Neighbours {
 public:
  Neighbours(std::span<const Segment> segments, double reach)
      : segments_(segments), side_(std::max(reach, 1.0)) {
    for (std::size_t i = 0; i < segments.size(); ++i)
      each_cell(segments[i], 0, [&](std::uint64_t key) { cells_[key].push_back(i); });
  }
  /// Numbers above i whose boxes are within reach of segment i's, rising.
  std::vector<std::size_t> after(std::size_t i, double reach) const {
    std::vector<std::size_t> found;
    each_cell(segments_[i], reach, [&](std::uint64_t key) {
      const auto at = cells_.find(key);
      if (at == cells_.end()) return;
      for (const std::size_t k : at->second)
        if (k > i) found.push_back(k);
    });
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
  }

 private:
  template <class Visit>
  void each_cell(const Segment& s, double reach, const Visit& visit) const {
    const Vec2 low = (s.a.cwiseMin(s.b).array() - reach) / side_;
    const Vec2 high = (s.a.cwiseMax(s.b).array() + reach) / side_;
    for (int y = floor(low.y()); y <= floor(high.y()); ++y)
      for (int x = floor(low.x()); x <= floor(high.x()); ++x)
        visit((static_cast<std::uint64_t>(static_cast<std::uint32_t>(x)) << 32) |
              static_cast<std::uint32_t>(y));
  }
  static int floor(double v) { return static_cast<int>(std::floor(v)); }

  std::span<const Segment> segments_;
  double side_;
  std::unordered_map<std::uint64_t, std::vector<std::size_t>> cells_;
};

/// Two segments, seen along the longer one.
struct Pair {
  const Segment &base, &other;
  Vec2 t, n;
  double low, high;   // the other's extent along the base's line, m from its begin
  double turn;        // of the other's line against the base's, -pi/2 ... pi/2
  double sigma_turn;  // rad
  bool same_side;     // both face the same way

  Pair(const Segment& longer, const Segment& shorter)
      : base(longer), other(shorter), t(longer.direction()), n(longer.normal()) {
    const double a = t.dot(other.a - base.a), b = t.dot(other.b - base.a);
    low = std::min(a, b), high = std::max(a, b);
    const Vec2 d = other.direction();
    same_side = t.dot(d) > 0;
    turn = std::atan2(n.dot(d), t.dot(d));
    if (std::abs(turn) > kPi / 2) turn -= std::copysign(kPi, turn);
    sigma_turn = std::sqrt(std::max(0.0, base.covariance(1, 1) + other.covariance(1, 1)));
  }
  double overlap() const { return std::min(high, base.length()) - std::max(low, 0.0); }
  /// m from the base's line to the other's middle, signed.
  double offset() const { return n.dot(other.middle() - base.a); }
  double sigma_offset() const {
    const double way = (low + high) / 2 - base.length() / 2;
    const Eigen::Matrix2d& c = base.covariance;
    const double at_other = c(0, 0) + 2 * way * c(0, 1) + way * way * c(1, 1);
    return std::sqrt(std::max(0.0, at_other + other.covariance(0, 0)));
  }
  /// The gap's ends where the two lie behind each other: the base's, then the other's.
  std::pair<Vec2, Vec2> gap() const {
    const bool behind = low >= base.length() / 2;
    const bool a_is_low = same_side;
    return {behind ? base.b : base.a, behind == a_is_low ? other.a : other.b};
  }
  double sigma_gap() const {
    const bool behind = low >= base.length() / 2;
    return std::hypot(behind ? base.sigma_b : base.sigma_a,
                      behind == same_side ? other.sigma_a : other.sigma_b);
  }
};

class Finder {
 public:
  Finder(std::span<const Segment> segments, const RelationOptions& options)
      : segments_(segments), o_(options) {}

  std::vector<Relation> all() {
    const double reach = std::max({o_.max_distance, o_.max_gap, o_.corner_gap});
    const Neighbours neighbours(segments_, reach);
    for (std::size_t i = 0; i < segments_.size(); ++i)
      for (const std::size_t k : neighbours.after(i, reach)) ask(i, k);
    return std::move(found_);
  }

 private:
  void ask(std::size_t i, std::size_t k) {
    const Segment &one = segments_[i], &two = segments_[k];
    if (!(one.length() > 0 && two.length() > 0)) return;
    const Pair pair = one.length() >= two.length() ? Pair(one, two) : Pair(two, one);
    const double slack = o_.max_turn + 3 * pair.sigma_turn;
    const auto add = [&](RelationKind kind, double value, double sigma, const Vec2& place) {
      found_.push_back({kind, i, k, value, sigma, place});
    };
    const Vec2 between = (one.middle() + two.middle()) / 2;
    if (std::min(one.length(), two.length()) >= o_.min_length) {
      if (std::abs(pair.turn) <= slack) {
        ask_parallel(pair, add, between);
      } else if (kPi / 2 - std::abs(pair.turn) <= slack && near(one, two)) {
        add(RelationKind::perpendicular, kPi / 2 - std::abs(pair.turn), pair.sigma_turn, between);
      }
    }
    ask_corner(pair, add);
  }

  template <class Add>
  void ask_parallel(const Pair& pair, const Add& add, const Vec2& between) {
    const double offset = std::abs(pair.offset());
    const bool one_line = offset <= o_.max_offset + 3 * pair.sigma_offset();
    if (pair.overlap() > 0) {
      if (!one_line && offset <= o_.max_distance)
        add(RelationKind::parallel, offset, pair.sigma_offset(), between);
      return;
    }
    if (!one_line || !pair.same_side) return;
    const double gap = -pair.overlap();
    const auto [from, to] = pair.gap();
    if (gap > o_.max_gap) return;
    add(RelationKind::collinear, gap, pair.sigma_gap(), (from + to) / 2);
    if (gap >= o_.min_opening && gap <= o_.max_opening && empty(from, to))
      add(RelationKind::opening, gap, pair.sigma_gap(), (from + to) / 2);
  }

  /// Does no other segment cross the inner nine tenths of the way?
  bool empty(const Vec2& from, const Vec2& to) const {
    const Vec2 a = from + 0.05 * (to - from), way = 0.9 * (to - from);
    return std::none_of(segments_.begin(), segments_.end(), [&](const Segment& s) {
      const Vec2 d = s.b - s.a, r = s.a - a;
      const double area = way.x() * d.y() - way.y() * d.x();
      if (area == 0) return false;
      const double u = (r.x() * d.y() - r.y() * d.x()) / area;
      const double v = (r.x() * way.y() - r.y() * way.x()) / area;
      return u >= 0 && u <= 1 && v >= 0 && v <= 1;
    });
  }

  bool near(const Segment& one, const Segment& two) const {
    return std::min({distance_to(one, two.a), distance_to(one, two.b), distance_to(two, one.a),
                     distance_to(two, one.b)}) <= o_.corner_gap;
  }

  template <class Add>
  void ask_corner(const Pair& pair, const Add& add) {
    if (std::abs(pair.turn) < o_.min_corner) return;
    double nearest = o_.corner_gap;
    const Vec2* meet[2] = {nullptr, nullptr};
    for (const Vec2* p : {&pair.base.a, &pair.base.b})
      for (const Vec2* q : {&pair.other.a, &pair.other.b})
        if ((*p - *q).norm() <= nearest) nearest = (*p - *q).norm(), meet[0] = p, meet[1] = q;
    if (meet[0] == nullptr) return;
    const Vec2 one = meet[0] == &pair.base.a ? pair.t : Vec2(-pair.t);
    const Vec2 d = pair.other.direction();
    const Vec2 two = meet[1] == &pair.other.a ? d : Vec2(-d);
    // Inside is where both are seen from: beyond a right angle's two arms or all round them.
    const double angle = std::acos(std::clamp(one.dot(two), -1.0, 1.0));
    const bool inner = pair.n.dot(two) > 0;
    add(RelationKind::corner, inner ? angle : 2 * kPi - angle, pair.sigma_turn,
        (*meet[0] + *meet[1]) / 2);
  }

  std::span<const Segment> segments_;
  const RelationOptions& o_;
  std::vector<Relation> found_;
};

}  // namespace

const char* name_of(RelationKind kind) {
  switch (kind) {
    case RelationKind::parallel:
      return "parallel";
    case RelationKind::perpendicular:
      return "perpendicular";
    case RelationKind::collinear:
      return "collinear";
    case RelationKind::corner:
      return "corner";
    case RelationKind::opening:
      return "opening";
  }
  return "";
}

std::vector<Relation> relations(std::span<const Segment> segments, const RelationOptions& options) {
  return Finder(segments, options).all();
}

}  // namespace majak::map
