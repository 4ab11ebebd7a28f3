// SPDX-License-Identifier: Apache-2.0
#include "majak/localize/find_and_track.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/ascii_room.hpp"
#include "tests/unit/localize/known_drive.hpp"

namespace majak::localize {
namespace {

TEST(GlobalLocalization, TellsThePlaceOfMostScans) {
  const GlobalLocalization global(drive().place);
  int first = 0, asked = 0;
  for (std::size_t k = 0; k < drive().scans.size(); k += 40, ++asked) {
    const GlobalAnswer answer = global.find(drive().scans[k].scan);
    double sum = answer.elsewhere;
    for (std::size_t i = 0; i < answer.places.size(); ++i) {
      sum += answer.places[i].probability;
      if (i > 0) {
        EXPECT_GE(answer.places[i - 1].probability, answer.places[i].probability);
      }
    }
    EXPECT_NEAR(sum, 1, 1e-9);
    first += !answer.places.empty() && right(answer.places[0].T_map_robot, drive().truth[k]);
  }
  EXPECT_GE(first, asked * 8 / 10);
}

TEST(PoseFit, AWallThatBeamsPassedCountsAgainstAPose) {
  const match::Beams beams = match::beams(drive().scans[100].scan);
  const PoseFit here = pose_fit(*drive().place, beams, drive().truth[100]);
  const PoseFit turned = pose_fit(*drive().place, beams, drive().truth[100] * Pose2{0, 0, 1.5});
  EXPECT_LT(here.through, 0.04);
  EXPECT_GT(turned.through, 0.1);
  EXPECT_LT(here.cost, turned.cost);
}

TEST(FindAndTrack, FindsTheRobotAndKeepsIt) {
  FindAndTrack method(drive().place, {}, {}, {});
  std::size_t found = 0;
  for (std::size_t k = 0; k < drive().scans.size(); ++k) {
    const Estimate e = method.add(drive().scans[k]);
    if (e.health == Health::lost) continue;
    if (found == 0) found = k + 1;
    EXPECT_TRUE(right(e.T_map_robot, drive().truth[k])) << k;
  }
  EXPECT_GT(found, 0U);
  EXPECT_LT(found, 80U);
  EXPECT_TRUE(method.tracking());
}

TEST(FindAndTrack, SaysThatItWasCarriedAwayAndComesBack) {
  FindAndTrack method(drive().place, {}, {}, {});
  const std::size_t far = drive().scans.size() * 3 / 4;
  ASSERT_GT((drive().truth[150].translation() - drive().truth[far].translation()).norm(), 5);
  for (std::size_t k = 0; k < 150; ++k) method.add(drive().scans[k]);
  ASSERT_TRUE(method.tracking());
  bool lost = false;
  Estimate e;
  for (std::size_t k = far; k < far + 80 && k < drive().scans.size(); ++k) {
    e = method.add(k == far ? without_motion(drive().scans[k]) : drive().scans[k]);
    lost = lost || e.health == Health::lost;
    if (k == far + 79) {
      EXPECT_TRUE(right(e.T_map_robot, drive().truth[k]));
    }
  }
  EXPECT_TRUE(lost);
  EXPECT_NE(e.health, Health::lost);
}

TEST(FindAndTrack, WhereNothingFitsItStaysLost) {
  const fixture::AsciiRoom other(
      {"######################", "#....................#", "#..####..####..####..#",
       "#....................#", "######################"},
      0.9);
  FindAndTrack method(drive().place, {}, {}, {});
  int ok = 0;
  for (int k = 0; k < 60; ++k) {
    FedScan scan;
    scan.scan = other.scan({1.5 + 0.25 * k, 1.35, 0}, {181, kPi, 30, 0.01, k + 1, {}});
    scan.scan.time = k * kSecond;
    if (k > 0) scan.T_previous_robot = {0.25, 0, 0};
    scan.covariance = Vec3(1e-4, 1e-4, 1e-4).asDiagonal();
    ok += method.add(scan).health == Health::ok;
  }
  EXPECT_EQ(ok, 0);
}

TEST(FindAndTrack, AScanWithoutAnyBeamIsNoPlace) {
  FindAndTrack method(drive().place, {}, {}, {});
  FedScan blind;
  blind.scan.ranges.assign(181, kInvalidRange);
  const Estimate e = method.add(blind);
  EXPECT_EQ(e.health, Health::lost);
  EXPECT_TRUE(method.hypotheses().empty());
}

}  // namespace
}  // namespace majak::localize
