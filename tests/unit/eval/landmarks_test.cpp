// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/landmarks.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "majak/core/random.hpp"

namespace majak::eval {
namespace {

std::vector<PlacedLandmark> lone(std::initializer_list<Vec2> places) {
  std::vector<PlacedLandmark> landmarks;
  for (const Vec2& p : places) landmarks.push_back({p, {}});
  return landmarks;
}

/// Some trees, 4 m and more apart.
std::vector<PlacedLandmark> orchard() {
  std::vector<PlacedLandmark> trees;
  RandomStream random(3);
  for (int i = 0; i < 8; ++i)
    for (int k = 0; k < 6; ++k) {
      const double x = 6 * i + random.uniform(-1, 1);
      trees.push_back({{x, 6 * k + random.uniform(-1, 1)}, {}});
    }
  return trees;
}

std::vector<PlacedLandmark> moved(std::vector<PlacedLandmark> landmarks, const Pose2& T) {
  for (PlacedLandmark& l : landmarks) l.p = T * l.p;
  return landmarks;
}

TEST(MatchLandmarks, TellsWhatIsMissedAndWhatIsMistaken) {
  const auto mapped = lone({{0.1, 0}, {5, 5.2}, {20, 20}});
  const auto truth = lone({{5, 5}, {40, 0}, {0, 0}});
  const LandmarkMatch m = match_landmarks(mapped, truth);
  ASSERT_EQ(m.pairs.size(), 2U);
  EXPECT_EQ(m.pairs[0].mapped, 0U);
  EXPECT_EQ(m.pairs[0].truth, 2U);
  EXPECT_EQ(m.pairs[1].truth, 0U);
  EXPECT_EQ(m.missed, std::vector<std::size_t>{1});
  EXPECT_EQ(m.mistaken, std::vector<std::size_t>{2});
  EXPECT_NEAR(m.error.mean, 0.15, 1e-12);
  EXPECT_NEAR(m.error.rms, std::sqrt(0.025), 1e-12);
  EXPECT_FALSE(m.pairs[0].nees);
  EXPECT_EQ(m.nees.count, 0U);
}

TEST(MatchLandmarks, PairsAreEachOthersNearest) {
  // Two on the map stand for one tree: the nearer is it, the other is mistaken.
  const LandmarkMatch twice = match_landmarks(lone({{0.3, 0}, {0.1, 0}}), lone({{0, 0}}));
  ASSERT_EQ(twice.pairs.size(), 1U);
  EXPECT_EQ(twice.pairs[0].mapped, 1U);
  EXPECT_EQ(twice.mistaken, std::vector<std::size_t>{0});
  EXPECT_TRUE(match_landmarks(lone({{0, 0}}), lone({{1.01, 0}})).pairs.empty());
  EXPECT_EQ(match_landmarks(lone({{0, 0}}), lone({{1.01, 0}}), {.reach = 1.02}).pairs.size(), 1U);
  EXPECT_TRUE(match_landmarks({}, lone({{0, 0}})).pairs.empty());
  EXPECT_EQ(match_landmarks(lone({{0, 0}}), {}).mistaken.size(), 1U);
}

TEST(MatchLandmarks, TheOtherWayRoundPairsAreTheSame) {
  RandomStream random(5);
  const auto truth = orchard();
  auto mapped = truth;
  for (PlacedLandmark& l : mapped) l.p += Vec2(random.normal(), random.normal());
  mapped.erase(mapped.begin(), mapped.begin() + 5);
  const LandmarkMatch there = match_landmarks(mapped, truth), back = match_landmarks(truth, mapped);
  EXPECT_EQ(there.pairs.size(), back.pairs.size());
  EXPECT_EQ(there.missed, back.mistaken);
  EXPECT_EQ(there.mistaken, back.missed);
  EXPECT_NEAR(there.error.mean, back.error.mean, 1e-12);
}

TEST(MatchLandmarks, AlignsRigidly) {
  const auto truth = orchard();
  const Pose2 T_map_truth{0.4, -0.3, 0.02};
  const auto mapped = moved(truth, T_map_truth);
  EXPECT_GT(match_landmarks(mapped, truth, {.reach = 2}).error.mean, 0.3);
  const LandmarkMatch m = match_landmarks(mapped, truth, {.reach = 2, .align = true});
  EXPECT_EQ(m.pairs.size(), truth.size());
  EXPECT_LT(m.error.max, 1e-12);
  const Pose2 left = m.T_truth_map * T_map_truth;
  EXPECT_NEAR(left.x, 0, 1e-12);
  EXPECT_NEAR(left.theta, 0, 1e-13);
  // One pair tells no turn.
  const LandmarkMatch single = match_landmarks(lone({{1, 0}}), lone({{1, 0.5}}), {.align = true});
  EXPECT_EQ(single.T_truth_map.theta, 0);
  EXPECT_NEAR(single.error.mean, 0.5, 1e-12);
}

TEST(MatchLandmarks, HonestCovariancesGiveTwo) {
  Eigen::Matrix2d covariance;
  covariance << 0.04, 0.015, 0.015, 0.01;
  const Eigen::Matrix2d root = covariance.llt().matrixL();
  std::vector<double> straight, halves;
  for (std::uint64_t run = 0; run < 40; ++run) {
    RandomStream random(7, run);
    const auto truth = orchard();
    auto mapped = truth, shared = truth;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const double x = random.normal();
      mapped[i].p += root * Vec2(x, random.normal());
      mapped[i].covariance = covariance;
      shared[i].covariance = 0.5 * covariance;
    }
    straight.push_back(match_landmarks(mapped, truth).nees.mean);
    for (PlacedLandmark& l : mapped) l.covariance = 0.5 * covariance;
    // Half of it the map's, half the truth's: the same.
    halves.push_back(match_landmarks(mapped, shared).nees.mean);
  }
  EXPECT_NEAR(error_stats(straight).mean, 2, 0.1);
  EXPECT_NEAR(error_stats(straight).mean, error_stats(halves).mean, 1e-9);
}

TEST(MatchLandmarks, AlignedCovariancesTurnWithTheMap) {
  const auto truth = orchard();
  auto mapped = truth;
  RandomStream random(2);
  for (PlacedLandmark& l : mapped) {
    l.p += Vec2(0.2 * random.normal(), 0);
    l.covariance = Vec2(0.04, 1e-4).asDiagonal();
  }
  const double before = match_landmarks(mapped, truth, {.align = true}).nees.mean;
  const Pose2 T{3, 1, 0.9};
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(T.theta).toRotationMatrix();
  auto turned = moved(mapped, T);
  for (PlacedLandmark& l : turned) l.covariance = (turn * *l.covariance * turn.transpose()).eval();
  // The frames are far apart: whoever knows them brings the one near the other first.
  const auto near = moved(turned, T.inverse());
  const LandmarkMatch again = match_landmarks(turned, moved(truth, T), {.align = true});
  EXPECT_NEAR(again.nees.mean, before, 1e-9);
  EXPECT_NEAR(match_landmarks(near, truth, {.align = true}).error.mean, again.error.mean, 1e-12);
}

TEST(SightingError, IsTakenApart) {
  const Pose2 truth{10, -4, 0.7}, T_robot_laser{3, 0.5, 0.1};
  const Vec2 p(30, 20);
  const double range = (p - (truth * T_robot_laser).translation()).norm();
  const Vec2 q = truth.inverse() * p;
  // All is right, and the place does not matter.
  const SightingError none = sighting_error(q, {12, 3, 0.7}, truth, p, T_robot_laser);
  EXPECT_NEAR(none.error.norm(), 0, 1e-12);
  EXPECT_NEAR(none.range, range, 1e-12);
  // The heading alone: range times its error across, about the laser and not about the robot's
  // point as far as the laser is off.
  const SightingError swung =
      sighting_error(q, {truth.x, truth.y, truth.theta + 1e-4}, truth, p, T_robot_laser);
  EXPECT_NEAR(swung.error.y(), 1e-4 * q.norm(), 2e-5);
  EXPECT_EQ(swung.by_laser(), 0);
  EXPECT_LT(std::abs(swung.error.x()), 2e-4);
  // The laser alone: it sees the thing farther off and to the left.
  const Vec2 along = (q - T_robot_laser.translation()).normalized(), left(-along.y(), along.x());
  const SightingError seen =
      sighting_error(q + 0.2 * along + 0.1 * left, truth, truth, p, T_robot_laser);
  EXPECT_NEAR(seen.error.x(), 0.2, 1e-12);
  EXPECT_NEAR(seen.by_laser(), 0.1, 1e-12);
  EXPECT_NEAR(seen.by_heading, 0, 1e-12);
}

TEST(ErrorsOverRange, AreRootsOfMeanSquaresInBins) {
  const std::vector<SightingError> sightings{{1, {3, 1}, 4},    {4.9, {-4, 7}, 3},
                                             {5.1, {1, 1}, 1},  {12, {2, -2}, 0},
                                             {13, {2, -2}, -4}, {11, {2, -2}, -2}};
  const auto bins = errors_over_range(sightings, 5, 2);
  ASSERT_EQ(bins.size(), 2U);  // a lone one says nothing
  EXPECT_EQ(bins[0].range, 2.5);
  EXPECT_EQ(bins[0].count, 2U);
  EXPECT_NEAR(bins[0].along, std::sqrt(12.5), 1e-12);
  EXPECT_NEAR(bins[0].across, 5, 1e-12);
  EXPECT_NEAR(bins[0].by_heading, std::sqrt(12.5), 1e-12);
  EXPECT_NEAR(bins[0].by_laser, std::sqrt(12.5), 1e-12);
  EXPECT_EQ(bins[1].range, 12.5);
  EXPECT_NEAR(bins[1].by_laser, std::sqrt(8.0 / 3), 1e-12);
}

/// A landmark at p, seen once a second for so many seconds from a robot that drives by.
std::vector<LandmarkSeen> drive_by(const Vec2& p, int seconds, int landmark) {
  std::vector<LandmarkSeen> seen;
  for (int t = 0; t < seconds; ++t) {
    const Pose2 at{0.5 * t, 0, 0.01 * t};
    seen.push_back({1000 * kSecond + t * kSecond, at, at.inverse() * p, landmark});
  }
  return seen;
}

TEST(SplitHalf, IsNoneWherePathAndSightingsAgree) {
  const auto seen = drive_by({4, 7}, 300, 5);
  const SplitHalf half = split_half(seen);
  ASSERT_EQ(half.landmarks.size(), 1U);
  EXPECT_EQ(half.landmarks[0].landmark, 5);
  EXPECT_LT(half.error.max, 1e-12);
  EXPECT_LT((half.landmarks[0].even - Vec2(4, 7)).norm(), 1e-12);
}

TEST(SplitHalf, SeesThatThePathMovesFromBlockToBlock) {
  auto seen = drive_by({4, 7}, 300, 0);
  for (LandmarkSeen& s : seen)
    if (int(to_seconds(s.time) - 1000) / 60 % 2 == 1) s.T_map_robot.y += 0.25;
  EXPECT_NEAR(split_half(seen).error.mean, 0.25, 1e-12);
  // Moved as a whole it is as good as before.
  for (LandmarkSeen& s : seen) s.T_map_robot = Pose2{5, 5, 2} * s.T_map_robot;
  EXPECT_NEAR(split_half(seen).error.mean, 0.25, 1e-12);
  // Nor does the order matter.
  std::reverse(seen.begin(), seen.end());
  EXPECT_NEAR(split_half(seen).error.mean, 0.25, 1e-12);
  // A drift that both halves have: half a block's worth and more is not to be seen.
  EXPECT_LT(split_half(seen, {.block = 2}).error.mean, 0.01);
}

TEST(SplitHalf, OnlyOfWhatBothHalvesSawOftenEnough) {
  auto seen = drive_by({4, 7}, 68, 1);  // 60 and 8 times
  const auto rarely = drive_by({9, 7}, 67, 2);
  seen.insert(seen.end(), rarely.begin(), rarely.end());
  const SplitHalf half = split_half(seen);
  ASSERT_EQ(half.landmarks.size(), 1U);
  EXPECT_EQ(half.landmarks[0].landmark, 1);
  EXPECT_EQ(split_half(seen, {.least = 7}).landmarks.size(), 2U);
  EXPECT_TRUE(split_half({}).landmarks.empty());
}

}  // namespace
}  // namespace majak::eval
