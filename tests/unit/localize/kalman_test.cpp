// SPDX-License-Identifier: Apache-2.0
#include "majak/localize/kalman.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>

#include "majak/core/random.hpp"

namespace majak::localize {
namespace {

constexpr double kScale = 1.02, kSteeringScale = 0.97;  // true per counted
const Vec2 kAntenna(1.2, 0.4);

struct Drive {
  std::vector<Event> events;
  std::vector<Truth> truth;  // at the wheels' stamps
};

struct Course {
  bool car = true;
  double heading = 0.7;
  double seconds = 120;
  std::function<bool(double)> outage = [](double) { return false; };
  std::function<Vec2(double, std::size_t)> wrong = [](double, std::size_t) {
    return Vec2(0, 0);
  };  // of the fix at a time
};

// A car or a robot with two wheels, ten records a second, a fix a second. Its random errors and
// those of the satellites are as the options say; the slow one is drawn anew after an outage.
Drive simulate(std::uint64_t seed, const Course& course = {}) {
  const KalmanOptions o;
  RandomStream random(seed);
  const auto normal2 = [&] { return Vec2(random.normal(), random.normal()); };
  const double step = 0.1, speed = 3, way = speed * step;
  Drive drive;
  Pose2 truth{20, -10, course.heading}, odometry;
  Vec2 slow = o.gps_sigma * normal2();
  const double fast = o.gps_fast_share * o.gps_sigma, keep = std::exp(-1 / o.gps_memory);
  bool out = false;
  for (int i = 0; i * step < course.seconds; ++i) {
    const double t = i * step;
    const Time time = from_seconds(t);
    const double steering = 0.3 * std::sin(0.15 * t) + 0.1 * std::sin(0.4 * t);
    const Vec3 counted(way, 0, way * std::tan(steering) / o.wheelbase);
    if (course.car)
      drive.events.push_back(WheelMotion{time, speed, steering});
    else
      drive.events.push_back(Odometry{time, odometry, {}, {}});
    drive.truth.push_back({time, truth});
    if (i % 10 == 0) {
      slow = keep * slow + o.gps_sigma * std::sqrt(1 - keep * keep) * normal2();
      if (course.outage(t)) {
        out = true;
      } else {
        if (out) slow = o.gps_sigma * normal2();
        out = false;
        const Vec2 z =
            truth * kAntenna + slow + fast * normal2() + course.wrong(t, drive.events.size());
        drive.events.push_back(GpsFix{time, z.x(), z.y(), 0});
      }
    }
    const double turn = course.car
                            ? kScale * way * std::tan(kSteeringScale * steering) / o.wheelbase
                            : kSteeringScale * counted.z() + 0.01 * way;
    const double spread = std::sqrt(o.turn_noise * o.turn_noise * way +
                                    o.spin_noise * o.spin_noise * std::abs(counted.z()));
    truth = truth * exp({kScale * way, 0, turn}) *
            exp({o.way_noise * std::sqrt(way) * random.normal(),
                 o.side_noise * std::sqrt(way) * random.normal(), spread * random.normal()});
    odometry = odometry * exp(counted);
  }
  return drive;
}

struct Ran {
  std::vector<Estimate> online;
  Localization result;
};

Ran run(const std::vector<Event>& events) {
  Kalman kalman({});
  Ran ran;
  for (const Event& event : events)
    if (const auto e = kalman.add(event)) ran.online.push_back(*e);
  ran.result = kalman.finish();
  return ran;
}

const Estimate& at(const std::vector<Estimate>& estimates, Time time) {
  const Estimate* best = &estimates.front();
  for (const Estimate& e : estimates)
    if (std::abs(e.time - time) <= std::abs(best->time - time)) best = &e;
  return *best;
}

Vec3 error(const Estimate& e, const Pose2& truth) {
  return {truth.x - e.T_map_robot.x, truth.y - e.T_map_robot.y,
          angle_diff(truth.theta, e.T_map_robot.theta)};
}

TEST(Kalman, NoEventsNoResult) {
  const Ran ran = run({});
  EXPECT_TRUE(ran.result.estimates.empty());
  EXPECT_TRUE(ran.result.learnt.empty());
  EXPECT_TRUE(ran.result.report.empty());
}

TEST(Kalman, FindsItsHeadingFromAnyStart) {
  for (const bool car : {true, false}) {
    for (int i = 0; i < 8; ++i) {
      const Drive drive =
          simulate(7, {.car = car, .heading = wrap_angle(i * kPi / 4), .seconds = 60});
      const Ran ran = run(drive.events);
      EXPECT_EQ(ran.online[5].health, Health::lost);  // not known yet
      const Truth& last = drive.truth.back();
      EXPECT_LT(std::abs(error(ran.online.back(), last.T_world_robot).z()), 0.1) << car << i;
      EXPECT_LT(error(ran.result.estimates.back(), last.T_world_robot).head<2>().norm(), 1.5);
      EXPECT_LT(std::abs(error(at(ran.result.estimates, 0), drive.truth[0].T_world_robot).z()),
                0.1);
    }
  }
}

TEST(Kalman, WithoutFixesItIsDeadReckoning) {
  Pose2 odometry;
  std::vector<Event> events;
  for (int i = 0; i < 50; ++i) {
    events.push_back(Odometry{i * kSecond, Pose2{5, 6, 1} * odometry, {}, {}});
    odometry = odometry * exp({0.5, 0, 0.1 * (i % 5)});
  }
  const Ran ran = run(events);
  ASSERT_EQ(ran.result.estimates.size(), 50U);
  const Pose2& first = std::get<Odometry>(events.front()).T_odom_robot;
  for (std::size_t i = 0; i < 50; ++i) {
    const Pose2 expected = between(first, std::get<Odometry>(events[i]).T_odom_robot);
    EXPECT_LT(error(ran.result.estimates[i], expected).norm(), 1e-9) << i;
    EXPECT_LT(error(ran.online[i], expected).norm(), 1e-9) << i;
  }
}

TEST(Kalman, CarsFollowTheArcOfTheRearAxle) {
  std::vector<Event> events;
  for (int i = 0; i <= 100; ++i) events.push_back(WheelMotion{i * kSecond / 20, 3, 0.3});
  const double radius = KalmanOptions{}.wheelbase / std::tan(0.3), turn = 15 / radius;
  const Pose2 expected{radius * std::sin(turn), radius * (1 - std::cos(turn)), wrap_angle(turn)};
  EXPECT_LT(error(run(events).result.estimates.back(), expected).norm(), 1e-9);
}

TEST(Kalman, StampsOutOfOrderAreCounted) {
  Drive drive = simulate(3, {.seconds = 40});
  std::get<WheelMotion>(drive.events[200]).time -= 5 * kSecond;
  const Ran ran = run(drive.events);
  EXPECT_EQ(ran.result.report.entries().size(), 1U);
  EXPECT_EQ(ran.result.report.entries().begin()->second.count, 1);
  for (std::size_t i = 1; i < ran.result.estimates.size(); ++i)
    EXPECT_GE(ran.result.estimates[i].time, ran.result.estimates[i - 1].time);
}

TEST(Kalman, SameEventsSameBytes) {
  const Drive drive = simulate(4, {.seconds = 40});
  const Ran a = run(drive.events), b = run(drive.events);
  ASSERT_EQ(a.result.estimates.size(), b.result.estimates.size());
  for (std::size_t i = 0; i < a.result.estimates.size(); ++i) {
    EXPECT_EQ(a.result.estimates[i].T_map_robot, b.result.estimates[i].T_map_robot);
    EXPECT_EQ(a.result.estimates[i].covariance, b.result.estimates[i].covariance);
  }
}

double nees(const Estimate& e, const Pose2& truth) {
  return error(e, truth).dot(e.covariance.ldlt().solve(error(e, truth)));
}

struct Means {
  double smoothed = 0, online = 0, nis = 0, metres = 0, worst_learnt = 0;
};

Means over_seeds(const Course& course, int runs) {
  Means m;
  for (int seed = 1; seed <= runs; ++seed) {
    const Drive drive = simulate(static_cast<std::uint64_t>(seed), course);
    const Ran ran = run(drive.events);
    const Truth& middle = drive.truth[drive.truth.size() / 2];
    const Truth& last = drive.truth.back();
    m.smoothed += nees(at(ran.result.estimates, middle.time), middle.T_world_robot) / runs;
    m.metres +=
        error(at(ran.result.estimates, middle.time), middle.T_world_robot).head<2>().norm() / runs;
    m.online += nees(at(ran.online, last.time), last.T_world_robot) / runs;
    double nis = 0;
    for (const Innovation& i : ran.result.innovations) nis += i.nis;
    m.nis += nis / double(ran.result.innovations.size()) / runs;
    const double offset = course.car ? 0 : 0.01;
    for (const LearntValue& v : ran.result.learnt) {
      double truth = std::nan("");
      if (v.name == "scale of the way") truth = kScale;
      if (v.name.starts_with("scale of the steering") || v.name == "scale of turns")
        truth = kSteeringScale;
      if (v.name == "turn per way") truth = offset;
      if (v.name == "antenna ahead") truth = kAntenna.x();
      if (v.name == "antenna to the left") truth = kAntenna.y();
      if (std::isfinite(truth))
        m.worst_learnt = std::max(m.worst_learnt, std::abs(v.value - truth) / v.sigma);
    }
  }
  return m;
}

// Mean NEES of 30 runs, 3 expected, 99 % band 1.97 ... 4.28. What is learnt errs more than it says
// in one place: the antenna ahead comes out 0.08 m (0.7 sigma) too far, as the likeliest path and
// numbers together are not the likeliest numbers.
TEST(KalmanOverSeeds, ACarFindsItsWayAndItsErrors) {
  const Means m = over_seeds({.car = true}, 30);
  EXPECT_LT(m.smoothed, 4.28);     // 2.84 seen
  EXPECT_LT(m.online, 3.3);        // 2.97 seen
  EXPECT_NEAR(m.nis, 2, 0.15);     // 2.07 seen
  EXPECT_LT(m.metres, 0.45);       // 0.41 seen: that of the satellites' slow error
  EXPECT_LT(m.worst_learnt, 3.8);  // sigmas, worst of 150 values; 3.6 seen
}

TEST(KalmanOverSeeds, ARobotOnTwoWheelsToo) {
  const Means m = over_seeds({.car = false}, 30);
  EXPECT_LT(m.smoothed, 4.28);     // 2.49 seen
  EXPECT_LT(m.online, 4.28);       // 3.55 seen
  EXPECT_NEAR(m.nis, 2, 0.15);     // 2.07 seen
  EXPECT_LT(m.metres, 0.4);        // 0.36 seen
  EXPECT_LT(m.worst_learnt, 3.7);  // 3.5 seen
}

TEST(KalmanOverSeeds, AlsoAcrossAnOutage) {
  const Means m = over_seeds({.outage = [](double t) { return t > 50 && t < 75; }}, 30);
  EXPECT_LT(m.smoothed, 4.28);   // 3.03 seen
  EXPECT_LT(m.online, 4.28);     // 3.91 seen
  EXPECT_NEAR(m.nis, 2, 0.15);   // 2.03 seen
  EXPECT_LT(m.metres, 0.75);     // 0.68 seen, amidst the outage
  EXPECT_LT(m.worst_learnt, 3);  // 2.8 seen
}

TEST(Kalman, WrongFixesDoNotMoveThePath) {
  const auto path = [](const Course& course) { return run(simulate(5, course).events).result; };
  const auto clean = path({});
  for (const int fixes : {1, 6}) {
    Course course;
    course.wrong = [=](double t, std::size_t) {
      return t >= 59.5 && t < 59.5 + fixes ? Vec2(30, -40) : Vec2(0, 0);
    };
    const auto disturbed = path(course);
    ASSERT_EQ(clean.estimates.size(), disturbed.estimates.size());
    double most = 0;
    for (std::size_t i = 0; i < clean.estimates.size(); ++i) {
      const Vec3 moved = error(clean.estimates[i], disturbed.estimates[i].T_map_robot);
      most =
          std::max(most, std::sqrt(moved.dot(clean.estimates[i].covariance.ldlt().solve(moved))));
    }
    EXPECT_LT(most, 3) << fixes;
  }
}

// What a receiver says of its fixes counts as if it had been told by an option.
TEST(Kalman, AStatedSigmaIsTheOption) {
  KalmanOptions options;
  options.gps_sigma = 2;
  options.pieces.jump = 2;
  Kalman told(options);
  options.gps_sigma = 0.35;
  Kalman stated(options);
  for (Event event : simulate(8, {.seconds = 60}).events) {
    told.add(event);
    if (auto* fix = std::get_if<GpsFix>(&event)) fix->sigma = 2;
    stated.add(event);
  }
  const auto a = told.finish(), b = stated.finish();
  EXPECT_GT(a.estimates.back().covariance(0, 0), 1);  // 2 m of error do not average away
  EXPECT_EQ(a.estimates.back().T_map_robot, b.estimates.back().T_map_robot);
  EXPECT_EQ(a.estimates.back().covariance, b.estimates.back().covariance);
}

TEST(Kalman, FixesAloneGiveAPathNearThem) {
  std::vector<Event> events;
  RandomStream random(6);
  for (int i = 0; i < 60; ++i)
    events.push_back(GpsFix{i * kSecond, 100 + 0.1 * i + 0.05 * random.normal(), 50, 0});
  Scan scan;
  for (int i = 0; i < 59; ++i) {
    scan.time = i * kSecond + kSecond / 2;
    events.push_back(scan);
  }
  std::stable_sort(events.begin(), events.end(),
                   [](const Event& a, const Event& b) { return time_of(a) < time_of(b); });
  const Ran ran = run(events);
  ASSERT_EQ(ran.result.estimates.size(), 59U);
  for (std::size_t i = 0; i < 59; ++i) {
    const Pose2& p = ran.result.estimates[i].T_map_robot;
    EXPECT_NEAR(p.y, 50, 3);
    EXPECT_NEAR(p.x, 100 + 0.1 * (double(i) + 0.5), 3);
  }
}

}  // namespace
}  // namespace majak::localize
