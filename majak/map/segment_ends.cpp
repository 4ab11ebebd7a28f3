// SPDX-License-Identifier: Apache-2.0
#include "majak/map/segment_ends.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "majak/map/scan_choice.hpp"

namespace majak::map {
namespace {

constexpr double kBin = 0.001;  // m

/// Beams by where they cross the line, from `reach` inside of an end to as far outside.
struct Crossings {
  std::vector<std::uint32_t> met, passed;
};

/// A wall's end, looked at along the wall, outwards.
struct End {
  Vec2 place, outwards, normal;
  double inside = 0;  // m, how far the window may reach into the wall
  Segment own;
  std::vector<Segment> beside;  // other surfaces that are near
  Crossings crossings;
};

class EndFinder {
 public:
  EndFinder(const std::vector<Segment>& segments, const SegmentEndOptions& options) : o_(options) {
    const auto bins = static_cast<std::size_t>(std::lround(2 * o_.reach / kBin));
    const Crossings none{std::vector<std::uint32_t>(bins), std::vector<std::uint32_t>(bins)};
    for (const Segment& s : segments) {
      const double inside = std::min(o_.reach, s.length() / 2);
      for (const bool at_b : {false, true}) {
        End end{at_b ? s.b : s.a,
                at_b ? s.direction() : Vec2(-s.direction()),
                s.normal(),
                inside,
                s,
                {},
                none};
        for (const Segment& other : segments)
          if (&other != &s && distance_to(other, end.place) < o_.reach) end.beside.push_back(other);
        ends_.push_back(std::move(end));
      }
    }
  }

  void add(const PosedScan& posed) {
    const Pose2 T_map_laser = posed.estimate.T_map_robot * posed.scan.T_robot_laser;
    for (End& end : ends_) look(end, posed.scan, T_map_laser);
  }

  /// How far out the end lies, and how sure that is; false where no beam passed.
  bool found(std::size_t number, double& way, double& sigma) const {
    const Crossings& c = ends_[number].crossings;
    const auto total = std::accumulate(c.passed.begin(), c.passed.end(), std::uint64_t{0});
    if (total < 3 || std::accumulate(c.met.begin(), c.met.end(), std::uint64_t{0}) < 3)
      return false;
    // The place with the fewest beams on its wrong side: met beyond it, passed before it.
    std::int64_t wrong = std::accumulate(c.met.begin(), c.met.end(), std::int64_t{0});
    std::int64_t least = wrong;
    std::size_t first = 0, last = 0;
    for (std::size_t i = 0; i < c.met.size(); ++i) {
      wrong += static_cast<std::int64_t>(c.passed[i]) - static_cast<std::int64_t>(c.met[i]);
      if (wrong < least)
        least = wrong, first = last = i + 1;
      else if (wrong == least && last == i)
        last = i + 1;
    }
    if (first == 0 || last == c.met.size()) return false;
    way = (static_cast<double>(first + last) / 2) * kBin - o_.reach;
    sigma = spread(c, first, last);
    return true;
  }

 private:
  /// Uniform in the empty space between, and what beams on the wrong side tell of their errors.
  static double spread(const Crossings& c, std::size_t first, std::size_t last) {
    const double empty = static_cast<double>(last - first + 1) * kBin;
    double wrong = 0, way = 0;
    for (std::size_t i = 0; i < c.met.size(); ++i) {
      const double n = i >= last ? c.met[i] : i < first ? c.passed[i] : 0;
      wrong += n;
      way += n * (static_cast<double>(i >= last ? i - last : first - i) * kBin);
    }
    const double error = wrong > 0 ? way / wrong : 0;
    const auto window = static_cast<std::size_t>(0.03 / kBin);
    const std::size_t low = first > window ? first - window : 0;
    const std::size_t high = std::min(c.met.size(), last + window);
    double beams = 0;
    for (std::size_t i = low; i < high; ++i) beams += c.met[i] + c.passed[i];
    const double density = std::max(beams, 1.0) / (static_cast<double>(high - low) * kBin);
    return std::sqrt(empty * empty / 12 + error / density);
  }

  void look(End& end, const Scan& scan, const Pose2& T_map_laser) {
    const Vec2 from = T_map_laser.translation() - end.place;
    const double height = end.normal.dot(from), back = end.outwards.dot(from);
    const double distance2 = from.squaredNorm();
    if (height <= 0 || distance2 > o_.max_range * o_.max_range) return;
    const double sine = std::sin(o_.grazing);
    if (height * height < sine * sine * distance2) return;
    const auto bearing = [&](double u) {
      const Vec2 p = (u - back) * end.outwards - height * end.normal;
      return wrap_angle(std::atan2(p.y(), p.x()) - T_map_laser.theta - scan.start_angle);
    };
    if (scan.angle_step == 0) return;
    const double one = bearing(-end.inside) / scan.angle_step;
    double two = bearing(o_.reach) / scan.angle_step;
    if (std::abs(two - one) > std::abs(kPi / scan.angle_step)) return;  // behind the seam
    const auto n = static_cast<double>(scan.ranges.size());
    const double low = std::max(0.0, std::ceil(std::min(one, two)));
    const double high = std::min(n - 1, std::floor(std::max(one, two)));
    for (double k = low; k <= high; ++k) {
      const auto i = static_cast<std::size_t>(k);
      const double range = scan.ranges[i];
      if (!std::isfinite(range) || range <= 0 || range > o_.max_range) continue;
      const double angle = T_map_laser.theta + scan.angle(i);
      const Vec2 beam(std::cos(angle), std::sin(angle));
      const double down = -end.normal.dot(beam);
      if (down < sine) continue;
      count(end, back + end.outwards.dot(beam) * height / down, range * down - height,
            T_map_laser.translation() + range * beam);
    }
  }

  /// A beam that crosses the line at u and ends `behind` it, at p.
  void count(End& end, double u, double behind, const Vec2& p) const {
    Crossings& c = end.crossings;
    const double bin = std::floor((u + o_.reach) / kBin);
    if (bin < 0 || bin >= static_cast<double>(c.met.size()) || behind < -o_.band) return;
    const bool met = behind <= o_.band;
    if (!met && behind <= 2 * o_.band) return;
    const double away = distance_to(end.own, p);
    if (met && std::any_of(end.beside.begin(), end.beside.end(),
                           [&](const Segment& other) { return distance_to(other, p) < away; }))
      return;
    ++(met ? c.met : c.passed)[static_cast<std::size_t>(bin)];
  }

  SegmentEndOptions o_;
  std::vector<End> ends_;  // a and b of each
};

}  // namespace

void shift_middle(Segment& segment, double way) {
  const Eigen::Matrix2d lever = (Eigen::Matrix2d() << 1, way, 0, 1).finished();
  segment.covariance = lever * segment.covariance * lever.transpose();
}

void sharpen_ends(const Site& site, std::vector<Segment>& segments,
                  const SegmentEndOptions& options) {
  EndFinder finder(segments, options);
  for_spaced_scans(site, options.key_spacing, options.key_turn,
                   [&](const PosedScan& posed) { finder.add(posed); });
  for (std::size_t k = 0; k < segments.size(); ++k) {
    Segment& s = segments[k];
    const Vec2 t = s.direction(), middle = s.middle();
    double way = 0, sigma = 0;
    const bool a = finder.found(2 * k, way, sigma);
    if (a) s.a -= way * t, s.sigma_a = sigma;
    if (finder.found(2 * k + 1, way, sigma)) s.b += way * t, s.sigma_b = sigma;
    shift_middle(s, t.dot(s.middle() - middle));
  }
}

}  // namespace majak::map
