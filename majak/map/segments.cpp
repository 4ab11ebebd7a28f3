// SPDX-License-Identifier: Apache-2.0
#include "majak/map/segments.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace majak::map {
namespace {

struct Point {
  Vec2 p;  // laser frame
  double range, angle;
};

/// Points [first, last] that lie on one line.
struct Run {
  std::size_t first, last;
  bool joined = false;  // the run before ends at the point before, and no jump lies between
  std::size_t size() const { return last - first + 1; }
};

struct Fit {
  Vec2 mean = Vec2::Zero(), direction = Vec2::Zero();
  double weight = 0, moment = 0;  // sums of w and of w s^2: 1 / m^2, 1
  double offset(const Vec2& p) const { return Segment::left_of(direction).dot(p - mean); }
  double along(const Vec2& p) const { return direction.dot(p - mean); }
};

/// Variance of a point across a line of this normal (MATH 15.1).
double variance_across(const Point& point, const Vec2& normal, const SegmentOptions& o) {
  const Vec2 beam = point.p / point.range;
  const double cosine = beam.dot(normal), sine = beam.dot(Segment::left_of(normal));
  const double aside = point.range * o.bearing_sigma;
  return o.range_sigma * o.range_sigma * cosine * cosine + aside * aside * sine * sine;
}

class Extraction {
 public:
  Extraction(const Scan& scan, const SegmentOptions& options) : o_(options) { read(scan); }

  std::vector<Segment> segments() const {
    std::vector<Run> runs;
    for (std::size_t i = 0; i < breaks_.size(); ++i) {
      const std::size_t end = i + 1 < breaks_.size() ? breaks_[i + 1] : points_.size();
      const std::size_t begin = runs.size();
      split(breaks_[i], end - 1, runs);
      for (std::size_t k = begin + 1; k < runs.size(); ++k) runs[k].joined = true;
    }
    merge(runs);
    for (int round = 0; round < 2; ++round) settle_borders(runs);  // the second with cleaner lines
    return fitted(runs);
  }

 private:
  void read(const Scan& scan) {
    const std::size_t n = scan.ranges.size();
    bool broken = true;
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t i = scan.angle_step > 0 ? k : n - 1 - k;
      const double range = scan.ranges[i], angle = scan.angle(i);
      if (std::isnan(range) || range < 0) continue;
      if (!std::isfinite(range) || range <= 0 || range > o_.max_range) {
        broken = true;
        continue;
      }
      const Point next{{range * std::cos(angle), range * std::sin(angle)}, range, angle};
      if (broken || jumps(points_.back(), next)) breaks_.push_back(points_.size());
      points_.push_back(next);
      broken = false;
    }
    step_ = std::abs(scan.angle_step);
  }

  /// The adaptive breakpoint of Borges and Aldon, and the rule of gaps.
  bool jumps(const Point& a, const Point& b) const {
    const double turn = b.angle - a.angle, way = (b.p - a.p).norm();
    if (way > o_.max_gap || turn >= o_.grazing) return true;
    const double reach = std::min(a.range, b.range) * std::sin(turn) / std::sin(o_.grazing - turn);
    return way > reach + 3 * o_.range_sigma;
  }

  void split(std::size_t first, std::size_t last, std::vector<Run>& runs) const {
    const Vec2 chord = points_[last].p - points_[first].p;
    const double length = chord.norm();
    std::size_t farthest = first;
    double most = o_.split_distance;
    for (std::size_t i = first + 1; i < last; ++i) {
      const Vec2 from = points_[i].p - points_[first].p;
      const double off =
          length > 0 ? std::abs(Segment::left_of(chord).dot(from)) / length : from.norm();
      if (off > most) most = off, farthest = i;
    }
    if (farthest == first) {
      runs.push_back({first, last});
      return;
    }
    split(first, farthest, runs);
    split(farthest + 1, last, runs);
  }

  Fit fit(std::size_t first, std::size_t last) const {
    Fit fit;
    fit.direction = (points_[last].p - points_[first].p).normalized();
    for (int round = 0; round < 3; ++round) {  // the weights hang on the direction
      const Vec2 normal = Segment::left_of(fit.direction), near = points_[first].p;
      Vec2 sum = Vec2::Zero();
      Eigen::Matrix2d square = Eigen::Matrix2d::Zero();
      fit.weight = 0;
      for (std::size_t i = first; i <= last; ++i) {
        const double w = 1 / variance_across(points_[i], normal, o_);
        const Vec2 p = points_[i].p - near;
        fit.weight += w;
        sum += w * p;
        square += w * p * p.transpose();
      }
      const Vec2 mean = sum / fit.weight;
      square -= fit.weight * mean * mean.transpose();
      const double angle = 0.5 * std::atan2(2 * square(0, 1), square(0, 0) - square(1, 1));
      const Vec2 axis(std::cos(angle), std::sin(angle));
      fit.mean = near + mean;
      fit.direction = axis.dot(fit.direction) < 0 ? Vec2(-axis) : axis;
      fit.moment = axis.dot(square * axis);
    }
    return fit;
  }

  /// A corner's point belongs to the line that it is nearer to.
  void settle_borders(std::vector<Run>& runs) const {
    for (std::size_t k = 1; k < runs.size(); ++k) {
      Run &before = runs[k - 1], &after = runs[k];
      if (!after.joined || before.size() < 4 || after.size() < 4) continue;
      const Fit left = fit(before.first, before.last - 1), right = fit(after.first + 1, after.last);
      const auto belongs_left = [&](std::size_t i) {
        return std::abs(left.offset(points_[i].p)) <= std::abs(right.offset(points_[i].p));
      };
      while (before.size() > 3 && !belongs_left(before.last)) --before.last, --after.first;
      while (after.size() > 3 && belongs_left(after.first)) ++before.last, ++after.first;
    }
  }

  bool straight(const Fit& line, std::size_t first, std::size_t last) const {
    for (std::size_t i = first; i <= last; ++i)
      if (std::abs(line.offset(points_[i].p)) > o_.split_distance) return false;
    return true;
  }

  /// Neighbours that one line fits: a chord between noisy ends splits more than a fit does.
  void merge(std::vector<Run>& runs) const {
    std::vector<Run> merged;
    for (const Run& run : runs) {
      const bool may = run.joined && !merged.empty() && merged.back().last + 1 == run.first;
      if (may && straight(fit(merged.back().first, run.last), merged.back().first, run.last)) {
        merged.back().last = run.last;
      } else {
        merged.push_back(run);
      }
    }
    runs = std::move(merged);
  }

  std::vector<Segment> fitted(const std::vector<Run>& runs) const {
    std::vector<Segment> found;
    const Run* last = nullptr;  // of the last one found
    for (const Run& run : runs) {
      if (run.size() < static_cast<std::size_t>(o_.min_points)) continue;
      const Segment segment = segment_of(run);
      if ((points_[run.last].p - points_[run.first].p).norm() < o_.min_length) continue;
      found.push_back(segment);
      const std::size_t n = found.size();
      if (last && run.joined && last->last + 1 == run.first) join(found[n - 2], found[n - 1]);
      last = &run;
    }
    return found;
  }

  Segment segment_of(const Run& run) const {
    const Fit line = fit(run.first, run.last);
    const Point &first = points_[run.first], &last = points_[run.last];
    Segment s;
    // Less a standard deviation: of many sights of one end the farthest will be taken.
    const double from = line.along(first.p) + along_sigma(first, line);
    const double to = line.along(last.p) - along_sigma(last, line);
    s.a = line.mean + from * line.direction;
    s.b = line.mean + to * line.direction;
    s.covariance = covariance_at(line, line.along(s.middle()));
    s.sigma_a = end_sigma(first, line);
    s.sigma_b = end_sigma(last, line);
    s.points = run.size();
    return s;
  }

  /// At s along the line from the mean of the points, where offset and turn are independent.
  static Eigen::Matrix2d covariance_at(const Fit& line, double s) {
    const double offset = 1 / line.weight, turn = 1 / line.moment;
    Eigen::Matrix2d m;
    m << offset + s * s * turn, s * turn, s * turn, turn;
    return m;
  }

  double along_sigma(const Point& point, const Fit& line) const {
    return std::sqrt(variance_across(point, line.direction, o_));
  }

  /// The surface ends somewhere between this beam and the next (MATH 15.2).
  double end_sigma(const Point& end, const Fit& line) const {
    const double cosine = std::abs(end.p.dot(Segment::left_of(line.direction))) / end.range;
    const double spacing = std::min(o_.max_gap, end.range * step_ / std::max(cosine, 1e-3));
    return std::hypot(spacing / std::sqrt(3.0), along_sigma(end, line));
  }

  /// Neighbours that meet in a corner end in it, when it lies between their last beams.
  void join(Segment& before, Segment& after) const {
    const Vec2 t = before.direction(), n = after.normal();
    const double sine = t.dot(n);
    if (std::abs(sine) < std::sin(o_.min_corner_angle)) return;
    const double way = n.dot(after.a - before.b) / sine;
    const Vec2 corner = before.b + way * t;
    const double back = after.direction().dot(after.a - corner);
    const double slack = 3 * o_.range_sigma;
    const double most_before = std::sqrt(3.0) * before.sigma_b + slack;
    const double most_after = std::sqrt(3.0) * after.sigma_a + slack;
    if (way < -slack || way > most_before || back < -slack || back > most_after) return;
    // Offset and turn stay those of the fit; only where they are stated moves to the new middle.
    const double sigma_before = std::sqrt(before.covariance(0, 0));
    const double sigma_after = std::sqrt(after.covariance(0, 0));
    before.covariance = shifted(before.covariance, way / 2);
    after.covariance = shifted(after.covariance, -back / 2);
    before.b = after.a = corner;
    before.sigma_b = sigma_after / std::abs(sine);
    after.sigma_a = sigma_before / std::abs(sine);
  }

  static Eigen::Matrix2d shifted(const Eigen::Matrix2d& covariance, double s) {
    const Eigen::Matrix2d lever = (Eigen::Matrix2d() << 1, s, 0, 1).finished();
    return lever * covariance * lever.transpose();
  }

  SegmentOptions o_;
  double step_ = 0;
  std::vector<Point> points_;
  std::vector<std::size_t> breaks_;  // first points of pieces without a jump
};

Eigen::Matrix2d covariance_of_end(const Segment& segment, double s, double sigma) {
  const Eigen::Matrix2d& c = segment.covariance;
  const double across = c(0, 0) + 2 * s * c(0, 1) + s * s * c(1, 1);
  const Vec2 t = segment.direction(), n = segment.normal();
  return sigma * sigma * t * t.transpose() + across * n * n.transpose();
}

}  // namespace

Line line_of(const Segment& segment) {
  const Vec2 n = segment.normal();
  // A turn about the middle moves the line at the foot of the origin.
  const double lever = Segment::left_of(n).dot(segment.middle());
  const Eigen::Matrix2d m = (Eigen::Matrix2d() << 1, lever, 0, 1).finished();
  return {n.dot(segment.middle()), std::atan2(n.y(), n.x()),
          m * segment.covariance * m.transpose()};
}

Eigen::Matrix2d covariance_of_a(const Segment& segment) {
  return covariance_of_end(segment, -segment.length() / 2, segment.sigma_a);
}

Eigen::Matrix2d covariance_of_b(const Segment& segment) {
  return covariance_of_end(segment, segment.length() / 2, segment.sigma_b);
}

Segment moved(const Pose2& T_new_old, Segment segment) {
  segment.a = T_new_old * segment.a;
  segment.b = T_new_old * segment.b;
  return segment;
}

double distance_to(const Segment& segment, const Vec2& point) {
  const Vec2 way = segment.b - segment.a;
  const double length2 = way.squaredNorm();
  const double u = length2 > 0 ? std::clamp(way.dot(point - segment.a) / length2, 0.0, 1.0) : 0.0;
  return (segment.a + u * way - point).norm();
}

std::vector<Segment> extract_segments(const Scan& scan, const SegmentOptions& options) {
  std::vector<Segment> found = Extraction(scan, options).segments();
  for (Segment& s : found) s = moved(scan.T_robot_laser, s);
  return found;
}

}  // namespace majak::map
