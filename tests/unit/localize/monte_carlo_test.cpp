// SPDX-License-Identifier: Apache-2.0
#include "majak/localize/monte_carlo.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include <algorithm>
#include <numeric>
#include <variant>
#include <vector>

#include "majak/core/chi_square.hpp"
#include "tests/support/ascii_map.hpp"
#include "tests/unit/localize/known_drive.hpp"

namespace majak::localize {
namespace {

/// Adds scans from `i` on until `updates` more updates are done; returns the scan added last.
std::size_t run(MonteCarlo& filter, std::size_t i, int updates,
                std::vector<Estimate>* estimates = nullptr) {
  const int until = filter.updates() + updates;
  for (bool first = true;; ++i, first = false) {
    const FedScan& scan = drive().scans.at(i);
    const Estimate e = filter.add(first ? without_motion(scan) : scan);
    if (estimates) estimates->push_back(e);
    if (filter.updates() == until) return i;
  }
}

TEST(MonteCarloDrive, TruthAndScansGoTogether) {
  ASSERT_EQ(drive().truth.size(), drive().scans.size());
  ASSERT_GT(drive().scans.size(), 300U);
}

TEST(MonteCarlo, WhileItRestsItGetsNoLessSure) {
  MonteCarlo filter(drive().place, {.start_sigma = 0.2}, drive().truth.front());
  const std::size_t i = run(filter, 0, 20);
  FedScan resting = without_motion(drive().scans[i]);
  resting.covariance = Vec3(4e-4, 4e-4, 4e-4).asDiagonal();
  const Mat3 before = filter.add(resting).covariance;
  for (int k = 0; k < 100; ++k) filter.add(resting);
  EXPECT_EQ(filter.add(resting).covariance, before);
  EXPECT_FALSE(filter.updated());
  resting.T_previous_robot = {0.01, 0, 0};
  EXPECT_NEAR(filter.add(resting).covariance.trace(), before.trace() + 12e-4, 1e-4);
}

// Thesis, figure 9.
TEST(MonteCarlo, FindsItselfFromAnywhere) {
  int found = 0, all_weight = 0;
  constexpr int kStarts = 20;
  for (int k = 0; k < kStarts; ++k) {
    MonteCarlo filter(drive().place, {.seed = k});
    const std::size_t i = run(filter, static_cast<std::size_t>(k) * drive().scans.size() / 30, 15);
    found += right(filter.clusters().front().T_map_robot, drive().truth[i]);
    double weight = 0;
    for (std::size_t p = 0; p < filter.weights().size(); ++p) {
      const auto& poses = filter.poses();
      weight +=
          filter.weights()[p] *
          right({poses.x[p], poses.y[p], std::atan2(poses.sin[p], poses.cos[p])}, drive().truth[i]);
    }
    all_weight += weight >= 0.99;
  }
  EXPECT_EQ(found, kStarts);
  EXPECT_EQ(all_weight, kStarts);
}

TEST(MonteCarlo, BeamModelFindsItToo) {
  MonteCarlo filter(drive().place, {.particles = 800, .beams = 40, .beam_model = true});
  const std::size_t i = run(filter, 100, 6);
  EXPECT_TRUE(right(filter.clusters().front().T_map_robot, drive().truth[i]));
  EXPECT_GT(filter.clusters().front().probability, 0.99);
}

TEST(MonteCarlo, SaysThatItWasCarriedAwayAndComesBack) {
  const std::size_t n = drive().scans.size();
  for (int k = 0; k < 10; ++k) {
    MonteCarlo filter(drive().place, {.seed = k});
    run(filter, static_cast<std::size_t>(k) * n / 30, 10);
    const std::size_t to = n / 2 + static_cast<std::size_t>(k) * n / 30;
    std::vector<Estimate> estimates;
    const std::size_t i = run(filter, to, 15, &estimates);
    EXPECT_TRUE(std::any_of(estimates.begin(), estimates.end(), [](const Estimate& e) {
      return e.health == Health::lost;
    })) << k;
    EXPECT_TRUE(right(estimates.back().T_map_robot, drive().truth[i])) << k;
    EXPECT_EQ(estimates.back().health, Health::ok) << k;
  }
}

// The thesis (p. 23) says that the particle filter recovers from this by itself; it does not.
TEST(MonteCarlo, WithoutNewParticlesItStaysLost) {
  const std::size_t n = drive().scans.size();
  int back = 0;
  for (int k = 0; k < 5; ++k) {
    MonteCarlo filter(
        drive().place,
        {.seed = k, .start_sigma = 0.2, .carried = 1e6, .slip = 0.01, .slip_turn = 0.01},
        drive().truth.front());
    run(filter, 0, 10);
    ASSERT_EQ(filter.clusters().size(), 1U);
    std::vector<Estimate> estimates;
    const std::size_t i = run(filter, n / 2 + static_cast<std::size_t>(k) * n / 30, 15, &estimates);
    back += right(estimates.back().T_map_robot, drive().truth[i]);
  }
  EXPECT_EQ(back, 0);
}

TEST(MonteCarlo, TracksWithFewParticlesAndHonestCovariance) {
  MonteCarlo filter(drive().place, {.start_sigma = 0.2}, drive().truth.front());
  double squares = 0, nees = 0;
  int n = 0, ok = 0;
  for (std::size_t i = 0; i < drive().scans.size(); ++i) {
    const Estimate e = filter.add(drive().scans[i]);
    if (!filter.updated() || filter.updates() < 10) continue;
    const Vec3 off(e.T_map_robot.x - drive().truth[i].x, e.T_map_robot.y - drive().truth[i].y,
                   angle_diff(e.T_map_robot.theta, drive().truth[i].theta));
    squares += off.head<2>().squaredNorm();
    nees += off.dot(e.covariance.inverse() * off);
    ++n;
    ok += e.health == Health::ok;
    EXPECT_LE(filter.weights().size(), 1000U);
  }
  ASSERT_GT(n, 200);
  EXPECT_GT(ok, 0.97 * n);
  // Cells of 5 cm, and a sweep that is not instant.
  EXPECT_LT(std::sqrt(squares / n), 0.04);
  EXPECT_LT(nees / n, 3);
}

TEST(MonteCarlo, MatchingIsNearerThanTheCloudAndStaysWithinIt) {
  Site site;  // every other scan makes the map
  for (std::size_t i = 0; i < drive().scans.size(); i += 2) {
    site.scans.push_back({drive().scans[i].scan, {}, {}, {}, i % 8 == 0, 1});
    site.scans.back().estimate.T_map_robot = drive().truth[i];
  }
  MonteCarlo filter(place_of(site), {.start_sigma = 0.2}, drive().truth.front());
  Vec3 squares[2] = {Vec3::Zero(), Vec3::Zero()};
  for (std::size_t i = 0; i < 500; ++i) {
    const Estimate e = filter.add(drive().scans[i]);
    if (!filter.updated() || filter.updates() < 5 || i % 2 == 0) continue;
    const Hypothesis& cloud = filter.clusters().front();
    const auto off = [](const Pose2& a, const Pose2& b) {
      return Vec3(a.x - b.x, a.y - b.y, angle_diff(a.theta, b.theta));
    };
    squares[0] += off(cloud.T_map_robot, drive().truth[i]).cwiseAbs2();
    squares[1] += off(e.T_map_robot, drive().truth[i]).cwiseAbs2();
    const Vec3 apart = off(e.T_map_robot, cloud.T_map_robot);
    EXPECT_LT(apart.dot(cloud.covariance.inverse() * apart), 2 * 16);
    EXPECT_EQ(e.covariance, cloud.covariance);
  }
  EXPECT_LT(squares[1].head<2>().sum(), 0.6 * squares[0].head<2>().sum());
  EXPECT_LT(squares[1].z(), 0.3 * squares[0].z());
}

TEST(MonteCarlo, TheSameForAnyNumberOfThreads) {
  const auto outputs = [](int threads) {
    MonteCarlo filter(drive().place, {.particles = 2000}, {}, {threads});
    std::vector<Estimate> estimates;
    run(filter, 20, 12, &estimates);
    run(filter, 200, 12, &estimates);
    std::vector<double> all;
    for (const Estimate& e : estimates) {
      all.insert(all.end(), {e.T_map_robot.x, e.T_map_robot.y, e.T_map_robot.theta,
                             static_cast<double>(e.health)});
      all.insert(all.end(), e.covariance.data(), e.covariance.data() + 9);
    }
    for (const auto* v :
         {&filter.poses().x, &filter.poses().y, &filter.poses().cos, &filter.poses().sin})
      all.insert(all.end(), v->begin(), v->end());
    all.insert(all.end(), filter.weights().begin(), filter.weights().end());
    return all;
  };
  const auto one = outputs(1);
  EXPECT_EQ(one, outputs(2));
  EXPECT_EQ(one, outputs(8));
}

// Errors drawn one by one have the covariance that the motion states (thesis p. 23).
TEST(MonteCarlo, MotionSpreadsAsItsCovarianceSays) {
  const auto place = place_of(fixture::ascii_map({"##########", "#........#", "##########"}));
  constexpr int n = 100000;
  const Pose2 start(4.3, 1.4, 0.7), motion(0.5, 0.1, 0.4);
  MonteCarlo filter(place,
                    {.particles = n,
                     .least = n,
                     .start_sigma = 1e-6,
                     .start_turn = 1e-6,
                     .spread = 1e-6,
                     .spread_turn = 1e-6,
                     .doubt = 100,
                     .lost = 100},
                    start);
  FedScan scan;
  scan.by_wheels = true;  // a scan without returns: nothing is weighed
  filter.add(scan);
  scan.T_previous_robot = motion;
  Mat3 a;
  a << 0.03, 0, 0, 0.01, 0.02, 0, -0.02, 0.03, 0.05;
  scan.covariance = a * a.transpose();
  filter.add(scan);
  Vec3 mean = Vec3::Zero();
  Mat3 second = Mat3::Zero();
  for (std::size_t i = 0; i < n; ++i) {
    const auto& p = filter.poses();
    EXPECT_NEAR(std::hypot(p.cos[i], p.sin[i]), 1, 1e-6);
    const Pose2 pose(p.x[i], p.y[i], std::atan2(p.sin[i], p.cos[i]));
    const Vec3 noise = log(between(start * motion, pose));
    mean += noise / n;
    second += noise * noise.transpose() / n;
  }
  for (int r = 0; r < 3; ++r) {
    EXPECT_NEAR(mean(r), 0, 4 * std::sqrt(scan.covariance(r, r) / n));
    for (int c = 0; c < 3; ++c) {
      const double sigma = std::sqrt(scan.covariance(r, r) * scan.covariance(c, c) * 2 / n);
      EXPECT_NEAR(second(r, c), scan.covariance(r, c), 4 * sigma) << r << c;
    }
  }
}

// Weights against one pose and one beam at a time.
TEST(MonteCarlo, WeightsAreTheLikelihoodOfTheSlowTwin) {
  const Drive& d = drive();
  MonteCarlo filter(d.place,
                    {.particles = 300,
                     .least = 300,
                     .effective = 3,
                     .start_sigma = 0.06,
                     .start_turn = 0.02,
                     .kld_quantile = 6,
                     .off_floor = 0.5},
                    d.truth.front());
  // Few effective beams and many particles: no resampling, so that poses and weights stay together.
  filter.add(d.scans.front());
  const match::Beams beams = match::beams(d.scans.front().scan);
  const auto& p = filter.poses();
  std::vector<double> twin;
  for (std::size_t i = 0; i < p.size(); ++i) {
    double cost = 0;
    for (std::size_t k = 0; k < beams.returns; ++k)
      cost += d.place->likelihood.cost(p.x[i] + p.cos[i] * beams.x[k] - p.sin[i] * beams.y[k],
                                       p.y[i] + p.sin[i] * beams.x[k] + p.cos[i] * beams.y[k]);
    const bool floor = d.place->known.at(Vec2(p.x[i], p.y[i])) == map::CellState::free;
    twin.push_back(
        std::exp(-cost * match::LikelihoodField::kUnit * 3 / static_cast<double>(beams.returns) -
                 (floor ? 0 : 0.5)));
  }
  const double sum = std::accumulate(twin.begin(), twin.end(), 0.0);
  ASSERT_EQ(filter.weights().size(), twin.size());
  double total = 0;
  for (std::size_t i = 0; i < twin.size(); ++i) {
    EXPECT_NEAR(filter.weights()[i], twin[i] / sum, 0.03 * twin[i] / sum) << i;
    total += filter.weights()[i];
  }
  EXPECT_NEAR(total, 1, 1e-12);
}

/// Each cell becomes k x k cells.
map::KnownMap finer(const map::KnownMap& map, int k) {
  map::KnownMap fine = map;
  fine.resolution /= k, fine.width *= k, fine.height *= k;
  fine.cells.resize(map.cells.size() * static_cast<std::size_t>(k * k));
  for (int iy = 0; iy < fine.height; ++iy)
    for (int ix = 0; ix < fine.width; ++ix) fine.cells[fine.index(ix, iy)] = map.at(ix / k, iy / k);
  return fine;
}

TEST(MonteCarlo, TwoEqualPlacesAreTwoClusters) {
  // Two rooms alike: a scan in one fits the other as well.
  const auto place = place_of(finer(fixture::ascii_map({"#########",  //
                                                        "#...#...#",  //
                                                        "#..##..##",  //
                                                        "#...#...#",  //
                                                        "#########"}),
                                    20));
  Scan scan;
  scan.start_angle = -kPi, scan.angle_step = radians(2), scan.max_range = 20;
  const Vec2 at(2.1, 2.4);
  for (int i = 0; i < 180; ++i) {
    const double angle = scan.angle(static_cast<std::size_t>(i));
    scan.ranges.push_back(
        static_cast<float>(place->distances.cast(at, Vec2(std::cos(angle), std::sin(angle)), 19)));
  }
  MonteCarlo filter(place, {});
  FedScan fed{scan, {}, Mat3::Zero(), false};
  const Estimate e = filter.add(fed);
  ASSERT_GE(filter.clusters().size(), 2U);
  EXPECT_NEAR(filter.clusters()[0].probability + filter.clusters()[1].probability, 1, 0.1);
  EXPECT_NEAR(std::abs(filter.clusters()[0].T_map_robot.x - filter.clusters()[1].T_map_robot.x), 4,
              0.15);
  EXPECT_NE(e.health, Health::ok);
}

}  // namespace
}  // namespace majak::localize
