// SPDX-License-Identifier: Apache-2.0
// Parts of sketches of robots and their errors.
#pragma once

#include <vector>

#include "majak/draw/figure.hpp"

namespace majak::draw {

inline Point point(const Vec2& p) { return {p.x(), p.y()}; }

/// A pose's frame seen on the sheet with the robot looking up it.
inline constexpr Pose2 kLooksUp{0, 0, kPi / 2};

/// A wheel seen from above that rolls along its pose's x.
Polyline wheel(const Pose2& pose, const Colour& colour, double length = 0.2);

/// Part of a circle, from one direction (rad) counter-clockwise to another.
std::vector<Point> arc(const Point& centre, double radius, double from, double to);

/// The way of a point of the robot while it moves from `pose` by exp(twist).
std::vector<Point> way_of(const Vec2& p_robot, const Pose2& pose, const Vec3& twist);

/// Where a share of all robots are (`chi2` as for covariance_ellipse) whose error log(pose^-1 *
/// truth) has this covariance: the ellipse, bent as the heading's error bends it.
std::vector<Point> bent_ellipse(const Pose2& pose, const Mat3& covariance,
                                double chi2 = 5.991464547107979);

}  // namespace majak::draw
