// SPDX-License-Identifier: Apache-2.0
#include "majak/map/segment_refinement.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "majak/map/segment_ends.hpp"
#include "majak/map/segment_gaps.hpp"
#include "majak/map/segment_map.hpp"
#include "majak/map/surface_bits.hpp"

namespace majak::map {
namespace {

constexpr std::size_t kNobody = static_cast<std::size_t>(-1);
constexpr double kBin = 0.02;        // m, of profiles along a wall
constexpr double kSlack = 0.05;      // m, a wall owns returns so far beyond its ends
constexpr double kSquares = 3e-4;    // m, of a line: what squares and bands may move it
constexpr double kCrossing = 0.5;    // sine of the angle from which on walls are no neighbours
constexpr double kShared = 15e-4;    // m, of a corner: whose returns they are is not always told
constexpr double kBesideEnd = 0.05;  // m; so near to an end returns of the next wall disturb a fit

/// A segment's own axes: u from a to b, v to its left.
struct Axes {
  Vec2 origin, t, n;
  double length;
  explicit Axes(const Segment& s)
      : origin(s.a), t(s.direction()), n(s.normal()), length(s.length()) {}
  double u(const Vec2& p) const { return t.dot(p - origin); }
  double v(const Vec2& p) const { return n.dot(p - origin); }
};

/// A wall while it is refined.
struct Wall {
  Segment segment;
  double band;         // m, returns so near to the line are its own
  Segment found;       // as it came to be one
  double returns = 0;  // that it owns
};

/// v = offset + slope (u - centre) through the returns on a line.
struct LineFit {
  double offset = 0, slope = 0, centre = 0;
  double weight = 0, moment = 0;  // sums of w and w (u - centre)^2
  double variance = 0;            // m^2, of a return across the line
};

class Refinement {
 public:
  Refinement(const Site& site, const SurfaceBits& bits, const std::vector<Segment>& walls,
             const SegmentMapOptions& options)
      : site_(site), bits_(bits), o_(options), r_(options.refinement) {
    for (const Segment& s : walls) walls_.push_back({s, r_.max_band, s});
  }

  std::vector<Segment> result() {
    settle(2);
    add_pieces();
    settle(2);
    drop();
    assign();
    const std::vector<Corner> corners = find_corners();
    std::vector<Segment> found;
    for (const Wall& w : walls_) found.push_back(w.segment);
    SegmentEndOptions ends;
    ends.grazing = o_.scan.grazing, ends.max_range = o_.scan.max_range;
    ends.key_spacing = o_.key_spacing, ends.key_turn = o_.key_turn;
    sharpen_ends(site_, found, ends);
    for (const Corner& c : corners) join(found[c.wall], c);
    add_pose_errors(found);
    return found;
  }

 private:
  void settle(int rounds) {
    for (int k = 0; k < rounds; ++k) {
      assign();
      for (std::size_t i = 0; i < walls_.size(); ++i) fit(i);
      for (std::size_t i = 0; i < walls_.size(); ++i) set_ends(i);
      std::erase_if(walls_, [](const Wall& w) { return !(w.segment.length() > kBin); });
      merge();
    }
  }

  static double cross(const Segment& a, const Segment& b) {
    return std::abs(a.direction().dot(b.normal()));
  }

  static bool faces(const SurfaceBit& bit, const Vec2& n) { return bit.beam.dot(n) < 0; }

  /// Every bit to the nearest wall that could have returned it.
  void assign() {
    owner_.assign(bits_.all().size(), kNobody);
    shared_.assign(bits_.all().size(), false);
    std::vector<double> best(bits_.all().size(), 1e9);
    for (std::size_t k = 0; k < walls_.size(); ++k) {
      Wall& wall = walls_[k];
      const Axes axes(wall.segment);
      bits_.near(wall.segment.a, wall.segment.b, wall.band + kSlack, [&](std::size_t i) {
        const SurfaceBit& bit = bits_.all()[i];
        const double u = axes.u(bit.mean), v = std::abs(axes.v(bit.mean));
        if (u < -kSlack || u > axes.length + kSlack || v > wall.band || !faces(bit, axes.n)) return;
        if (owner_[i] != kNobody && cross(walls_[owner_[i]].segment, wall.segment) > kCrossing)
          shared_[i] = true;
        const double away = std::hypot(v, std::max({0.0, -u, u - axes.length}));
        if (away < best[i]) best[i] = away, owner_[i] = k;
      });
    }
    for (Wall& wall : walls_) wall.returns = 0;
    for (std::size_t i = 0; i < owner_.size(); ++i)
      if (owner_[i] != kNobody) walls_[owner_[i]].returns += bits_.all()[i].returns;
  }

  /// Calls visit(bit, u, v) for those that are of wall k and of no other.
  template <class Visit>
  void owned(std::size_t k, const Visit& visit) const {
    const Wall& wall = walls_[k];
    const Axes axes(wall.segment);
    bits_.near(wall.segment.a, wall.segment.b, wall.band + kSlack, [&](std::size_t i) {
      const SurfaceBit& bit = bits_.all()[i];
      if (owner_[i] == k && !shared_[i]) visit(bit, axes.u(bit.mean), axes.v(bit.mean));
    });
  }

  std::optional<LineFit> line_of_returns(std::size_t k) const {
    const Wall& wall = walls_[k];
    const double length = wall.segment.length(), sigma = wall.band / 2;
    const double margin = std::min(kBesideEnd, length / 4);
    const Vec2 n = wall.segment.normal();
    LineFit fit;
    for (int round = 0; round < 4; ++round) {
      double w = 0, wu = 0, wv = 0, wuu = 0, wuv = 0, wvv = 0;
      owned(k, [&](const SurfaceBit& bit, double u, double v) {
        if (u < margin || u > length - margin) return;
        const double off = v - (fit.offset + fit.slope * (u - fit.centre));
        const double weight = bit.returns * std::exp(-off * off / (2 * sigma * sigma));
        w += weight, wu += weight * u, wv += weight * v;
        wuu += weight * u * u, wuv += weight * u * v;
        wvv += weight * (off * off + n.dot(bit.scatter * n));
      });
      if (!(w > 3)) return std::nullopt;
      fit.centre = wu / w;
      fit.weight = w;
      fit.moment = wuu - w * fit.centre * fit.centre;
      fit.offset = wv / w;
      fit.slope = fit.moment > 1e-6 ? (wuv - w * fit.centre * fit.offset) / fit.moment : 0;
      // The weights cut a normal distribution's tails: their part of its variance is known.
      const double seen = std::min(wvv / w, 0.8 * sigma * sigma);
      fit.variance = seen * sigma * sigma / (sigma * sigma - seen);
    }
    return fit;
  }

  /// Fits step by step that follow a wall's neighbour lead away from what was found.
  bool astray(const Segment& now, const Segment& found) const {
    return cross(now, found) > std::sin(o_.max_angle) ||
           std::abs(now.normal().dot(found.middle() - now.a)) > r_.max_band;
  }

  void fit(std::size_t k) {
    const auto line = line_of_returns(k);
    if (!line) return;
    Segment& s = walls_[k].segment;
    const Axes axes(s);
    const auto at = [&](double u) -> Vec2 {
      return axes.origin + u * axes.t + (line->offset + line->slope * (u - line->centre)) * axes.n;
    };
    const Segment before = s;
    s.a = at(0), s.b = at(axes.length);
    if (astray(s, walls_[k].found)) return void(s = before);
    const double offset = line->variance / line->weight + kSquares * kSquares;
    const double turn = line->variance / std::max(line->moment, 1e-6);
    const double d = axes.length / 2 - line->centre;
    s.covariance << offset + d * d * turn, d * turn, d * turn, turn;
    walls_[k].band = std::clamp(2.5 * std::sqrt(line->variance), r_.min_band, r_.max_band);
  }

  /// Returns along a wall from its middle on towards one end, those of other walls left out.
  struct Profile {
    struct Piece {
      double u, width, returns;
    };
    std::vector<Piece> pieces;
    double between(double low, double high) const {
      double sum = 0;
      for (const Piece& p : pieces) {
        const double from = std::max(low, p.u - p.width / 2),
                     to = std::min(high, p.u + p.width / 2);
        if (to > from) sum += p.returns * (to - from) / p.width;
      }
      return sum;
    }
  };

  Profile profile(std::size_t k, bool towards_b) const {
    const Wall& wall = walls_[k];
    const Axes axes(wall.segment);
    const Vec2 end = towards_b ? wall.segment.b : wall.segment.a;
    const Vec2 way = towards_b ? axes.t : Vec2(-axes.t);
    Profile profile;
    bits_.near(wall.segment.middle(), end + o_.max_gap * way, wall.band, [&](std::size_t i) {
      const SurfaceBit& bit = bits_.all()[i];
      if (owner_[i] != k && owner_[i] != kNobody) return;
      const double u = way.dot(bit.mean - wall.segment.middle());
      if (u < -0.05 || std::abs(axes.v(bit.mean)) > wall.band || !faces(bit, axes.n)) return;
      const double width = std::sqrt(12 * std::max(1e-6, way.dot(bit.scatter * way)));
      profile.pieces.push_back({u, width, bit.returns});
    });
    return profile;
  }

  struct End {
    double u, sigma;  // m from the wall's middle
  };

  /// The last place that returns lead to without a gap.
  double last_supported(const Profile& profile, double old_end) const {
    const auto bins = static_cast<std::size_t>(std::ceil((old_end + o_.max_gap) / kBin)) + 1;
    std::vector<double> count(bins, 0.0);
    for (const auto& p : profile.pieces)
      if (p.u >= 0) count[std::min(bins - 1, static_cast<std::size_t>(p.u / kBin))] += p.returns;
    const auto supported = [&](std::size_t i) { return count[i] >= 2; };
    std::size_t last = std::min(bins - 1, static_cast<std::size_t>(old_end / kBin));
    while (last > 0 && !supported(last)) --last;
    const auto gap = static_cast<std::size_t>(r_.max_gap / kBin);
    for (std::size_t i = last + 1; i < bins && i <= last + gap; ++i)
      if (supported(i)) last = i;
    return supported(last) ? (static_cast<double>(last) + 1) * kBin : 0;
  }

  /// Where returns of even density, as many as lie there, would end (MATH 15.4).
  End end_of(const Profile& profile, double old_end) const {
    const double last = last_supported(profile, old_end);
    const double before = last - std::min(0.1, last / 2), first = std::max(0.0, before - 0.2);
    const double density = profile.between(first, before) / std::max(before - first, 1e-9);
    if (!(density > 0)) return {last, kBin};
    const double beyond = profile.between(before, last + 2 * kBin);
    const double end = std::clamp(before + beyond / density, last - 0.06, last + 0.02);
    return {end, std::max(1e-3, std::sqrt(std::max(beyond, 1.0)) / density)};
  }

  void set_ends(std::size_t k) {
    Segment& s = walls_[k].segment;
    const double half = s.length() / 2;
    const End a = end_of(profile(k, false), half), b = end_of(profile(k, true), half);
    const Vec2 middle = s.middle(), t = s.direction();
    shift_middle(s, (b.u - a.u) / 2);
    s.a = middle - a.u * t, s.b = middle + b.u * t;
    s.sigma_a = a.sigma, s.sigma_b = b.sigma;
  }

  void merge() {
    for (std::size_t i = 0; i < walls_.size(); ++i)
      for (std::size_t k = i + 1; k < walls_.size();) {
        if (!same_wall(walls_[i].segment, walls_[k].segment, o_)) {
          ++k;
          continue;
        }
        walls_[i].segment = walls_[i].found = fused(walls_[i].segment, walls_[k].segment);
        walls_[i].band = std::max(walls_[i].band, walls_[k].band);
        walls_.erase(walls_.begin() + static_cast<std::ptrdiff_t>(k));
        k = i + 1;
      }
  }

  // --- Pieces of what is left over ---------------------------------------------------------------

  void add_pieces() {
    assign();
    std::vector<std::size_t> seeds;
    for (std::size_t i = 0; i < owner_.size(); ++i)
      if (owner_[i] == kNobody) seeds.push_back(i);
    std::stable_sort(seeds.begin(), seeds.end(), [&](std::size_t a, std::size_t b) {
      return bits_.all()[a].returns > bits_.all()[b].returns;
    });
    used_.assign(owner_.size(), false);
    for (const std::size_t seed : seeds) {
      if (used_[seed]) continue;
      used_[seed] = true;
      if (const auto piece = grown(seed)) walls_.push_back(*piece);
    }
  }

  /// Mean and main axis of the free bits round p that face as `beam` does.
  std::optional<Segment> direction_at(const Vec2& p, const Vec2& beam) const {
    double n = 0;
    Vec2 sum = Vec2::Zero();
    Eigen::Matrix2d square = Eigen::Matrix2d::Zero();
    bits_.near(p, p, 0.12, [&](std::size_t i) {
      const SurfaceBit& bit = bits_.all()[i];
      if (owner_[i] != kNobody || (bit.mean - p).norm() > 0.12 || bit.beam.dot(beam) < 0) return;
      const Vec2 from = bit.mean - p;
      n += bit.returns, sum += bit.returns * from;
      square += bit.returns * (from * from.transpose() + bit.scatter);
    });
    if (!(n > 0)) return std::nullopt;
    const Vec2 mean = sum / n;
    square = square / n - mean * mean.transpose();
    const double angle = 0.5 * std::atan2(2 * square(0, 1), square(0, 0) - square(1, 1));
    Vec2 t(std::cos(angle), std::sin(angle));
    if (Segment::left_of(t).dot(beam) > 0) t = -t;
    Segment s;
    s.a = p + mean - 0.05 * t, s.b = p + mean + 0.05 * t;
    return s;
  }

  std::optional<Wall> grown(std::size_t seed) {
    const SurfaceBit& start = bits_.all()[seed];
    auto s = direction_at(start.mean, start.beam);
    if (!s) return std::nullopt;
    std::vector<std::size_t> members;
    for (int round = 0; round < 4; ++round) {
      members = along(*s);
      if (members.size() < 3 || !refit(*s, members)) return std::nullopt;
    }
    double returns = 0;
    int scans = 0, first = bits_.all()[members[0]].first_scan, last = 0;
    for (const std::size_t i : members) {
      const SurfaceBit& bit = bits_.all()[i];
      returns += bit.returns;
      scans = std::max(scans, bit.scans);
      first = std::min(first, bit.first_scan), last = std::max(last, bit.last_scan);
    }
    if (s->length() < r_.min_length || returns < r_.min_returns || last - first + 1 < o_.min_scans)
      return std::nullopt;
    scans = std::max(scans, o_.min_scans);  // of those scans some saw one part, some another
    for (const std::size_t i : members) used_[i] = true, owner_[i] = walls_.size();
    s->points = static_cast<std::size_t>(returns);
    s->scans = static_cast<std::size_t>(scans);
    return Wall{*s, r_.min_band, *s, returns};
  }

  /// Free bits on the line of s that hang together round its middle, by their way along it.
  std::vector<std::size_t> along(const Segment& s) const {
    const Axes axes(s);
    const Vec2 middle = s.middle(), reach = (s.length() / 2 + 0.5) * axes.t;
    std::vector<std::pair<double, std::size_t>> on;
    bits_.near(middle - reach, middle + reach, r_.min_band, [&](std::size_t i) {
      const SurfaceBit& bit = bits_.all()[i];
      if (owner_[i] != kNobody || !faces(bit, axes.n)) return;
      if (std::abs(axes.v(bit.mean)) <= r_.min_band)
        on.push_back({axes.t.dot(bit.mean - middle), i});
    });
    std::sort(on.begin(), on.end());
    const auto next = std::lower_bound(on.begin(), on.end(), std::pair(0.0, std::size_t{0}));
    auto first = next, last = next;
    while (last != on.end() && last->first - (last == next ? 0 : (last - 1)->first) <= r_.max_gap)
      ++last;
    while (first != on.begin() &&
           (first == next ? 0 : first->first) - (first - 1)->first <= r_.max_gap)
      --first;
    std::vector<std::size_t> members;
    for (auto i = first; i != last; ++i) members.push_back(i->second);
    return members;
  }

  bool refit(Segment& s, const std::vector<std::size_t>& members) const {
    double n = 0;
    Vec2 mean = Vec2::Zero();
    for (const std::size_t i : members) {
      n += bits_.all()[i].returns;
      mean += bits_.all()[i].returns * bits_.all()[i].mean;
    }
    mean /= n;
    Eigen::Matrix2d square = Eigen::Matrix2d::Zero();
    for (const std::size_t i : members) {
      const Vec2 from = bits_.all()[i].mean - mean;
      square += bits_.all()[i].returns * (from * from.transpose() + bits_.all()[i].scatter);
    }
    const double angle = 0.5 * std::atan2(2 * square(0, 1), square(0, 0) - square(1, 1));
    Vec2 t(std::cos(angle), std::sin(angle));
    if (t.dot(s.direction()) < 0) t = -t;
    double low = 1e9, high = -1e9;
    for (const std::size_t i : members) {
      const double u = t.dot(bits_.all()[i].mean - mean);
      low = std::min(low, u), high = std::max(high, u);
    }
    if (high - low < kBin) return false;
    s.a = mean + low * t, s.b = mean + high * t;
    return true;
  }

  // --- The end -----------------------------------------------------------------------------------

  void drop() {
    assign();
    std::erase_if(walls_, [&](const Wall& w) { return w.returns < r_.min_returns; });
  }

  /// Where an end is so near to another wall's line that both end in their corner.
  struct Corner {
    std::size_t wall;
    bool at_b;
    Vec2 place;
    double sigma;
  };

  std::optional<Corner> corner_at(std::size_t k, bool at_b) const {
    const Segment& s = walls_[k].segment;
    const Vec2 end = at_b ? s.b : s.a, t = s.direction();
    std::optional<Corner> best;
    double nearest = r_.corner_slack;
    for (std::size_t i = 0; i < walls_.size(); ++i) {
      const Segment& other = walls_[i].segment;
      if (i == k || distance_to(other, end) > 2 * r_.corner_slack) continue;
      const double sine = t.dot(other.normal());
      if (std::abs(sine) < std::sin(o_.scan.min_corner_angle)) continue;
      const double way = other.normal().dot(other.a - end) / sine;
      const Vec2 place = end + way * t;
      if (std::abs(way) > nearest || distance_to(other, place) > r_.corner_slack) continue;
      nearest = std::abs(way);
      const double far = other.direction().dot(place - other.middle());
      const Eigen::Matrix2d& c = other.covariance;
      const double across = c(0, 0) + 2 * far * c(0, 1) + far * far * c(1, 1);
      best = Corner{k, at_b, place,
                    std::sqrt(std::max(across, 0.0) + kShared * kShared) / std::abs(sine)};
    }
    return best;
  }

  std::vector<Corner> find_corners() const {
    std::vector<Corner> corners;
    for (std::size_t k = 0; k < walls_.size(); ++k)
      for (const bool at_b : {false, true})
        if (const auto corner = corner_at(k, at_b)) corners.push_back(*corner);
    return corners;
  }

  static void join(Segment& s, const Corner& c) {
    const Vec2 old = s.middle(), t = s.direction();
    (c.at_b ? s.b : s.a) = c.place;
    (c.at_b ? s.sigma_b : s.sigma_a) = c.sigma;
    shift_middle(s, t.dot(s.middle() - old));
  }

  /// Neighbouring poses err alike, so that returns in plenty do not make their errors smaller.
  void add_pose_errors(std::vector<Segment>& found) const {
    struct Mean {
      double returns = 0, heading = 0;
      Eigen::Matrix2d place = Eigen::Matrix2d::Zero();
    };
    std::vector<Mean> means(found.size());
    for (std::size_t i = 0; i < owner_.size(); ++i) {
      if (owner_[i] == kNobody) continue;
      const SurfaceBit& bit = bits_.all()[i];
      Mean& mean = means[owner_[i]];
      mean.returns += bit.returns;
      mean.heading += bit.returns * bit.heading_variance;
      mean.place += bit.returns * bit.pose_covariance;
    }
    for (std::size_t k = 0; k < found.size(); ++k) {
      Segment& s = found[k];
      const double n = std::max(means[k].returns, 1.0);
      const Eigen::Matrix2d place = means[k].place / n;
      const double along = std::sqrt(std::max(0.0, s.direction().dot(place * s.direction())));
      s.covariance(0, 0) += std::max(0.0, s.normal().dot(place * s.normal()));
      s.covariance(1, 1) += std::max(0.0, means[k].heading / n);
      s.sigma_a = std::hypot(s.sigma_a, along);
      s.sigma_b = std::hypot(s.sigma_b, along);
    }
  }

  const Site& site_;
  const SurfaceBits& bits_;
  const SegmentMapOptions& o_;
  const SegmentRefinementOptions& r_;
  std::vector<Wall> walls_;
  std::vector<std::size_t> owner_;  // of each bit
  std::vector<bool> shared_;        // bits that more than one wall could have returned
  std::vector<bool> used_;          // bits that were a seed or are in a piece
};

}  // namespace

std::vector<Segment> refined(const Site& site, std::vector<Segment> walls,
                             const SegmentMapOptions& options) {
  const OccupancyGrid grid = build_occupancy_grid(site);
  const SurfaceBits bits(
      site, grid,
      {options.refinement.cell, options.scan.max_range, options.key_spacing, options.key_turn});
  return without_gaps(Refinement(site, bits, walls, options).result(), grid,
                      options.refinement.open_gap, options.refinement.min_length);
}

}  // namespace majak::map
