// SPDX-License-Identifier: Apache-2.0
#include "majak/localize/tracking.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "majak/core/random.hpp"
#include "tests/support/ascii_map.hpp"
#include "tests/support/ascii_room.hpp"
#include "tests/unit/localize/known_drive.hpp"

namespace majak::localize {
namespace {

/// The site of a room that was seen from one place all around.
PlacePtr place_seen(const fixture::AsciiRoom& room, const std::vector<Pose2>& from) {
  Site site;
  for (const Pose2& pose : from) {
    site.scans.push_back({});
    site.scans.back().scan = room.scan(pose, fixture::all_around(720));
    site.scans.back().estimate.T_map_robot = pose;
  }
  return place_of(site);
}

const fixture::AsciiRoom& room() {
  static const fixture::AsciiRoom room({"################",  //
                                        "#..............#",  //
                                        "#....a.........#",  //
                                        "#.........##...#",  //
                                        "#..............#",  //
                                        "################"});
  return room;
}

FedScan fed(Scan scan, const Pose2& step, double sigma = 0.1) {
  return {std::move(scan), step, Vec3(sigma, sigma, sigma).cwiseAbs2().asDiagonal(), true};
}

TEST(Tracking, AWrongPredictionIsCorrected) {
  const Pose2 truth = room().pose('a', 0.3);
  Tracker tracker(place_seen(room(), {truth, {3, 1, 0}, {6.5, 2, 0}}), {},
                  truth * Pose2{0.15, -0.1, 0.05});
  for (int k = 0; k < 3; ++k) tracker.add(fed(room().scan(truth, fixture::all_around()), {}));
  const Estimate e = tracker.add(fed(room().scan(truth, fixture::all_around()), {}));
  EXPECT_LT((e.T_map_robot.translation() - truth.translation()).norm(), 0.003);
  EXPECT_LT(std::abs(angle_diff(e.T_map_robot.theta, truth.theta)), 0.001);
  EXPECT_EQ(e.health, Health::ok);
}

TEST(Tracking, ThePhasesOneByOneAreTheWhole) {
  Tracker whole(drive().place, {}, drive().truth[0]), parts = whole;
  for (std::size_t k = 0; k < 60; ++k) {
    const FedScan& scan = drive().scans[k];
    const Estimate e = whole.add(scan);
    parts.move(scan);
    parts.predict();
    parts.measure(scan);
    EXPECT_EQ(parts.correct().T_map_robot, e.T_map_robot);
    EXPECT_EQ(parts.predicted(), whole.predicted());
  }
}

TEST(Tracking, KeepsTheRobotAlongTheWholeDrive) {
  Tracker tracker(drive().place, {}, drive().truth[0]);
  double worst = 0, sum = 0;
  for (std::size_t k = 0; k < drive().scans.size(); ++k) {
    const Estimate e = tracker.add(drive().scans[k]);
    const double off = (e.T_map_robot.translation() - drive().truth[k].translation()).norm();
    sum += off;
    if (k > 10) worst = std::max(worst, off);
    EXPECT_NE(e.health, Health::lost);
  }
  // The map's walls are cells of 5 cm, the laser reads 35 mm too long or too short.
  EXPECT_LT(sum / static_cast<double>(drive().scans.size()), 0.042);
  EXPECT_LT(worst, 0.165);
}

TEST(Tracking, WithoutABeamItGoesByTheWheels) {
  Tracker tracker(drive().place, {}, drive().truth[0]);
  const Estimate before = tracker.add(drive().scans[0]);
  FedScan blind = fed(drive().scans[1].scan, {0.3, 0, 0.1}, 0.02);
  std::fill(blind.scan.ranges.begin(), blind.scan.ranges.end(), kInvalidRange);
  const Estimate e = tracker.add(blind);
  const Pose2 off = between(before.T_map_robot * Pose2{0.3, 0, 0.1}, e.T_map_robot);
  EXPECT_LT(off.translation().norm(), 1e-9);
  EXPECT_GT(e.covariance(0, 0), before.covariance(0, 0));
}

TEST(Tracking, AnEmptyCorridorIsWeakAlong) {
  std::vector<std::string> plan(7, std::string(160, '.'));
  plan.front() = plan.back() = std::string(160, '#');
  const fixture::AsciiRoom corridor(plan);
  const fixture::Laser near{181, kPi, 8, 0, 1, {}};
  Site site;
  for (double x = 36; x < 44; x += 0.5) {
    site.scans.push_back({});
    site.scans.back().scan = corridor.scan({x, 1.75, 0}, near);
    site.scans.back().estimate.T_map_robot = {x, 1.75, 0};
  }
  Tracker tracker(place_of(site), {}, {40, 1.75, 0});
  Estimate e;
  for (int k = 0; k < 20; ++k) e = tracker.add(fed(corridor.scan({40, 1.75, 0}, near), {}, 0.02));
  EXPECT_EQ(e.health, Health::degraded);
  EXPECT_GT(std::abs(e.weak_direction.x()), 0.99);
  EXPECT_LT(e.covariance(1, 1), 0.01 * e.covariance(0, 0));
}

TEST(Tracking, SaysThatItIsLostWhereNothingFits) {
  const fixture::AsciiRoom other({"#####", "#...#", "#.b.#", "#...#", "#####"});
  Tracker tracker(place_seen(room(), {room().pose('a')}), {}, room().pose('a'));
  Estimate e;
  for (int k = 0; k < 30; ++k)
    e = tracker.add(fed(other.scan(other.pose('b'), fixture::all_around()), {}, 0.01));
  EXPECT_EQ(e.health, Health::lost);
}

TEST(Tracking, PhasesAreTimedByTheClockThatIsGiven) {
  double time = 0;
  auto localizer = tracking(drive().place, {}, drive().truth[0], {}, [&] { return time += 1; });
  for (int k = 0; k < 5; ++k) localizer.add(drive().scans[k].scan);
  const Localization run = localizer.finish();
  ASSERT_EQ(run.phases.size(), 4U);
  for (const PhaseTime& phase : run.phases) EXPECT_EQ(phase.seconds, 5) << phase.name;
  EXPECT_EQ(run.innovations.size(), 5U);
}

// A room and its copy one metre further: a scan of `elsewhere` fits the prediction badly and
// another place of the window better, but not so well that it would be believed at once.
/// Scans until a tracker believes that the robot was carried by `step` while people hide every
/// fourth beam; 0: not within 60.
int jumped_after(int witnesses, double trusted_score, const Pose2& step) {
  const Pose2 truth = room().pose('a', 0.3), put = truth * step;
  TrackingOptions options;
  options.witnesses = witnesses;
  options.trusted_score = trusted_score;
  Tracker tracker(place_seen(room(), {truth, {3, 1, 0}, {6.5, 2, 0}}), options, truth);
  for (int k = 0; k < 5; ++k)
    tracker.add(fed(room().scan(truth, fixture::all_around()), {}, 0.005));
  Scan scan = room().scan(put, fixture::all_around());
  for (std::size_t i = 0; i < scan.ranges.size(); i += 4) scan.ranges[i] *= 0.5F;
  for (int k = 1; k <= 60; ++k) {
    const Estimate e = tracker.add(fed(scan, {}, 0.001));
    if ((e.T_map_robot.translation() - put.translation()).norm() < 0.05) return k;
  }
  return 0;
}

TEST(Tracking, AJumpIsBelievedAfterTwentyScansThatAgree) {
  const Pose2 far(0.45, 0, 0.1);
  EXPECT_EQ(jumped_after(20, 0.95, far), 20);
  EXPECT_EQ(jumped_after(7, 0.95, far), 7);
}

TEST(Tracking, OneScanAloneTellsOfAJumpOnlyWhereItFitsFarBetter) {
  EXPECT_EQ(jumped_after(20, 0.70, {0.45, 0, 0.1}), 1);
  // A door at the end has opened; half a metre farther on, what is behind it would be the door.
  const fixture::AsciiRoom closed({"##################",  //
                                   "#.............a..#",  //
                                   "#................#",  //
                                   "##################"});
  const fixture::AsciiRoom open({"###################",  //
                                 "#.............a...#",  //
                                 "#.................#",  //
                                 "###################"});
  const Pose2 truth = closed.pose('a', 0);
  TrackingOptions options;
  options.start_sigma = options.start_turn = 0.02;
  options.trusted_score = 0.90;
  Tracker tracker(place_seen(closed, {truth, truth * Pose2{-4, 0, 0}}), options, truth);
  const Scan scan = open.scan(open.pose('a', 0), fixture::all_around());
  for (int k = 1; k < 20; ++k)
    EXPECT_NEAR(tracker.add(fed(scan, {}, 0.001)).T_map_robot.x, truth.x, 0.01);
  EXPECT_NEAR(tracker.add(fed(scan, {}, 0.001)).T_map_robot.x, truth.x - 0.5, 0.01);
}

// All walls of a map may lie to the same side within their cells; no scan tells.
TEST(Tracking, ACellsWidthIsInTheCovariance) {
  const Pose2 truth = room().pose('a', 0.3);
  const PlacePtr seen = place_seen(room(), {truth, {3, 1, 0}, {6.5, 2, 0}});
  Place cells = *seen;
  cells.surface_sigma = 0.03;
  const FedScan scan = fed(room().scan(truth, fixture::all_around()), {}, 0.02);
  const Mat3 sharp = Tracker(seen, {}, truth).add(scan).covariance;
  const Mat3 wide = Tracker(std::make_shared<Place>(cells), {}, truth).add(scan).covariance;
  EXPECT_TRUE((wide - sharp).isApprox(Mat3(Vec3(9e-4, 9e-4, 0).asDiagonal()), 1e-9));
  EXPECT_EQ(seen->surface_sigma, 0);
  EXPECT_NEAR(place_of(seen->known)->surface_sigma, seen->known.resolution / std::sqrt(12), 1e-12);
}

TEST(Tracking, CovarianceFollowsTheNoiseOfTheLaser) {
  const Pose2 truth = room().pose('a', 0.3);
  const PlacePtr place = place_seen(room(), {truth, {3, 1, 0}, {6.5, 2, 0}});
  const auto spread = [&](double noise) {
    Tracker tracker(place, {}, truth);
    Estimate e;
    for (int k = 0; k < 300; ++k) {
      fixture::Laser laser = fixture::all_around();
      laser.noise = noise, laser.seed = k;
      e = tracker.add(fed(room().scan(truth, laser), {}, 0.02));
    }
    return e.covariance;
  };
  const Mat3 quiet = spread(0.003), loud = spread(0.012);
  EXPECT_GT(loud(0, 0), 3 * quiet(0, 0));
  EXPECT_GT(loud(2, 2), 3 * quiet(2, 2));
}

TEST(Tracking, WithinTheChiSquareBandWhereTheMapIsExact) {
  const Pose2 truth = room().pose('a', 0.3);
  const PlacePtr place = place_seen(room(), {truth, {3, 1, 0}, {6.5, 2, 0}});
  RandomStream random(9);
  double nees = 0, n = 0;
  for (int run = 0; run < 4; ++run) {
    Tracker tracker(place, {}, truth);
    for (int k = 0; k < 400; ++k) {
      fixture::Laser laser = fixture::all_around();
      laser.noise = 0.01, laser.seed = 1000 * run + k;
      const double s = 0.002;
      const Pose2 odometry{s * random.normal(), s * random.normal(), s * random.normal()};
      const Estimate e = tracker.add(fed(room().scan(truth, laser), odometry, 0.02));
      if (k < 100) continue;
      const Vec3 off(e.T_map_robot.x - truth.x, e.T_map_robot.y - truth.y,
                     angle_diff(e.T_map_robot.theta, truth.theta));
      nees += off.dot(e.covariance.inverse() * off), n += 1;
    }
  }
  EXPECT_GT(nees / n, 1.0);
  EXPECT_LT(nees / n, 3.7);
}

// 'c' is closed in the map and open now, 'o' the other way round.
TEST(Tracking, DoorsThatChangedDoNotMislead) {
  const std::vector<std::string> plan = {
      "########################################", "#........#.........#.........#.........#",
      "#........#.........#.........#.........#", "#........#.........#.........#.........#",
      "###cc######..######cc######..######oo###", "#......................................#",
      "#......................................#", "#......................................#",
      "###..####cc####..#####oo####..####oo####", "#........#.........#.........#.........#",
      "#........#.........#.........#.........#", "########################################"};
  const auto with = [&](char open, char closed) {
    std::vector<std::string> lines = plan;
    for (std::string& line : lines)
      for (char& c : line) c = c == open ? '.' : c == closed ? '#' : c;
    return lines;
  };
  const PlacePtr before = place_of(fixture::ascii_map(fixture::finer(with('o', 'c'), 5), 0.1));
  const fixture::AsciiRoom now(with('c', 'o'));
  Pose2 truth{1.5, 2.7, 0};
  Tracker tracker(before, {}, truth);
  for (int k = 0; k < 150; ++k) {
    const Pose2 step = k == 0 ? Pose2{} : Pose2{0.1, 0, 0.02 * std::sin(0.2 * k)};
    truth = truth * step;
    FedScan scan;
    scan.scan = now.scan(truth, {181, kPi, 30, 0.01, k + 1, {}});
    scan.scan.time = k * kSecond / 5;
    scan.T_previous_robot = step * Pose2{0.002, 0, 0.0005};
    scan.covariance = Vec3(1e-4, 1e-4, 1e-4).asDiagonal();
    scan.by_wheels = true;
    const Estimate e = tracker.add(scan);
    EXPECT_LT((e.T_map_robot.translation() - truth.translation()).norm(), 0.10) << k;
    EXPECT_NE(e.health, Health::lost);
  }
}

}  // namespace
}  // namespace majak::localize
