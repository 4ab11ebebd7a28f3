// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/range_bias.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "majak/core/angle.hpp"

namespace majak::slam {
namespace {

using Law = RangeBias::Weights;  ///< how much of each column the error of the ranges has

constexpr double kGate = 0.075;  // m

/// A room without corners that stand in the way, walls at 0 and `size`.
struct Room {
  Vec2 size{9, 6};

  /// What a laser at T_map_robot * T_robot_laser sees, `half` rad to each side, if its ranges err.
  KeyScan scan(const Pose2& T_map_robot, double half, int beams, const Pose2& T_robot_laser = {},
               const Law& law = Law::Zero()) const {
    KeyScan key;
    key.T_map_robot = T_map_robot;
    key.T_robot_laser = T_robot_laser;
    const Pose2 T_map_laser = T_map_robot * T_robot_laser;
    for (int i = 0; i < beams; ++i) {
      const double bearing = half * (2.0 * i / (beams - 1) - 1);
      const auto [range, normal] = cast(T_map_laser, bearing);
      const double seen = range + law.dot(RangeBias::at(range));
      const Vec2 p = T_robot_laser * Vec2(seen * std::cos(bearing), seen * std::sin(bearing));
      const Vec2 n = Pose2{0, 0, -T_map_robot.theta} * normal;
      key.points.x.push_back(static_cast<float>(p.x()));
      key.points.y.push_back(static_cast<float>(p.y()));
      key.points.nx.push_back(static_cast<float>(n.x()));
      key.points.ny.push_back(static_cast<float>(n.y()));
      key.points.target.push_back(1);
    }
    return key;
  }

 private:
  struct Seen {
    double range = std::numeric_limits<double>::infinity();
    Vec2 normal = Vec2::Zero();
  };
  Seen cast(const Pose2& T_map_laser, double bearing) const {
    const Vec2 ray(std::cos(T_map_laser.theta + bearing), std::sin(T_map_laser.theta + bearing));
    const Vec2 from = T_map_laser.translation();
    Seen seen;
    for (int axis = 0; axis < 2; ++axis) {
      const double wall = ray[axis] > 0 ? size[axis] : 0, range = (wall - from[axis]) / ray[axis];
      if (!(range < seen.range)) continue;
      seen.range = range;
      seen.normal = Vec2::Zero();
      seen.normal[axis] = ray[axis] > 0 ? -1 : 1;
    }
    return seen;
  }
};

/// Law of an error that is `share` of the range, up to 16 m.
Law proportional(double share) {
  Law law = Law::Zero();
  for (int k = 0; k + 1 < RangeBias::kCount; ++k)
    law(1 + k) = share * RangeBias::kSpacing * k / RangeBias::kHat;
  return law;
}

Vec3 shift(const KeyScan& target, const KeyScan& source, const Law& law) {
  return RangeBias::shift(target, laser_view(target), source, kGate) * law;
}

/// Point to line with the nearest return of the target, from the true pose until nothing moves.
Pose2 matched(const KeyScan& target, const KeyScan& source) {
  Pose2 T = between(target.T_map_robot, source.T_map_robot);
  for (int round = 0; round < 10; ++round) {
    Mat3 h = 1e-9 * Mat3::Identity();
    Vec3 g = Vec3::Zero();
    for (std::size_t i = 0; i < source.points.size(); ++i) {
      const Vec2 p(source.points.x[i], source.points.y[i]), at = T * p;
      double nearest = kGate * kGate;
      std::size_t pair = target.points.size();
      for (std::size_t k = 0; k < target.points.size(); ++k) {
        const double d = (at - Vec2(target.points.x[k], target.points.y[k])).squaredNorm();
        if (d < nearest) nearest = d, pair = k;
      }
      if (pair == target.points.size()) continue;
      const Vec2 to(target.points.x[pair], target.points.y[pair]);
      const Vec2 n_target(target.points.nx[pair], target.points.ny[pair]);
      const Vec2 n = Pose2{0, 0, -T.theta} * n_target;
      const Vec3 j(n.x(), n.y(), n.y() * p.x() - n.x() * p.y());
      h += j * j.transpose();
      g += j * n_target.dot(at - to);
    }
    T = T * exp(-h.llt().solve(g));
  }
  return T;
}

TEST(RangeBias, ShiftIsWhatMatchingWithWrongRangesGives) {
  const Room room;
  const Pose2 T_robot_laser{0.1, -0.02, 0.05}, a{2.2, 2.1, 0.4}, b{3.4, 2.9, 0.7};
  const double half = radians(80);
  constexpr int kTarget = 2400, kSource = 480;
  const KeyScan target = room.scan(a, half, kTarget, T_robot_laser),
                source = room.scan(b, half, kSource, T_robot_laser);
  const Pose2 truly = matched(target, source);
  EXPECT_LT(between(between(a, b), truly).vector().norm(), 1e-3);
  const auto columns = RangeBias::shift(target, laser_view(target), source, kGate);
  for (int c = 0; c < RangeBias::kCount; ++c) {
    const Law law = Law::Unit(c);
    const Pose2 wrong = matched(room.scan(a, half, kTarget, T_robot_laser, law),
                                room.scan(b, half, kSource, T_robot_laser, law));
    const Vec3 moved = between(truly, wrong).vector(), said = columns.col(c);
    EXPECT_LT((moved - said).norm(), 0.05 * moved.norm() + 2e-5) << "column " << c;
  }
}

TEST(RangeBias, ScansFromOnePlaceAreNotShifted) {
  const Room room;
  const Pose2 T{2.2, 2.1, 0.4};
  const KeyScan target = room.scan(T, radians(90), 361), source = room.scan(T, radians(90), 181);
  EXPECT_LT(RangeBias::shift(target, laser_view(target), source, kGate).norm(), 1e-8);
}

TEST(RangeBias, RangesTooLongByAShareMakeTheWayTooLongByIt) {
  // Everything about the laser is scaled, whatever the room and the way; but what guards weak
  // directions holds a little.
  const Room room;
  const Pose2 T_robot_laser{0.1, -0.02, 0.05};
  for (const double half : {radians(90), radians(170)})
    for (const Pose2& b : {Pose2{3.4, 2.9, 0.7}, Pose2{1.2, 2.1, 0.4}, Pose2{2.4, 3.0, -0.3}}) {
      const Pose2 a{2.2, 2.1, 0.4};
      const KeyScan target = room.scan(a, half, 361, T_robot_laser),
                    source = room.scan(b, half, 361, T_robot_laser);
      // Between the lasers, in the axes of the source robot.
      const Vec2 way = Pose2{0, 0, -b.theta} *
                       Vec2((b * T_robot_laser).translation() - (a * T_robot_laser).translation());
      const Vec3 s = shift(target, source, proportional(0.01));
      EXPECT_LT((s.head<2>() - 0.01 * way).norm(), 0.06 * 0.01 * way.norm()) << s.transpose();
      EXPECT_LT(std::abs(s.z()), 0.06 * 0.01 * way.norm());
    }
}

TEST(RangeBias, AConstantErrorTowardsAWallShiftsNothing) {
  // Both scans see the wall too far by the same.
  const Room room{{9, 1000}};
  const KeyScan target = room.scan({2, 500, 0}, radians(10), 181),
                source = room.scan({4, 500, 0}, radians(10), 181);
  const Vec3 s = shift(target, source, Law::Unit(0));
  EXPECT_LT(std::abs(s.x()), 0.01 * RangeBias::kConstant);
  EXPECT_LT(std::abs(s.y()) + std::abs(s.z()), 1e-6);  // along the wall there is nothing to see
  // An error of a share of the range is one of the way.
  EXPECT_NEAR(shift(target, source, proportional(0.01)).x(), 0.02, 4e-4);
}

TEST(RangeBias, WhatTheTargetCouldNotSeeDoesNotCount) {
  // The target looks the other way than the source.
  const Room room;
  const KeyScan target = room.scan({4, 3, kPi}, radians(60), 181),
                source = room.scan({4.5, 3, 0}, radians(60), 181);
  EXPECT_EQ(RangeBias::shift(target, laser_view(target), source, kGate).norm(), 0);
  KeyScan bare = room.scan({4.5, 3, kPi}, radians(60), 181);  // nor does what has no surface
  std::fill(bare.points.nx.begin(), bare.points.nx.end(), 0.0F);
  std::fill(bare.points.ny.begin(), bare.points.ny.end(), 0.0F);
  EXPECT_EQ(RangeBias::shift(target, laser_view(target), bare, kGate).norm(), 0);
}

TEST(RangeBias, HatsSumUpAndInterpolate) {
  for (const double range : {0.0, 0.3, 4.0, 5.5, 11.9, 15.99, 16.0, 17.0, 80.0}) {
    const Law w = RangeBias::at(range);
    EXPECT_EQ(w(0), RangeBias::kConstant) << range;
    EXPECT_NEAR(w.tail<RangeBias::kCount - 1>().sum(), RangeBias::kHat, 1e-15) << range;
    EXPECT_GE(w.minCoeff(), 0) << range;
    EXPECT_NEAR(proportional(1).dot(w), std::min(range, 16.0), 1e-9) << range;
  }
  EXPECT_NEAR(RangeBias::at(4)(2), RangeBias::kHat, 1e-15);
  EXPECT_NEAR(RangeBias::at(9)(3), 0.75 * RangeBias::kHat, 1e-15);
  EXPECT_NEAR(RangeBias::at(100)(RangeBias::kCount - 1), RangeBias::kHat, 1e-15);
}

TEST(LaserView, IsTheWidestBearingAndTheSpacingOfTheBeams) {
  const Room room;
  const Pose2 T_robot_laser{0.1, -0.2, 2.0};  // the view is the laser's, not the robot's
  for (const double degrees : {30.0, 90.0, 135.0}) {
    const LaserView view = laser_view(room.scan({3, 2, 0.3}, radians(degrees), 361, T_robot_laser));
    EXPECT_NEAR(view.reach, std::cos(radians(degrees)), 1e-5) << degrees;
    EXPECT_NEAR(view.step, std::sin(radians(degrees) / 180), 1e-5) << degrees;
  }
}

TEST(LaserView, OfHardlyAnythingIsUsable) {
  const LaserView none = laser_view(KeyScan{});
  EXPECT_EQ(none.reach, 1);
  EXPECT_GT(none.step, 0);
  KeyScan twice = Room{}.scan({3, 2, 0.3}, radians(90), 181);
  twice.points.x[7] = twice.points.x[6], twice.points.y[7] = twice.points.y[6];
  EXPECT_GT(laser_view(twice).step, 0);
}

}  // namespace
}  // namespace majak::slam
