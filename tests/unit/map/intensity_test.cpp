// SPDX-License-Identifier: Apache-2.0
#include "majak/map/intensity.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/sim/world.hpp"

namespace majak::map {
namespace {

constexpr double kPaper = 0.8, kWall = 0.4, kBlack = 0.1;
/// Ends of strips along the wall y = 4: black, paper, black.
constexpr double kStrips[] = {-2.0, -1.2, 0.5, 1.5, 2.6, 3.4};

/// A hall of 10 x 8 m with three strips on one wall, black walls at the left, paper at the right.
sim::World hall() {
  sim::Scene scene;
  const auto wall = [&](Vec2 a, Vec2 b, double reflectivity) {
    scene.segments.push_back({a, b, reflectivity});
  };
  double x = -5;
  for (int i = 0; i < 6; ++i) {
    const double strip = i == 3 ? kPaper : kBlack;
    wall({x, 4}, {kStrips[i], 4}, i % 2 == 0 ? kWall : strip);
    x = kStrips[i];
  }
  wall({x, 4}, {5, 4}, kWall);
  wall({5, 4}, {5, -4}, kPaper);
  wall({5, -4}, {-5, -4}, kWall);
  wall({-5, -4}, {-5, 4}, kBlack);
  return sim::World(std::move(scene));
}

/// Strength as light has it: brightness times cosine, over the square of the range; near by the
/// receiver does not see all of it.
double strength(const sim::Hit& hit) {
  return 5000 * hit.reflectivity * std::cos(hit.incidence) / (hit.range * hit.range + 1);
}

Scan look(const sim::World& world, const Pose2& pose, int number, double flicker = 0.05) {
  Scan scan;
  scan.start_angle = -kPi / 2;
  scan.angle_step = radians(0.5);
  scan.max_range = 80;
  RandomStream random(5, static_cast<std::uint64_t>(number));
  for (std::size_t i = 0; i <= 360; ++i) {
    const sim::Hit hit = world.cast(pose.translation(), pose.theta + scan.angle(i), 80);
    scan.ranges.push_back(static_cast<float>(hit.range));
    scan.intensities.push_back(static_cast<float>(strength(hit) * (1 + flicker * random.normal())));
  }
  return scan;
}

Pose2 place(int i) { return {4 * std::sin(0.7 * i), 3 * std::cos(0.53 * i), 1.1 * i}; }

Site walk(int scans = 60, double flicker = 0.05) {
  const sim::World world = hall();
  Site site;
  site.source_name = "hall.log";
  for (int i = 0; i < scans; ++i) {
    PosedScan& posed = site.scans.emplace_back();
    posed.estimate.T_map_robot = place(i);
    posed.scan = look(world, place(i), i, flicker);
  }
  return site;
}

TEST(Intensity, LearnsHowEchoesFadeWithRangeAndSlant) {
  const EchoResponse response = learn_echo_response(walk());
  // Of one surface, from 1.2 to 7 m and up to 65 degrees, against the law it was made with.
  const auto law = [](double r, double c) { return c / (r * r + 1); };
  const auto brightness = [&](double r, double c) { return response.normalized(law(r, c), r, c); };
  for (const double r : {1.2, 1.7, 2.5, 4.0, 7.0})
    for (const double c : {0.45, 0.6, 0.8, 1.0})
      EXPECT_NEAR(brightness(r, c) / brightness(3, 0.9), 1, 0.05) << r << ' ' << c;
}

TEST(Intensity, CurvesEqualTheSlowTwin) {
  // The twin has every cell's brightness as an unknown of its own. Flicker is so small that no
  // echo is distrusted.
  sim::Scene scene;
  const Vec2 corners[] = {{-3, -2}, {4, -2}, {4, 3}, {-3, 3}};
  for (int k = 0; k < 4; ++k) scene.segments.push_back({corners[k], corners[(k + 1) % 4], kWall});
  const sim::World room(std::move(scene));
  Site site;
  IntensityOptions o;
  o.resolution = 0.5;
  o.echo_sigma = 0.5;
  for (int i = 0; i < 4; ++i) {
    PosedScan& posed = site.scans.emplace_back();
    posed.estimate.T_map_robot = {0.4 * i, 0.3 * i, 1.3 * i};
    posed.scan = look(room, posed.estimate.T_map_robot, i, 0.02);
  }
  const EchoResponse fast = learn_echo_response(site, o);

  const int knots = 20, slants = 9, first_cell = knots + slants + 1;
  std::map<std::pair<int, int>, int> cells;
  std::vector<Eigen::VectorXd> rows;
  std::vector<double> right;
  const double low = std::log(o.min_range), step = (std::log(o.max_range) - low) / (knots - 1);
  const auto hang = [](Eigen::VectorXd& row, int first, double at) {
    const int i = static_cast<int>(at);
    row[first + i] += 1 - (at - i);
    if (at > i) row[first + i + 1] += at - i;
  };
  constexpr int kUnknowns = 200;
  for (const PosedScan& posed : site.scans)
    for (const SurfaceEcho& e : surface_echoes(posed.scan, o)) {
      const double angle = posed.scan.angle(e.beam);
      const Vec2 p = posed.estimate.T_map_robot *
                     (e.range * Vec2(std::cos(angle), std::sin(angle))) / o.resolution;
      const auto [cell, is_new] = cells.try_emplace({std::floor(p.x()), std::floor(p.y())},
                                                    first_cell + static_cast<int>(cells.size()));
      Eigen::VectorXd row = Eigen::VectorXd::Zero(kUnknowns);
      hang(row, 0, (std::log(e.range) - low) / step);
      hang(row, knots, e.cos_slant * (slants - 1));
      row[first_cell - 1] = row[cell->second] = 1;
      rows.push_back(row), right.push_back(std::log(e.intensity));
    }
  const auto prior = [&](int at, double weight) {
    rows.emplace_back(Eigen::VectorXd::Zero(kUnknowns))[at] = weight;
    right.push_back(0);
  };
  for (int c = 0; c < kUnknowns; ++c) prior(c, c < first_cell ? 1e-3 : o.echo_sigma / o.cell_sigma);
  for (int k = 1; k + 1 < first_cell - 1; ++k) {
    if (k == knots - 1 || k == knots) continue;
    prior(k, -2);
    rows.back()[k - 1] = rows.back()[k + 1] = 1;
  }
  Eigen::MatrixXd A(rows.size(), kUnknowns);
  for (std::size_t i = 0; i < rows.size(); ++i) A.row(static_cast<Eigen::Index>(i)) = rows[i];
  const Eigen::VectorXd b = Eigen::Map<Eigen::VectorXd>(right.data(), A.rows());
  const Eigen::VectorXd x = (A.transpose() * A).ldlt().solve(A.transpose() * b);
  for (int k = 0; k < knots; ++k)
    EXPECT_NEAR(fast.by_range[static_cast<std::size_t>(k)] - fast.by_range[10], x[k] - x[10], 1e-6);
  for (int k = 0; k < slants; ++k)
    EXPECT_NEAR(fast.by_slant[static_cast<std::size_t>(k)], x[knots + k] - x[knots + slants - 1],
                1e-6);
}

TEST(Intensity, DarkNearIsNotBrightFar) {
  const Site site = walk();
  const EchoResponse response = learn_echo_response(site);
  const sim::Hit dark{1.2, 0, kBlack}, bright{6, 0, kPaper};
  EXPECT_GT(strength(dark), strength(bright));  // what is received misleads
  EXPECT_NEAR(
      response.normalized(strength(bright), 6, 1) / response.normalized(strength(dark), 1.2, 1),
      kPaper / kBlack, 0.05 * kPaper / kBlack);
}

TEST(Intensity, CellsAreAsBrightAsTheirSurface) {
  const Site site = walk();
  const EchoResponse response = learn_echo_response(site);
  const IntensityMap map = build_intensity_map(site, response);
  const auto mean = [&](double x0, double x1) {  // of a piece of the wall y = 4
    double sum = 0, cells = 0;
    for (int ix = static_cast<int>(x0 / 0.05); ix < static_cast<int>(x1 / 0.05); ++ix)
      for (const int iy : {79, 80})
        if (map.known(ix, iy)) {
          EXPECT_LT(map.sigma(ix, iy), 0.2 * map.mean(ix, iy)) << ix;
          sum += map.mean(ix, iy), ++cells;
        }
    return sum / cells;
  };
  const double wall = mean(-4.5, -2.3);
  EXPECT_NEAR(mean(-1.9, -1.3) / wall, kBlack / kWall, 0.02);
  EXPECT_NEAR(mean(0.6, 1.4) / wall, kPaper / kWall, 0.06);
  EXPECT_NEAR(mean(2.7, 3.3) / wall, kBlack / kWall, 0.02);
}

TEST(Intensity, FindsTheEndsOfStripsWithinOneBeam) {
  const EchoResponse response = learn_echo_response(walk());
  const sim::World world = hall();
  int found = 0;
  for (int i = 0; i < 30; ++i) {
    const Pose2 pose{-1.5 + 0.1 * i, 1.5 - 0.05 * i, kPi / 2 + 0.01 * i};
    const Scan scan = look(world, pose, 1000 + i);
    std::vector<BrightnessEdge> edges = find_brightness_edges(scan, response);
    std::erase_if(edges, [&](const BrightnessEdge& e) {
      return (pose * e.at).y() < 3.9 || std::abs((pose * e.at).x()) > 4.8;
    });  // corners are edges as well
    ASSERT_EQ(edges.size(), std::size(kStrips)) << i;
    std::reverse(edges.begin(), edges.end());  // by rising x
    for (std::size_t k = 0; k < edges.size(); ++k, ++found) {
      const Vec2 way = pose.inverse() * Vec2(kStrips[k], 4);
      const double beam = (std::atan2(way.y(), way.x()) - scan.start_angle) / scan.angle_step;
      EXPECT_NEAR(edges[k].beam, beam, 1) << i << ' ' << k;
      EXPECT_EQ(edges[k].ratio < 1, k == 1 || k == 2 || k == 5) << k;
    }
  }
  EXPECT_EQ(found, 180);
}

TEST(Intensity, FindsNoEdgeOnAPlainWall) {
  const EchoResponse response = learn_echo_response(walk());
  sim::Scene scene;
  scene.segments.push_back({{-9, 3}, {9, 3}, kWall});
  const sim::World plain(std::move(scene));
  for (int i = 0; i < 30; ++i)
    EXPECT_TRUE(find_brightness_edges(look(plain, {0.1 * i, 0, kPi / 2}, i), response).empty());
}

TEST(Intensity, UnitsDoNotMatter) {
  Site site = walk(20);
  const IntensityMap one = build_intensity_map(site, learn_echo_response(site));
  for (PosedScan& posed : site.scans)
    for (float& v : posed.scan.intensities) v *= 64;
  const IntensityMap other = build_intensity_map(site, learn_echo_response(site));
  const CellBox box = one.bounds();
  ASSERT_EQ(box, other.bounds());
  for (int y = box.y0; y < box.y0 + box.height; ++y)
    for (int x = box.x0; x < box.x0 + box.width; ++x)
      ASSERT_NEAR(one.mean(x, y), other.mean(x, y), 1e-4 * one.mean(x, y));
}

TEST(Intensity, OutliersDoNotBendTheCurve) {
  Site site = walk();
  RandomStream random(9, 0);
  for (PosedScan& posed : site.scans)
    for (float& v : posed.scan.intensities)
      if (random.uniform(0, 1) < 0.03) v *= 40;  // mirrors, reflectors
  const EchoResponse clean = learn_echo_response(walk()), other = learn_echo_response(site);
  for (const double r : {1.0, 2.0, 4.0, 6.0})
    EXPECT_NEAR(other.normalized(1, r, 0.9) / other.normalized(1, 3, 0.9),
                clean.normalized(1, r, 0.9) / clean.normalized(1, 3, 0.9),
                0.04 * clean.normalized(1, r, 0.9) / clean.normalized(1, 3, 0.9));
}

TEST(Intensity, SaysWhatALogLacks) {
  Site site = walk(3);
  for (PosedScan& posed : site.scans) posed.scan.intensities.clear();
  try {
    learn_echo_response(site);
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("no usable scan of hall.log has intensities"),
              std::string::npos);
  }
  EXPECT_THROW(learn_echo_response(Site{}), Error);
  EXPECT_TRUE(surface_echoes(site.scans[0].scan).empty());
  IntensityOptions options;
  options.resolution = 0;
  EXPECT_THROW(learn_echo_response(walk(1), options), Error);
}

TEST(Intensity, SurvivesScansThatTellLittle) {
  Site site = walk(2);
  std::fill(site.scans[0].scan.ranges.begin(), site.scans[0].scan.ranges.end(), kNoReturn);
  std::fill(site.scans[1].scan.intensities.begin(), site.scans[1].scan.intensities.end(), 0.0F);
  const EchoResponse response = learn_echo_response(site);
  EXPECT_TRUE(std::isfinite(response.normalized(100, 2, 0.5)));
  EXPECT_EQ(build_intensity_map(site, response).bounds(), CellBox{});
}

}  // namespace
}  // namespace majak::map
