// SPDX-License-Identifier: Apache-2.0
// A car that reports speed and steering: mapped, calibrated, and found again by its wheels.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "majak/core/chi_square.hpp"
#include "majak/methods/methods.hpp"
#include "majak/motion/drive_log.hpp"
#include "majak/sensor/lms291.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/simulator.hpp"
#include "majak/slam/graph_slam.hpp"

namespace majak::methods {
namespace {

constexpr double kSpeedScale = 1.01, kOffset = 0.01, kLag = 0.05, kBelieved = 1.02;
const Pose2 kMounting{0.1, 0, 0}, kTold{0.07, 0.03, 0.0175};

sim::SimulationOptions faulty(int seed) {
  sim::SimulationOptions o;
  o.seed = seed, o.odometry_lag = kLag;
  o.robot.drive = sim::DriveKind::ackermann, o.robot.reports_steering = true;
  o.robot.left_scale = kSpeedScale, o.robot.steering_offset = kOffset;
  o.robot.scale_sigma = o.robot.unequal_sigma = o.robot.steering_sigma = 0;
  return o;
}

std::vector<Event> events_of(const sim::SimulationOptions& o) {
  static const sim::World world(sim::built_in("building"));
  static const sim::Path tour = sim::plan_tour(world, {.short_tour = true});
  std::vector<Event> events = sim::simulate(world, tour, o);
  for (Event& event : events)
    if (auto* scan = std::get_if<Scan>(&event)) scan->T_robot_laser = kTold;
  return events;
}

motion::Calibration calibrated(const std::vector<Event>& events, double wheelbase) {
  slam::GraphSlamOptions options;
  options.chain.drive.wheelbase = wheelbase;
  slam::GraphSlam slam(options, {1});
  motion::DriveLog log;
  for (const Event& event : events) {
    log.add(event);
    slam.add(event);
  }
  const Site site = slam.finish().site;
  EXPECT_TRUE(site.used_odometry);
  return motion::calibrate_log(log, site, {.wheelbase = wheelbase}).calibration;
}

motion::Vec7 true_values(const sim::SimulationOptions& o) {
  const double middle = to_seconds(sensor::beam_time(sensor::variant_of_beams(181), 90));
  motion::Vec7 v;  // a record tells of the time since the one before it
  v << 1 / kSpeedScale, kBelieved / kSpeedScale, -kOffset, kMounting.x, kMounting.y,
      kMounting.theta, kLag + middle + 1 / o.odometry_rate;
  return v;
}

/// Mean distance from the truth, from a common start.
double error_of(const char* name, const motion::DriveCorrection& drive,
                const std::vector<Event>& events) {
  LocalizeOptions options;
  options.drive = drive;
  const localize::Localizer localizer = method(name).make(options);
  motion::CorrectedDrive correct(drive);
  std::vector<Truth> truth;
  for (Event event : events) {
    if (const auto* t = std::get_if<Truth>(&event)) truth.push_back(*t);
    correct.apply(event);
    localizer.add(event);
  }
  const auto estimates = localizer.finish().estimates;
  const Pose2 T_map_world = estimates.front().T_map_robot * truth.front().T_world_robot.inverse();
  double sum = 0;
  std::size_t k = 0;
  for (const Truth& t : truth) {
    while (k + 1 < estimates.size() && estimates[k].time < t.time) ++k;
    sum += between(estimates[k].T_map_robot, T_map_world * t.T_world_robot).translation().norm();
  }
  return sum / static_cast<double>(truth.size());
}

TEST(Car, ItsFaultsAreFoundWithinTheirSigmas) {
  double nees = 0;
  constexpr int kRuns = 4;
  for (int seed = 1; seed <= kRuns; ++seed) {
    const sim::SimulationOptions o = faulty(seed);
    const motion::Calibration c = calibrated(events_of(o), kBelieved * o.robot.wheelbase);
    for (const Learnt& v : c.values) EXPECT_TRUE(v.used);
    const motion::Vec7 truth = true_values(o);
    motion::Vec7 error;
    for (int i = 0; i < 7; ++i) error(i) = c.values[static_cast<std::size_t>(i)].value - truth(i);
    nees += error.dot(c.covariance.inverse() * error);
    EXPECT_LT(std::abs(c.length.value - o.robot.wheelbase), 3 * c.length.sigma);
    EXPECT_LT(c.length.sigma, 0.003);
  }
  EXPECT_LT(nees, chi_square_quantile(0.999, 7 * kRuns));
}

TEST(Car, CalibratedItFindsItsWayByTheWheels) {
  const sim::SimulationOptions o = faulty(9);
  const std::vector<Event> events = events_of(o);
  const double believed = kBelieved * o.robot.wheelbase;
  motion::DriveCorrection raw;
  raw.wheelbase = believed;
  const motion::DriveCorrection mended = calibrated(events, believed).correction;
  EXPECT_EQ(mended.wheelbase, believed);
  for (const char* name : {"dead-reckoning", "kalman"}) {
    EXPECT_GT(error_of(name, raw, events), 2) << name;
    EXPECT_LT(error_of(name, mended, events), 0.5) << name;
  }
}

}  // namespace
}  // namespace majak::methods
