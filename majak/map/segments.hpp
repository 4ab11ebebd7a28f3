// SPDX-License-Identifier: Apache-2.0
// Straight pieces of a scan: split and merge on the ordered beams (Nguyen et al. 2007), broken
// where the range jumps (Borges and Aldon 2004), fitted with weights and with the covariance of the
// line (Pfister et al. 2003). MATH 15.
#pragma once

#include <cstddef>
#include <vector>

#include "majak/core/event.hpp"
#include "majak/core/options.hpp"

namespace majak::map {

/// A straight piece of a surface, in the frame that the function which returns it names. It was
/// seen from its left: the normal, left of the way from a to b, points to the observer.
struct Segment {
  Vec2 a = Vec2::Zero(), b = Vec2::Zero();  ///< m
  /// Of (offset along the normal at the middle, turn); m^2, m rad, rad^2. No frame changes it.
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  double sigma_a = 0, sigma_b = 0;  ///< m, of the ends along the line
  std::size_t points = 0;           ///< returns that it was fitted to
  std::size_t scans = 1;            ///< in which it was seen

  double length() const { return (b - a).norm(); }
  Vec2 middle() const { return (a + b) / 2; }
  Vec2 direction() const { return (b - a).normalized(); }
  Vec2 normal() const { return left_of(direction()); }
  static Vec2 left_of(const Vec2& v) { return {-v.y(), v.x()}; }
};

/// The line of a segment: all p with p . (cos phi, sin phi) = rho. The normal is the segment's, so
/// that rho is negative where the observer's side holds the origin.
struct Line {
  double rho = 0, phi = 0;     ///< m, rad
  Eigen::Matrix2d covariance;  ///< of (rho, phi): m^2, m rad, rad^2
};
Line line_of(const Segment& segment);

/// Covariance of a and of b in the segment's frame, m^2.
Eigen::Matrix2d covariance_of_a(const Segment& segment);
Eigen::Matrix2d covariance_of_b(const Segment& segment);

/// The segment in another frame; the pose is taken to be exact.
Segment moved(const Pose2& T_new_old, Segment segment);

double distance_to(const Segment& segment, const Vec2& point);

struct SegmentOptions {
  double range_sigma = 0.01;      ///< m
  double bearing_sigma = 0.001;   ///< rad
  double max_range = 30;          ///< m, longer beams are left out
  double split_distance = 0.05;   ///< m, from a chord; a point farther off splits it
  double grazing = 0.17;          ///< rad; a surface hit at a smaller angle is taken for a jump
  double max_gap = 0.5;           ///< m, between neighbouring points of one segment
  double min_length = 0.3;        ///< m
  int min_points = 6;             ///< of one segment
  double min_corner_angle = 0.5;  ///< rad; ends of neighbours that meet at less are not joined
};

inline void describe(OptionFields& fields, SegmentOptions& o) {
  fields.add("segments.range_sigma", o.range_sigma, {"m", "noise of a range", 1e-4, 1});
  fields.add("segments.bearing_sigma", o.bearing_sigma, {"rad", "noise of a bearing", 0, 0.1});
  fields.add("segments.max_range", o.max_range, {"m", "longer beams are left out", 0.1, 1000});
  fields.add("segments.split_distance", o.split_distance,
             {"m", "a point farther from the chord splits it", 1e-6, 10});
  fields.add("segments.grazing", o.grazing,
             {"rad", "a surface hit at a smaller angle is taken for a jump", 0.02, 1.5});
  fields.add("segments.max_gap", o.max_gap,
             {"m", "between neighbouring points of one segment", 0.01, 100});
  fields.add("segments.min_length", o.min_length, {"m", "of a segment", 0, 100});
  fields.add("segments.min_points", o.min_points, {"1", "of a segment", 3, 10000});
  fields.add("segments.min_corner_angle", o.min_corner_angle,
             {"rad", "ends of neighbours that meet at less are not joined", 0.05, 1.5});
}

/// The segments of one scan in the robot's frame, in the order of the beams, counter-clockwise.
/// Beams without return break a segment, beams of unknown range are left out.
std::vector<Segment> extract_segments(const Scan& scan, const SegmentOptions& options = {});

}  // namespace majak::map
