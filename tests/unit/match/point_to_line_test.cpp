// SPDX-License-Identifier: Apache-2.0
#include "majak/match/point_to_line.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "majak/core/random.hpp"
#include "tests/support/ascii_room.hpp"

namespace majak::match {
namespace {

using fixture::all_around;
using fixture::AsciiRoom;
using fixture::Laser;

const AsciiRoom& room() {
  static const AsciiRoom r({
      "####################",
      "#........#.........#",
      "#........#.........#",
      "#..................#",
      "#.....a............#",
      "#..................#",
      "#...........o......#",
      "###.......#........#",
      "###.......##.......#",
      "####################",
  });
  return r;
}

ScanPoints look(const AsciiRoom& where, const Pose2& T_map_robot,
                const Laser& laser = all_around()) {
  return scan_points(where.scan(T_map_robot, laser), {}, true);
}

map::SurfelMap map_of(const ScanPoints& points, const Pose2& T_map_robot) {
  map::SurfelMap map;
  add_to(map, points, T_map_robot);
  return map;
}

/// A map from several places, as the front end has one.
map::SurfelMap walked_map(const Pose2& centre, const Laser& laser = all_around()) {
  map::SurfelMap map;
  for (const Pose2& step :
       {Pose2{0, 0, 0}, Pose2{0.4, 0, 0.3}, Pose2{0, 0.3, -0.2}, Pose2{-0.3, -0.2, 0.1}})
    add_to(map, look(room(), centre * step, laser), centre * step);
  return map;
}

double off(const Pose2& a, const Pose2& b) { return between(a, b).translation().norm(); }
double turned(const Pose2& a, const Pose2& b) { return std::abs(between(a, b).theta); }

Mat3 diagonal(double translation, double rotation) {
  return Vec3(translation, translation, rotation).asDiagonal();
}

/// Starts all around the truth: up to 0.2 m and 8 degrees off.
std::vector<Pose2> starts() {
  std::vector<Pose2> list;
  for (const double turn : {-8.0, -4.0, 0.0, 4.0, 8.0})
    for (const Vec2& t :
         {Vec2(0.2, 0), Vec2(-0.2, 0), Vec2(0, 0.2), Vec2(0, -0.2), Vec2(0.14, 0.14), Vec2(0, 0)})
      list.push_back({t.x(), t.y(), radians(turn)});
  return list;
}

TEST(Align, FindsTheTruthFromAllAround) {
  const Pose2 truth = room().pose('a', 0.3);
  const map::SurfelMap map = walked_map(truth * Pose2{0.1, 0.15, 0.05});
  const ScanPoints points = look(room(), truth);
  for (const Pose2& start : starts()) {
    const Match m = align(points, map, {truth * start, Mat3::Zero()}, {});
    EXPECT_TRUE(m.converged) << start.vector().transpose();
    EXPECT_LT(off(truth, m.T_map_robot), 0.002) << start.vector().transpose();
    EXPECT_LT(turned(truth, m.T_map_robot), radians(0.05)) << start.vector().transpose();
    EXPECT_GT(m.score, 0.95);
    EXPECT_LT(m.rms, 0.01);
    EXPECT_LE(m.iterations, AlignOptions{}.max_iterations);
  }
}

TEST(Align, FindsTheTruthThroughNoise) {
  const Pose2 truth = room().pose('a', -1.2);
  Laser laser = all_around();
  laser.noise = 0.01;
  const map::SurfelMap map = walked_map(truth * Pose2{0.1, -0.1, 0.05}, laser);
  double squares = 0, square_turns = 0;
  int n = 0;
  for (const Pose2& start : starts()) {
    laser.seed = 100 + n;
    const Match m = align(look(room(), truth, laser), map, {truth * start, Mat3::Zero()}, {});
    squares += std::pow(off(truth, m.T_map_robot), 2);
    square_turns += std::pow(turned(truth, m.T_map_robot), 2);
    ++n;
  }
  EXPECT_LT(std::sqrt(squares / n), 0.004);  // 360 returns of 10 mm
  EXPECT_LT(std::sqrt(square_turns / n), radians(0.1));
}

TEST(Align, ThereAndBackAgainIsTheIdentity) {
  const Pose2 a = room().pose('a', 0.3);
  const ScanPoints seen_a = look(room(), a);
  for (const Pose2& step : starts()) {
    const ScanPoints seen_b = look(room(), a * step);
    const Match forth = align(seen_b, map_of(seen_a, {}), {{}, Mat3::Zero()}, {});
    const Match back = align(seen_a, map_of(seen_b, {}), {{}, Mat3::Zero()}, {});
    const Pose2 circle = forth.T_map_robot * back.T_map_robot;
    EXPECT_LT(off(circle, {}), 0.005) << step.vector().transpose();
    EXPECT_LT(turned(circle, {}), radians(0.1)) << step.vector().transpose();
    EXPECT_LT(off(forth.T_map_robot, step), 0.005) << step.vector().transpose();
  }
}

TEST(Align, DoesNotDependOnWhereTheMapIs) {
  const Pose2 truth = room().pose('a', 0.3), start = truth * Pose2{0.1, -0.05, 0.05};
  const ScanPoints points = look(room(), truth);
  const Match here = align(points, map_of(points, truth), {start, Mat3::Zero()}, {});
  for (const Pose2& away : {Pose2{40, -70, 0}, Pose2{0, 0, 2}, Pose2{-300, 5, -3}}) {
    const Match there =
        align(points, map_of(points, away * truth), {away * start, Mat3::Zero()}, {});
    EXPECT_LT(off(away * here.T_map_robot, there.T_map_robot), 0.001);
    EXPECT_LT(turned(away * here.T_map_robot, there.T_map_robot), radians(0.02));
  }
}

TEST(Align, NothingToMatchLeavesThePrior) {
  const Pose2 start{1, 2, 3};
  const ScanPoints points = look(room(), room().pose('a')), none = scan_points(Scan{}, {}, true);
  const map::SurfelMap map = map_of(points, room().pose('a')), empty;
  // No scan; no map; no scan and no map; a scan far away from the map.
  for (const Match& m : {align(none, map, {start, diagonal(100, 100)}, {}),
                         align(points, empty, {start, diagonal(100, 100)}, {}),
                         align(none, empty, {start, Mat3::Zero()}, {}),
                         align(points, map, {{500, 0, 3}, Mat3::Zero()}, {})}) {
    EXPECT_FALSE(m.converged);
    EXPECT_EQ(m.score, 0);
    EXPECT_EQ(m.inliers, 0);
    EXPECT_EQ(m.information, Mat3::Zero());
    EXPECT_EQ(m.T_map_robot.theta, 3);
  }
}

// What a wall does not tell.

const AsciiRoom& single_wall() {
  static const AsciiRoom r({
      "########################################",
      "........................................",
      "....................a...................",
  });
  return r;
}

TEST(Align, ASingleWallSaysNothingAlongItself) {
  const Pose2 truth = single_wall().pose('a', 0.2);
  Laser laser = all_around();
  laser.max_range = 6;  // the ends of the wall are not seen
  const ScanPoints points = look(single_wall(), truth, laser);
  const Match m = align(points, map_of(points, truth), {truth, diagonal(100, 100)}, {});
  const Eigen::SelfAdjointEigenSolver<Mat3> axes(m.information);
  EXPECT_LT(axes.eigenvalues()(0), 1e-3 * axes.eigenvalues()(1));  // rank 2
  const Vec3 weak = axes.eigenvectors().col(0).normalized();
  EXPECT_NEAR(std::abs(weak.x()), 1, 1e-3);  // x of the map, whatever way the robot looks
  EXPECT_NEAR(m.information(0, 0), 0, 1e-3 * m.information(1, 1));
}

TEST(Align, ThePriorHoldsWhatTheWallDoesNotTell) {
  const Pose2 truth = single_wall().pose('a', 0.2);
  Laser laser = all_around();
  laser.max_range = 6;
  const ScanPoints points = look(single_wall(), truth, laser);
  const map::SurfelMap map = map_of(points, truth);
  const Pose2 start{truth.x + 0.15, truth.y + 0.1, truth.theta + radians(3)};
  const Match m = align(points, map, {start, diagonal(100, 100)}, {});
  EXPECT_NEAR(m.T_map_robot.x, start.x, 0.004);  // along: the prior
  EXPECT_NEAR(m.T_map_robot.y, truth.y, 0.002);  // across: the wall
  EXPECT_NEAR(m.T_map_robot.theta, truth.theta, radians(0.1));
}

TEST(Align, AStrongPriorWinsAWeakOneLoses) {
  const Pose2 truth = room().pose('a', 0.3), start = truth * Pose2{0.05, 0.05, 0.01};
  const ScanPoints points = look(room(), truth);
  const map::SurfelMap map = map_of(points, truth);
  EXPECT_LT(off(align(points, map, {start, diagonal(1e12, 1e12)}, {}).T_map_robot, start), 1e-5);
  EXPECT_LT(off(align(points, map, {start, diagonal(1e-3, 1e-3)}, {}).T_map_robot, truth), 1e-3);
}

TEST(Align, InformationDoesNotCountThePrior) {
  const Pose2 truth = room().pose('a', 0.3);
  const ScanPoints points = look(room(), truth);
  const map::SurfelMap map = map_of(points, truth);
  const Mat3 without = align(points, map, {truth, Mat3::Zero()}, {}).information;
  const Mat3 with = align(points, map, {truth, diagonal(1e4, 1e4)}, {}).information;
  EXPECT_LT((with - without).norm(), 1e-3 * without.norm());
  EXPECT_LT((without - without.transpose()).norm(), 1e-9 * without.norm());
}

TEST(Align, AHeadingAcrossTheSeamIsOneLikeAnother) {
  const Pose2 truth = room().pose('a', kPi);
  const ScanPoints points = look(room(), truth);
  const map::SurfelMap map = map_of(points, truth);
  for (const double turn : {-0.05, 0.05}) {
    const Match m = align(points, map, {truth * Pose2{0.05, 0, turn}, diagonal(100, 100)}, {});
    EXPECT_LT(turned(truth, m.T_map_robot), radians(0.05));
    EXPECT_LE(m.T_map_robot.theta, kPi);
    EXPECT_GT(m.T_map_robot.theta, -kPi);
  }
}

TEST(Align, AMovedThingIsOutvoted) {
  // A quarter of the scan shows a cupboard that the map does not know.
  const AsciiRoom furnished({
      "####################",
      "#........#.........#",
      "#........#.........#",
      "#....######........#",
      "#.....a............#",
      "#..................#",
      "#...........o......#",
      "###.......#........#",
      "###.......##.......#",
      "####################",
  });
  const Pose2 truth = room().pose('a', 0.3);
  const map::SurfelMap map = walked_map(truth);
  const Match m =
      align(look(furnished, truth), map, {truth * Pose2{0.08, -0.05, 0.03}, Mat3::Zero()}, {});
  EXPECT_LT(off(truth, m.T_map_robot), 0.005);
  EXPECT_LT(m.score, 0.9);
  EXPECT_GT(m.score, 0.4);
}

// The slow twin: double precision, the nearest surfel by looking at all of them, as the cost is
// written in docs/MATH.md: sum of Cauchy-weighted squared distances off the lines, plus the prior.
Pose2 slow_align(const ScanPoints& points, const map::SurfelMap& map, const PosePrior& prior,
                 const AlignOptions& o) {
  Pose2 at = prior.T_map_robot;
  for (int round = 0; round < 60; ++round) {
    const double gate = round < 10 ? o.gate : o.final_gate;
    Mat3 h = prior.information;
    Vec3 b = prior.information * Vec3(at.x - prior.T_map_robot.x, at.y - prior.T_map_robot.y,
                                      angle_diff(at.theta, prior.T_map_robot.theta));
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vec2 r = Pose2{0, 0, at.theta} * Vec2(points.x[i], points.y[i]),
                 p = at.translation() + r;
      const map::Surfel* near = nullptr;
      double best = gate;
      for (const map::Surfel& s : map.surfels())
        if (const double d = std::hypot(s.x - p.x(), s.y - p.y()); d < best) best = d, near = &s;
      if (near == nullptr || (near->nx == 0 && near->ny == 0)) continue;
      const Vec3 j(near->nx, near->ny, near->ny * r.x() - near->nx * r.y());
      const double e = near->nx * (p.x() - near->x) + near->ny * (p.y() - near->y);
      const double share = std::min(1.0, r.norm() / o.full_range);
      const double w = share * share / (o.sigma * o.sigma) / (1 + e * e / (o.cauchy * o.cauchy));
      h += w * j * j.transpose();
      b += w * e * j;
    }
    const Vec3 step = -h.ldlt().solve(b);
    at = {at.x + step.x(), at.y + step.y(), wrap_angle(at.theta + step.z())};
  }
  return at;
}

TEST(Align, EqualsItsSlowTwin) {
  // A hall with open corners: the nearest by the grid and the nearest always lie on one line.
  const AsciiRoom hall({
      "..#############..",
      "#...............#",
      "#...............#",
      "#.....a.........#",
      "#...............#",
      "#...............#",
      "#...............#",
      "..#############..",
  });
  AlignOptions options;
  options.tolerance = 1e-7;
  options.max_iterations = 60;
  for (const double turn : {0.0, 0.3, 2.0, -2.9}) {
    const Pose2 truth = hall.pose('a', turn), other = truth * Pose2{0.1, -0.07, 0.1};
    const map::SurfelMap map = map_of(look(hall, other), other);
    const ScanPoints points = look(hall, truth);
    const PosePrior prior{truth * Pose2{0.05, 0.06, 0.02}, diagonal(1e4, 4e5)};
    const Match fast = align(points, map, prior, options);
    const Pose2 slow = slow_align(points, map, prior, options);
    EXPECT_LT(off(fast.T_map_robot, slow), 1e-4) << turn;
    EXPECT_LT(turned(fast.T_map_robot, slow), 1e-4) << turn;
    EXPECT_GT(off(fast.T_map_robot, truth), 3e-4);  // the prior pulls, in both alike
    EXPECT_GT(turned(fast.T_map_robot, truth), 3e-4);
  }
}

/// Points of straight walls, each from a to b with its normal, half a metre between them at least.
struct Wall {
  Vec2 a, b, normal;
};
ScanPoints points_on(const std::vector<Wall>& walls) {
  ScanPoints points;
  for (const Wall& wall : walls)
    for (double t = 0; t <= 1; t += 0.02) {
      const Vec2 p = wall.a + t * (wall.b - wall.a);
      points.x.push_back(static_cast<float>(p.x())), points.y.push_back(static_cast<float>(p.y()));
      points.nx.push_back(static_cast<float>(wall.normal.x())),
          points.ny.push_back(static_cast<float>(wall.normal.y()));
      points.target.push_back(1);
    }
  return points;
}

TEST(Align, InformationIsTheSumOverTheReturns) {
  const double slant = std::sqrt(0.5);
  const ScanPoints points = points_on({{{-2, 3}, {2, 3}, {0, -1}},
                                       {{4, -2}, {4, 2}, {-1, 0}},
                                       {{-4, 0}, {-2, -2}, {slant, slant}}});
  // In the robot's place, each return off its line by its normal: J = (n, n x r).
  Mat3 expected = Mat3::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 j(points.nx[i], points.ny[i],
                 points.ny[i] * points.x[i] - points.nx[i] * points.y[i]);
    expected += j * j.transpose() / (0.03 * 0.03);
  }
  AlignOptions options;
  options.sigma = 0.03;
  const Match m = align(points, map_of(points, {}), {{}, Mat3::Zero()}, options);
  const Mat3 s = without_normal_noise(expected);
  expected = s * expected * s;
  EXPECT_LT((m.information - expected).norm(), 1e-3 * expected.norm())
      << m.information << "\n against\n"
      << expected;
  // The same in the axes of the map at the robot, wherever that is.
  const Pose2 away{20, -30, 1};
  const Match there = align(points, map_of(points, away), {away, Mat3::Zero()}, options);
  Mat3 r = Mat3::Identity();
  r.topLeftCorner<2, 2>() << std::cos(1), -std::sin(1), std::sin(1), std::cos(1);
  EXPECT_LT((there.information - r * expected * r.transpose()).norm(), 1e-2 * expected.norm());
}

TEST(Align, PolesAloneTellThePose) {
  ScanPoints poles;
  poles.x = {2, -1, 3, -3}, poles.y = {1, 2, -2, -1.5F};
  poles.nx.assign(4, 0), poles.ny.assign(4, 0), poles.target.assign(4, 1);
  const map::SurfelMap map = map_of(poles, {});
  const Match m = align(poles, map, {{0.1, -0.08, 0.03}, Mat3::Zero()}, {});
  EXPECT_TRUE(m.converged);
  EXPECT_EQ(m.inliers, 4);
  EXPECT_LT(off(m.T_map_robot, {}), 1e-3);
  EXPECT_LT(turned(m.T_map_robot, {}), 1e-3);
  EXPECT_GT(m.information.diagonal().minCoeff(), 100);  // no direction is weak
}

// What the noise of the normals feigns.

/// Information of random returns on walls; `strength`: how much less the weak direction is told.
Mat3 random_information(RandomStream& r, double strength) {
  Mat3 sum = Mat3::Zero();
  const double turn = r.uniform(-kPi, kPi);
  for (int i = 0; i < 20; ++i) {
    Vec2 n = Vec2(r.normal(), strength * r.normal());
    n = Pose2{0, 0, turn} * n;
    const Vec3 j(n.x(), n.y(), r.uniform(-5, 5));
    sum += r.uniform(0, 1000) * j * j.transpose();
  }
  return sum;
}

Mat3 rotation3(double theta) {
  Mat3 r = Mat3::Identity();
  r.topLeftCorner<2, 2>() << std::cos(theta), -std::sin(theta), std::sin(theta), std::cos(theta);
  return r;
}

TEST(WithoutNormalNoise, LeavesASmallerInformation) {
  RandomStream r(1);
  for (int i = 0; i < 500; ++i) {
    const Mat3 information = random_information(r, std::pow(10, r.uniform(-4, 0)));
    const Mat3 s = without_normal_noise(information), left = s * information * s;
    EXPECT_LT((s - s.transpose()).norm(), 1e-12);
    EXPECT_EQ(s(2, 2), 1);  // headings are not touched
    EXPECT_EQ(s.col(2).head<2>().norm(), 0);
    const Vec3 scales = Eigen::SelfAdjointEigenSolver<Mat3>(s).eigenvalues();
    EXPECT_GE(scales(0), -1e-12);
    EXPECT_NEAR(scales(1), 1, 1e-12);  // one direction at most is scaled
    EXPECT_NEAR(scales(2), 1, 1e-12);
    EXPECT_LT((left - left.transpose()).norm(), 1e-9 * left.norm());
    EXPECT_GE(Eigen::SelfAdjointEigenSolver<Mat3>(left).eigenvalues()(0), -1e-9 * left.norm());
    const double before = information(0, 0) + information(1, 1);
    EXPECT_LE(left(0, 0) + left(1, 1), (1 + 1e-12) * before);
  }
}

TEST(WithoutNormalNoise, TurnsWithTheAxes) {
  RandomStream r(2);
  for (int i = 0; i < 200; ++i) {
    const Mat3 information = random_information(r, std::pow(10, r.uniform(-3, -0.3)));
    const Mat3 turn = rotation3(r.uniform(-kPi, kPi));
    const Mat3 s = without_normal_noise(information);
    const Mat3 there = without_normal_noise(turn * information * turn.transpose());
    EXPECT_LT((there - turn * s * turn.transpose()).norm(), 1e-6);
    EXPECT_LT((without_normal_noise(1e-3 * information) - s).norm(), 1e-9);  // nor is it a matter
  }                                                                          // of how many returns
}

TEST(WithoutNormalNoise, KeepsNearlyAllWhereAllDirectionsAreTold) {
  for (const double weak : {1.0, 0.5, 0.2}) {
    const Mat3 information = Vec3(1000, 1000 * weak, 5000).asDiagonal();
    const Mat3 s = without_normal_noise(information);
    const Mat3 left = s * information * s;
    const double kept = std::min(left(0, 0) / information(0, 0), left(1, 1) / information(1, 1));
    EXPECT_GT(kept, 0.98) << weak;
    EXPECT_LT(kept, 1) << weak;
  }
}

TEST(WithoutNormalNoise, TakesAwayWhatNormalsADegreeOffWouldSay) {
  // Returns of two parallel walls whose normals are off by 1.5 degrees: they seem to tell the way
  // along. By 15 degrees they would be walls that are not parallel.
  const auto information = [](double degrees) {
    RandomStream r(3);
    Mat3 sum = Mat3::Zero();
    for (int i = 0; i < 200; ++i) {
      const double off = radians(degrees) * r.normal(), x = r.uniform(-6, 6);
      for (const double either : {-off, off}) {
        const Vec3 j(std::sin(either), std::cos(either), x);
        sum += j * j.transpose() / (0.02 * 0.02);
      }
    }
    return sum;
  };
  const Mat3 noise = information(1.5), s = without_normal_noise(noise);
  EXPECT_GT(noise(0, 0), 400);  // 5 cm, it pretends
  EXPECT_LT((s * noise * s).row(0).norm(), 1e-3 * noise(0, 0));
  EXPECT_GT((s * noise * s)(1, 1), 0.99 * noise(1, 1));
  const Mat3 slanted = information(15), t = without_normal_noise(slanted);
  EXPECT_GT((t * slanted * t)(0, 0), 0.9 * slanted(0, 0));
}

TEST(WithoutNormalNoise, NothingStaysNothing) {
  for (const Mat3& information : {Mat3(Mat3::Zero()), Mat3(Vec3(0, 100, 10).asDiagonal())}) {
    const Mat3 s = without_normal_noise(information);
    EXPECT_TRUE(s.allFinite());
    EXPECT_LT((s * information * s - information).norm(), 1e-12);
  }
}

// Returns that tell how far a pose is along a direction.

/// Squares of 10 cm: a niche (four of its squares stand across), and walls along.
const AsciiRoom& niche() {
  static const AsciiRoom r(
      {
          "........................................",
          "..............########..................",
          "..............#......#..................",
          "..............#......#..................",
          "..............#......#..................",
          "###############......###################",
          "........................................",
          "........................................",
          "..................a.....................",
          "........................................",
          "........................................",
          "########################################",
      },
      0.1);
  return r;
}

Laser near_sighted() {
  Laser laser = all_around();
  laser.max_range = 1.5;  // the ends are not seen
  return laser;
}

TEST(CountAcross, CountsTheReturnsOnSurfacesAcross) {
  const double slant = std::sqrt(0.5), steep = std::sqrt(0.75);
  const ScanPoints points = points_on({{{-2, 3}, {2, 3}, {0, -1}},
                                       {{4, -2}, {4, 2}, {-1, 0}},
                                       {{-4, 0}, {-2, -2}, {slant, slant}},
                                       {{-3.5, 3.5}, {-2.7, 4.9}, {steep, -0.5}}});
  const int wall = static_cast<int>(points.size()) / 4;
  for (const Pose2& T : {Pose2{}, Pose2{20, -30, 1}, Pose2{-7, 3, -2.5}}) {
    const map::SurfelMap map = map_of(points, T);
    const auto count = [&](double x, double y) {
      const Pose2 turn{0, 0, T.theta};
      return count_across(points, map, T, turn * Vec2(x, y), 0.1);
    };
    EXPECT_EQ(count(1, 0), 3 * wall);  // the second, the slanted and the steep one
    EXPECT_EQ(count(-1, 0), 3 * wall);
    EXPECT_EQ(count(0, 1), 2 * wall);  // the first and the slanted one
    EXPECT_EQ(count(slant, slant), 3 * wall);
    EXPECT_EQ(count(slant, -slant), 3 * wall);
  }
}

TEST(CountAcross, SlidAlongTheCorridorFewerMeet) {
  const Pose2 truth = niche().pose('a');
  const ScanPoints points = look(niche(), truth, near_sighted());
  const map::SurfelMap map = map_of(points, truth);
  const int here = count_across(points, map, truth, {1, 0}, 0.05);
  for (const double slid : {-0.3, -0.2, -0.1, 0.1, 0.2, 0.3})
    EXPECT_LT(count_across(points, map, {truth.x + slid, truth.y, 0}, {1, 0}, 0.05), 0.3 * here)
        << slid;
  // The walls along it are met wherever it is.
  const int along = count_across(points, map, truth, {0, 1}, 0.05);
  EXPECT_GT(count_across(points, map, {truth.x + 0.3, truth.y, 0}, {0, 1}, 0.05), 0.7 * along);
}

TEST(CountAcross, TheWrongSideOfAThinWallDoesNotCount) {
  const AsciiRoom rooms(
      {
          "##############################",
          "#..............#.............#",
          "#..............#.............#",
          "#..............#.............#",
          "#.......a......#......b......#",
          "#..............#.............#",
          "#..............#.............#",
          "#..............#.............#",
          "##############################",
      },
      0.1);
  const Pose2 left = rooms.pose('a'), right = rooms.pose('b');
  const ScanPoints seen_left = look(rooms, left), seen_right = look(rooms, right);
  const map::SurfelMap map_left = map_of(seen_left, left);
  const double gate = 0.15;  // through the wall
  EXPECT_GT(count_across(seen_left, map_left, left, {1, 0}, gate), 40);
  // The partition's returns lie within the gate, but the map has its other side.
  ASSERT_GT(count_across(seen_right, map_of(seen_right, right), right, {1, 0}, gate), 40);
  EXPECT_EQ(count_across(seen_right, map_left, right, {1, 0}, gate), 0);
}

TEST(CountAcross, PolesAndAnEmptyMapCountForNothing) {
  ScanPoints poles;
  poles.x = {2, -1, 3, -3}, poles.y = {1, 2, -2, -1.5F};
  poles.nx.assign(4, 0), poles.ny.assign(4, 0), poles.target.assign(4, 1);
  EXPECT_EQ(count_across(poles, map_of(poles, {}), {}, {1, 0}, 0.1), 0);
  const ScanPoints points = look(niche(), niche().pose('a'));
  EXPECT_EQ(count_across(points, map::SurfelMap{}, niche().pose('a'), {1, 0}, 0.1), 0);
  EXPECT_EQ(count_across(ScanPoints{}, map_of(points, niche().pose('a')), {}, {1, 0}, 0.1), 0);
}

}  // namespace
}  // namespace majak::match
