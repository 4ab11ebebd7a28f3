// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/map_quality.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "majak/eval/point_index.hpp"

namespace majak::eval {
namespace {

std::vector<std::size_t> scans_to_draw(const Site& site) {
  const bool has_keys =
      std::any_of(site.scans.begin(), site.scans.end(), [](const PosedScan& s) { return s.key; });
  std::vector<std::size_t> drawn;
  for (std::size_t i = 0; i < site.scans.size(); ++i) {
    const PosedScan& s = site.scans[i];
    if (s.estimate.health == Health::lost || !s.estimate.T_map_robot.finite()) continue;
    if (s.key || !has_keys) drawn.push_back(i);
  }
  return drawn;
}

bool usable(float range, const MapQualityOptions& options) {
  return std::isfinite(range) && range > 0.05F && range < options.max_range;
}

std::vector<MapPoint> points_of(const Site& site, const MapQualityOptions& options) {
  const auto drawn = scans_to_draw(site);
  std::size_t total = 0;
  for (const std::size_t i : drawn) {
    for (const float r : site.scans[i].scan.ranges) total += usable(r, options) ? 1 : 0;
  }
  const std::size_t stride = total / std::max<std::size_t>(options.max_points, 1) + 1;
  std::vector<MapPoint> points;
  points.reserve(total / stride + 1000);
  for (std::size_t k = 0; k < drawn.size(); k += stride) {
    const Scan& scan = site.scans[drawn[k]].scan;
    const Pose2 T_map_laser = site.scans[drawn[k]].estimate.T_map_robot * scan.T_robot_laser;
    for (std::size_t b = 0; b < scan.ranges.size(); ++b) {
      if (!usable(scan.ranges[b], options)) continue;
      const double direction = T_map_laser.theta + scan.angle(b), range = scan.ranges[b];
      const double vx = std::cos(direction), vy = std::sin(direction);
      points.push_back({static_cast<float>(T_map_laser.x + range * vx),
                        static_cast<float>(T_map_laser.y + range * vy), static_cast<float>(vx),
                        static_cast<float>(vy), static_cast<std::int32_t>(drawn[k])});
    }
  }
  return points;
}

/// Moments of a set of points about a centre, and the line through them.
struct Blob {
  int count = 0;
  double x = 0, y = 0, xx = 0, xy = 0, yy = 0;

  void add(double dx, double dy) {
    ++count;
    x += dx, y += dy;
    xx += dx * dx, xy += dx * dy, yy += dy * dy;
  }
};

struct Line {
  Vec2 middle;       ///< from the blob's centre, m
  Vec2 normal;       ///< unit
  double thin = 0;   ///< m, sigma across
  double along = 0;  ///< m, sigma along
};

Line line_through(const Blob& b) {
  const double n = b.count, mx = b.x / n, my = b.y / n;
  const double xx = b.xx / n - mx * mx, xy = b.xy / n - mx * my, yy = b.yy / n - my * my;
  const double half_trace = 0.5 * (xx + yy);
  const double spread = std::hypot(0.5 * (xx - yy), xy);
  const double direction = 0.5 * std::atan2(2 * xy, xx - yy);
  return {{mx, my},
          {-std::sin(direction), std::cos(direction)},
          std::sqrt(std::max(half_trace - spread, 0.0)),
          std::sqrt(std::max(half_trace + spread, 0.0))};
}

constexpr int kFewest = 8;  // points that make a neighbourhood

/// A wall crosses the neighbourhood: points all along it (a full line has 0.58 radius). Nothing is
/// asked of the thickness, or blurred walls would drop out of the measure of blur.
bool is_wall(const Line& line, double radius) { return line.along > 0.4 * radius; }

/// On which side of the wall the laser stood: +1, -1, or 0 at a grazing view.
int side(const MapPoint& p, const Vec2& normal) {
  const double cosine = p.view_x * normal.x() + p.view_y * normal.y();
  return cosine > 0.2 ? 1 : cosine < -0.2 ? -1 : 0;
}

struct WallSample {
  Vec2 at;
  Line line;
  int side;
};

class Examiner {
 public:
  Examiner(const Site& site, const MapQualityOptions& options)
      : site_(site), options_(options), index_(points_of(site, options), options.radius) {}

  MapQuality run() {
    const auto& points = index_.points();
    quality_.points = points.size();
    const std::size_t step = points.size() / std::max<std::size_t>(options_.samples, 1) + 1;
    for (std::size_t i = 0; i < points.size(); i += step) examine(points[i]);
    finish();
    return quality_;
  }

 private:
  void examine(const MapPoint& p) {
    const Vec2 at(p.x, p.y);
    ++quality_.samples;
    Blob blob;
    index_.for_each_near(at, options_.radius,
                         [&](const MapPoint& q) { blob.add(q.x - at.x(), q.y - at.y()); });
    if (blob.count >= kFewest) {
      const Line line = line_through(blob);
      // 1 mm keeps the entropy of a simulated, noiseless wall finite.
      const double thin = std::hypot(line.thin, 1e-3), along = std::hypot(line.along, 1e-3);
      entropies_.push_back(std::log(2 * kPi * std::exp(1.0) * thin * along));
      if (is_wall(line, options_.radius)) {
        thickness_.push_back(line.thin);
        look_for_second_wall({at, line, side(p, line.normal)});
      }
    }
    look_for_earlier_visit(p, at);
  }

  /// Profile of the points along the wall's normal: a second peak behind a valley is a second wall.
  void look_for_second_wall(const WallSample& wall) {
    if (wall.side == 0) return;
    ++walls_;
    constexpr double kBin = 0.02;  // m
    const int half = static_cast<int>(std::ceil(options_.doubled_to / kBin));
    std::vector<int> profile(2 * static_cast<std::size_t>(half) + 1, 0);
    beside_.clear();
    index_.for_each_near(wall.at, std::hypot(options_.doubled_to, 0.1), [&](const MapPoint& q) {
      const Vec2 d(q.x - wall.at.x(), q.y - wall.at.y());
      const double across = d.dot(wall.line.normal);
      const double along = d.x() * wall.line.normal.y() - d.y() * wall.line.normal.x();
      if (std::abs(along) > 0.1 || std::abs(across) > options_.doubled_to) return;
      if (side(q, wall.line.normal) != wall.side) return;
      ++profile[static_cast<std::size_t>(std::lround(across / kBin) + half)];
      beside_.push_back({across, q.scan});
    });
    if (second_peak(profile, half, kBin)) ++doubled_;
  }

  bool second_peak(const std::vector<int>& profile, int half, double bin) const {
    const auto mass = [&](int i) {  // three bins
      int sum = 0;
      for (int k = i - 1; k <= i + 1; ++k) {
        if (k >= -half && k <= half) sum += profile[static_cast<std::size_t>(k + half)];
      }
      return sum;
    };
    int own = -2;
    for (int i = -2; i <= 2; ++i) own = mass(i) > mass(own) ? i : own;
    const int nearest = static_cast<int>(std::ceil(options_.doubled_from / bin));
    for (int other = -half; other <= half; ++other) {
      if (std::abs(other - own) < nearest || mass(other) < std::max(5, mass(own) / 3)) continue;
      int valley = mass(other);
      for (int i = std::min(own, other); i <= std::max(own, other); ++i) {
        valley = std::min(valley, mass(i));
      }
      if (2 * valley < std::min(mass(own), mass(other)) &&
          seen_apart(own * bin, other * bin, bin)) {
        return true;
      }
    }
    return false;
  }

  /// What one scan sees as two surfaces is two surfaces (a step, a door frame), not a doubled wall.
  bool seen_apart(double own, double other, double bin) const {
    std::vector<std::int32_t> first, second, both;
    for (const auto& [across, scan] : beside_) {
      if (std::abs(across - own) <= 1.5 * bin) first.push_back(scan);
      if (std::abs(across - other) <= 1.5 * bin) second.push_back(scan);
    }
    for (auto* list : {&first, &second}) {
      std::sort(list->begin(), list->end());
      list->erase(std::unique(list->begin(), list->end()), list->end());
    }
    std::set_intersection(first.begin(), first.end(), second.begin(), second.end(),
                          std::back_inserter(both));
    return 5 * both.size() <= std::min(first.size(), second.size());
  }

  void look_for_earlier_visit(const MapPoint& p, const Vec2& at) {
    const Time before = time_of(p) - options_.revisit_after;
    Blob blob;
    index_.for_each_near(at, options_.revisit_radius, [&](const MapPoint& q) {
      const bool same_way = p.view_x * q.view_x + p.view_y * q.view_y > 0;
      if (same_way && time_of(q) < before) blob.add(q.x - at.x(), q.y - at.y());
    });
    if (blob.count < kFewest) return;
    const Line line = line_through(blob);
    if (!is_wall(line, options_.revisit_radius) || line.thin > 0.3 * line.along) return;
    revisit_.push_back(std::abs(line.middle.dot(line.normal)));
  }

  Time time_of(const MapPoint& p) const {
    return site_.scans[static_cast<std::size_t>(p.scan)].scan.time;
  }

  void finish() {
    const auto share = [](std::size_t part, std::size_t of) {
      return of == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(of);
    };
    for (const double e : entropies_)
      quality_.entropy += e / static_cast<double>(entropies_.size());
    quality_.wall_thickness = quantile(std::move(thickness_), 0.5);
    quality_.doubled_share = share(doubled_, walls_);
    quality_.revisited_share = share(revisit_.size(), quality_.samples);
    const auto beyond =
        std::count_if(revisit_.begin(), revisit_.end(), [](double d) { return d > 0.1; });
    quality_.revisit_beyond = share(static_cast<std::size_t>(beyond), revisit_.size());
    quality_.revisit = error_stats(std::move(revisit_));
  }

  struct Beside {
    double across;
    std::int32_t scan;
  };
  const Site& site_;
  MapQualityOptions options_;
  PointIndex index_;
  MapQuality quality_;
  std::vector<double> thickness_, entropies_, revisit_;
  std::vector<Beside> beside_;
  std::size_t walls_ = 0, doubled_ = 0;
};

}  // namespace

MapQuality measure_map_quality(const Site& site, const MapQualityOptions& options) {
  return Examiner(site, options).run();
}

}  // namespace majak::eval
