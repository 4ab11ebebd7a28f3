// SPDX-License-Identifier: Apache-2.0
#include "majak/localize/plausibility.hpp"

#include <gtest/gtest.h>

#include "tests/support/ascii_map.hpp"
#include "tests/support/ascii_room.hpp"

namespace majak::localize {
namespace {

const std::vector<std::string> kHall = {
    "########################################", "#......................................#",
    "#......................................#", "#......................................#",
    "########################################"};

PlacePtr place() {
  static const PlacePtr place = place_of(fixture::ascii_map(fixture::finer(kHall, 5), 0.1));
  return place;
}

Scan seen(const Pose2& pose) {
  static const fixture::AsciiRoom room(kHall);
  return room.scan(pose, {181, kPi, 30, 0.01, 1, {}});
}

FedScan fed(const Pose2& pose, const Pose2& step) {
  FedScan scan;
  scan.scan = seen(pose);
  scan.T_previous_robot = step;
  return scan;
}

constexpr Pose2 kStep{0.25, 0, 0};

TEST(PoseFit, WhereItIsAllIsExplained) {
  const Pose2 pose{5, 1.2, 0.3};
  const PoseFit fit = pose_fit(*place(), match::beams(seen(pose)), pose);
  EXPECT_LT(fit.misfit(), 0.02);
  EXPECT_EQ(fit.through, 0);
}

TEST(PoseFit, APersonCostsHalfOfAWallThatIsNotThere) {
  const Pose2 pose{5, 1.25, 0};
  Scan person = seen(pose), hole = person;
  for (std::size_t k = 0; k < 60; ++k) person.ranges[k] *= 0.5F, hole.ranges[k] = 12;
  const auto misfit = [&](const Scan& scan) {
    return pose_fit(*place(), match::beams(scan), pose).misfit();
  };
  EXPECT_NEAR(misfit(person), 0.5 * 60 / 181, 0.01);
  EXPECT_NEAR(misfit(hole), 1.5 * 60 / 181, 0.01);
}

TEST(PoseFit, WithoutReturnsNothingIsSaid) {
  EXPECT_EQ(pose_fit(*place(), {}, {5, 1, 0}).misfit(), 0);
}

TEST(Plausibility, APlaceIsOnProbationUntilSoManyLooksFit) {
  PlausibilityOptions o;
  Plausibility watch(place(), o);
  Pose2 pose{2, 1.2, 0};
  for (int look = 1; look <= o.probation + 5; ++look, pose = pose * kStep) {
    watch.add(fed(pose, look > 1 ? kStep : Pose2{}), pose);
    EXPECT_EQ(watch.at_best(), look < o.probation ? Health::degraded : Health::ok) << look;
  }
}

TEST(Plausibility, ARobotThatStandsIsLookedAtOnce) {
  Plausibility watch(place(), {});
  const Pose2 pose{2, 1.2, 0};
  for (int k = 0; k < 100; ++k) watch.add(fed(pose, {}), pose);
  EXPECT_EQ(watch.at_best(), Health::degraded);
}

TEST(Plausibility, ALeapBeginsTheProbationAnew) {
  PlausibilityOptions o;
  Plausibility watch(place(), o);
  Pose2 pose{2, 1.2, 0};
  for (int look = 0; look < o.probation; ++look, pose = pose * kStep)
    watch.add(fed(pose, kStep), pose);
  EXPECT_EQ(watch.at_best(), Health::ok);
  pose = pose * Pose2{3, 0, 0};
  watch.add(fed(pose, kStep), pose);
  EXPECT_EQ(watch.at_best(), Health::degraded);
}

TEST(Plausibility, APlaceThatDoesNotFitIsGivenUp) {
  PlausibilityOptions o;
  Plausibility watch(place(), o);
  Pose2 pose{2, 1.2, 0};
  for (int look = 1; look <= o.least; ++look, pose = pose * kStep) {
    watch.add(fed({3, 1.2, 0.8}, look > 1 ? kStep : Pose2{}), pose);
    EXPECT_EQ(watch.at_best(), look < o.least ? Health::degraded : Health::lost);
  }
  Estimate e;
  watch.limit(e);
  EXPECT_EQ(e.health, Health::lost);
}

TEST(Plausibility, NothingIsBetterThanTheMethodSays) {
  PlausibilityOptions o;
  o.probation = 1;
  Plausibility watch(place(), o);
  watch.add(fed({2, 1.2, 0}, {}), {2, 1.2, 0});
  Estimate e;
  e.health = Health::lost;
  watch.limit(e);
  EXPECT_EQ(e.health, Health::lost);
}

}  // namespace
}  // namespace majak::localize
