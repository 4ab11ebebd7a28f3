// SPDX-License-Identifier: Apache-2.0
#include "majak/beacon/reflectors.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "majak/core/random.hpp"

namespace majak::beacon {
namespace {

const BeaconMap kHall = {
    {{1, {4, 3}, ""}, {2, {6, -2}, ""}, {3, {-1, 5}, ""}, {4, {9, 4.5}, ""}, {5, {2.5, -6}, ""}}};

/// A scan in a round room of 12 m with reflectors of 10 cm: half a degree between beams.
Scan scan_of(const BeaconMap& map, const Pose2& T_map_sensor, double diameter = 0.1) {
  Scan scan;
  scan.time = 7;
  scan.start_angle = -kPi;
  scan.angle_step = radians(0.5);
  scan.max_range = 80;
  for (std::size_t i = 0; i < 720; ++i) {
    double range = 12, brightness = 2e4 / (range * range);
    for (const Beacon& b : map.beacons) {
      const Vec2 way = T_map_sensor.inverse() * b.p_map;
      const double off = angle_diff(scan.angle(i), std::atan2(way.y(), way.x()));
      const double aside = way.norm() * std::sin(off), radius = diameter / 2;
      if (std::abs(off) > 0.5 || std::abs(aside) > radius) continue;
      range = way.norm() * std::cos(off) - std::sqrt(radius * radius - aside * aside);
      brightness = 1e6 / (range * range);
    }
    scan.ranges.push_back(static_cast<float>(range));
    scan.intensities.push_back(static_cast<float>(brightness));
  }
  return scan;
}

/// The sighting of each beacon, exactly, without its number.
std::vector<BeaconSighting> seen(const BeaconMap& map, const Pose2& T_map_robot,
                                 const Pose2& T_robot_sensor = {}) {
  std::vector<BeaconSighting> out;
  for (const Beacon& b : map.beacons) {
    const Vec2 way = (T_map_robot * T_robot_sensor).inverse() * b.p_map;
    BeaconSighting s;
    s.range = way.norm();
    s.bearing = std::atan2(way.y(), way.x());
    s.range_sigma = 0.02;
    s.bearing_sigma = 0.003;
    s.T_robot_sensor = T_robot_sensor;
    out.push_back(s);
  }
  return out;
}

std::vector<int> numbers(const std::vector<BeaconSighting>& sightings) {
  std::vector<int> out;
  for (const BeaconSighting& s : sightings) out.push_back(s.beacon);
  return out;
}

// ---- finding ----------------------------------------------------------------------------------

TEST(Reflectors, AreFoundWithRangeAndBearingOfTheirCentres) {
  const Pose2 pose{0.3, -0.4, 0.7};
  const auto truth = seen(kHall, pose);
  const auto found = find_reflectors(scan_of(kHall, pose));
  ASSERT_EQ(found.size(), 5U);
  for (const BeaconSighting& s : found) {
    EXPECT_EQ(s.time, 7);
    EXPECT_EQ(s.beacon, -1);
    double best = 10;
    for (const BeaconSighting& t : truth) {
      if (std::abs(angle_diff(*s.bearing, *t.bearing)) > 0.05) continue;
      EXPECT_LT(std::abs(angle_diff(*s.bearing, *t.bearing)), radians(0.3));
      best = std::abs(*s.range - *t.range);
    }
    EXPECT_LT(best, 0.012);  // seen: 9 mm, where one beam meets it aside
  }
}

TEST(Reflectors, TheirDiameterIsAnOption) {
  const BeaconMap post = {{{1, {5, 0.02}, ""}}};
  const auto round = find_reflectors(scan_of(post, {}, 0.4), {.diameter = 0.4});
  ASSERT_EQ(round.size(), 1U);
  EXPECT_NEAR(*round[0].range, 5, 1e-3);
  const auto flat = find_reflectors(scan_of(post, {}, 0.1), {.diameter = 0, .largest_gap = 0.1});
  ASSERT_EQ(flat.size(), 1U);
  EXPECT_NEAR(*flat[0].range, 4.96, 0.02);  // its front
}

TEST(Reflectors, ABrightThingThatIsTooWideIsNone) {
  EXPECT_TRUE(find_reflectors(scan_of({{{1, {5, 0}, ""}}}, {}, 0.5)).empty());
}

TEST(Reflectors, TwoThatStandCloseAreTwo) {
  EXPECT_EQ(find_reflectors(scan_of({{{1, {5, 0}, ""}, {2, {5, 0.35}, ""}}}, {})).size(), 2U);
}

TEST(Reflectors, ThresholdMayBeGiven) {
  const auto scan = scan_of(kHall, {});
  EXPECT_EQ(find_reflectors(scan, {.threshold = 2000}).size(), 5U);
  EXPECT_EQ(find_reflectors(scan, {.threshold = 30000}).size(), 2U);  // the nearer ones
  EXPECT_TRUE(find_reflectors(scan, {.threshold = 1e9}).empty());
}

TEST(Reflectors, NoneWithoutContrastOrIntensities) {
  EXPECT_TRUE(find_reflectors(scan_of({}, {})).empty());
  Scan scan = scan_of(kHall, {});
  scan.intensities.clear();
  EXPECT_TRUE(find_reflectors(scan).empty());
  EXPECT_TRUE(find_reflectors(Scan{}).empty());
  scan = scan_of(kHall, {});
  for (float& r : scan.ranges) r = kNoReturn;
  EXPECT_TRUE(find_reflectors(scan).empty());
  scan = scan_of(kHall, {});
  for (float& i : scan.intensities) i = std::nanf("");
  EXPECT_TRUE(find_reflectors(scan).empty());
}

TEST(Reflectors, FlagsOfTheDeviceWillDo) {
  // The LMS may say 0 for what is no reflector, and 1 ... 7 for one.
  Scan scan = scan_of(kHall, {});
  for (float& i : scan.intensities) i = i > 2000 ? 3 : 0;
  EXPECT_EQ(find_reflectors(scan).size(), 5U);
}

// ---- association ------------------------------------------------------------------------------

TEST(Association, WithAPriorTheNearestWithinTheGate) {
  const Pose2 pose{0.3, -0.4, 0.7};
  PosePrior prior{{0.4, -0.5, 0.72}, Mat3::Zero()};
  prior.covariance.diagonal() << 0.01, 0.01, 0.0004;
  EXPECT_EQ(numbers(associate(seen(kHall, pose, {0.2, 0.1, 0.3}), kHall, prior)),
            (std::vector<int>{1, 2, 3, 4, 5}));
  // A prior that is sure of something else takes none.
  prior.covariance *= 1e-4;
  prior.T_map_robot.x += 0.5;
  EXPECT_TRUE(associate(seen(kHall, pose), kHall, prior).empty());
}

TEST(Association, IsOneToOne) {
  // Two sightings near one beacon: the nearer gets it, the other nothing.
  const BeaconMap one = {{{8, {4, 0}, ""}}};
  auto found = seen({{{0, {4.1, 0}, ""}, {0, {4.02, 0}, ""}}}, {});
  PosePrior prior;
  prior.covariance = 0.1 * Mat3::Identity();
  const auto result = associate(found, one, prior);
  ASSERT_EQ(result.size(), 1U);
  EXPECT_NEAR(*result[0].range, 4.02, 1e-12);
  EXPECT_EQ(result[0].beacon, 8);
}

TEST(Association, GateIsTheMahalanobisDistance) {
  // Off by d along the ray: d^2 / (prior 0.04 + range 0.0004) against 13.8.
  PosePrior prior;
  prior.covariance.diagonal() << 0.04, 0.04, 1e-6;
  const BeaconMap one = {{{8, {4, 0}, ""}}};
  const double edge = std::sqrt(13.8 * 0.0404);
  EXPECT_EQ(associate(seen({{{0, {4 + 0.99 * edge, 0}, ""}}}, {}), one, prior).size(), 1U);
  EXPECT_EQ(associate(seen({{{0, {4 + 1.01 * edge, 0}, ""}}}, {}), one, prior).size(), 0U);
  // Across: bearing = y / 4 with the heading's and the bearing's own variance.
  const double turn = std::sqrt(13.8 * (0.04 / 16 + 1e-6 + 9e-6));
  const auto aside = [](double a) {
    return seen({{{0, {4 * std::cos(a), 4 * std::sin(a)}, ""}}}, {});
  };
  EXPECT_EQ(associate(aside(0.99 * turn), one, prior).size(), 1U);
  EXPECT_EQ(associate(aside(1.01 * turn), one, prior).size(), 0U);
}

TEST(Association, WithoutAPriorByDistances) {
  RandomStream random(1);
  int doubts = 0;
  for (int run = 0; run < 100; ++run) {
    const Pose2 pose{random.uniform(-9, 9), random.uniform(-9, 9), random.uniform(-kPi, kPi)};
    auto found = seen(kHall, pose, {0.2, 0, 0.1});
    for (BeaconSighting& s : found) {
      *s.range += 0.02 * random.normal();
      *s.bearing += 0.003 * random.normal();
    }
    std::swap(found[0], found[3]);
    EXPECT_EQ(numbers(associate(found, kHall, {})), (std::vector<int>{4, 2, 3, 1, 5}));
    // Something else that shines, and two beacons that are hidden.
    found.erase(found.begin() + 1);
    found.back().range = 7.7;
    found.back().bearing = *found.back().bearing + 1;
    const auto result = numbers(associate(found, kHall, {}));
    doubts += result.empty();
    if (!result.empty()) {
      EXPECT_EQ(result, (std::vector<int>{4, 3, 1}));
    }
  }
  EXPECT_LT(doubts, 10);  // what shines may by chance stand where another triple agrees
}

TEST(Association, WithoutAPriorDoubtGivesNothing) {
  // Two alone are not enough, and a square looks the same from four sides.
  const BeaconMap square = {{{1, {0, 0}, ""}, {2, {4, 0}, ""}, {3, {4, 4}, ""}, {4, {0, 4}, ""}}};
  auto found = seen(square, {1, 1, 0.5});
  EXPECT_TRUE(associate(found, square, {}).empty());
  auto two = seen(kHall, {});
  two.resize(2);
  EXPECT_TRUE(associate(two, kHall, {}).empty());
  EXPECT_TRUE(associate({}, kHall, {}).empty());
  EXPECT_TRUE(associate(found, {}, {}).empty());
  // With a prior the square is no riddle.
  PosePrior prior{{1.1, 0.9, 0.5}, 0.01 * Mat3::Identity()};
  EXPECT_EQ(numbers(associate(found, square, prior)), (std::vector<int>{1, 2, 3, 4}));
}

TEST(Association, LeavesOutWhatHasNoRangeOrNoBearing) {
  auto found = seen(kHall, {});
  found[1].range.reset();
  found[2].bearing.reset();
  EXPECT_EQ(numbers(associate(found, kHall, PosePrior{{}, 0.01 * Mat3::Identity()})),
            (std::vector<int>{1, 4, 5}));
}

TEST(Sightings, FromAScanToNumbers) {
  const Pose2 pose{0.3, -0.4, 0.7};
  for (const bool known : {false, true}) {
    std::optional<PosePrior> prior;
    if (known) prior = PosePrior{pose, 0.01 * Mat3::Identity()};
    auto found = numbers(sightings(scan_of(kHall, pose), kHall, prior));
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, (std::vector<int>{1, 2, 3, 4, 5}));
  }
}

}  // namespace
}  // namespace majak::beacon
