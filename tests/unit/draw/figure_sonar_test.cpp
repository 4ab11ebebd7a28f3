// SPDX-License-Identifier: Apache-2.0
// Figure 16: the filter behind it knows its errors, and the picture shows it.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "majak/core/chi_square.hpp"
#include "majak/draw/sonar_drive.hpp"
#include "majak/draw/thesis_figures.hpp"

namespace majak::draw {
namespace {

double nees(const Vec2& error, const Eigen::Matrix2d& covariance) {
  return error.dot(covariance.inverse() * error);
}

/// Of all features over many drives: how many their 95 % ellipses hold, and the mean NEES.
struct Coverage {
  double held = 0, nees = 0, features = 0;
  void add(const SonarDrive& drive) {
    for (int i = 0; i < kSonarFeatures; ++i) {
      const auto f = drive.feature(i);
      ASSERT_TRUE(f);
      const double n =
          draw::nees(f->p_map - sonar_features()[static_cast<std::size_t>(i)], f->covariance);
      held += n < chi_square_quantile(0.95, 2), nees += n, ++features;
    }
  }
  double share() const { return held / features; }
  double mean() const { return nees / features; }
};

// The errors of one drive go together, so it takes many drives.
TEST(SonarDrive, EllipsesHoldTheTrueFeaturesBeforeAndAfterTheLoop) {
  Coverage before, after;
  double vehicle = 0;
  constexpr int kDrives = 300;
  for (int seed = 1; seed <= kDrives; ++seed) {
    SonarDrive drive(static_cast<std::uint64_t>(seed));
    while (drive.steps() < 131) {
      drive.step();
      ASSERT_FALSE(drive.loop_closes());
    }
    before.add(drive);
    vehicle +=
        nees(drive.estimate().translation() - drive.truth().translation(), drive.covariance()) /
        kDrives;
    drive.step();
    ASSERT_TRUE(drive.loop_closes());
    while (drive.steps() < kSonarLap) drive.step();
    after.add(drive);
  }
  for (const Coverage& c : {before, after}) {
    EXPECT_GT(c.share(), 0.93);
    EXPECT_LT(c.share(), 0.97);
    EXPECT_NEAR(c.mean(), 2, 0.2);
  }
  EXPECT_NEAR(vehicle, 2, 0.35);
}

TEST(SonarDrive, ItsCourseIsClosedAndItsFeaturesAreHeardOnTime) {
  SonarDrive drive(1);
  std::vector<int> first(kSonarFeatures, 0);
  for (int i = 1; i <= kSonarLap; ++i) {
    drive.step();
    for (const int k : drive.heard()) {
      const Vec2 way = sonar_features()[static_cast<std::size_t>(k)] - drive.truth().translation();
      EXPECT_LT(way.norm(), kSonarReach);
      int& at = first[static_cast<std::size_t>(k)];
      if (at == 0) at = i;
    }
    for (int k = 0; k < kSonarFeatures; ++k)
      EXPECT_EQ(drive.feature(k).has_value(), first[static_cast<std::size_t>(k)] > 0);
  }
  for (const int at : first) EXPECT_GT(at, 0);
  EXPECT_LT(drive.truth().translation().norm(), 1e-9);
  EXPECT_NEAR(drive.truth().theta, 0, 1e-9);
  EXPECT_LT(drive.estimate().translation().norm(),
            0.3 * drive.dead_reckoned().translation().norm());
}

TEST(SonarDrive, SameSeedSameDrive) {
  SonarDrive a(7), b(7), other(8);
  for (int i = 0; i < 60; ++i) a.step(), b.step(), other.step();
  EXPECT_EQ(a.estimate().x, b.estimate().x);
  EXPECT_NE(a.estimate().x, other.estimate().x);
}

std::vector<Ellipse> features_of(const Panel& panel) {
  std::vector<Ellipse> found;
  for (const Mark& mark : panel.marks)
    if (const auto* e = std::get_if<Ellipse>(&mark); e && e->pen.colour.b == ink::blue.b)
      found.push_back(*e);
  return found;
}

TEST(FigureSonar, EveryEllipseShrinksWhereTheLoopCloses) {
  const Figure figure = figure_sonar({});
  ASSERT_EQ(figure.panels.size(), 3U);
  const auto before = features_of(figure.panels[0]), after = features_of(figure.panels[1]);
  ASSERT_EQ(before.size(), 14U);
  ASSERT_EQ(after.size(), 14U);
  // The later it was found, the more; the last one was found while others were seen again.
  double last = 1;
  for (std::size_t i = 0; i < 13; ++i) {
    const double share = after[i].rx * after[i].ry / (before[i].rx * before[i].ry);
    EXPECT_LT(share, last);
    last = share;
  }
  EXPECT_LT(last, 0.1);
  EXPECT_LT(after[13].rx * after[13].ry, 0.6 * before[13].rx * before[13].ry);
}

// A landmark that stands still is never known worse than before (Dissanayake et al. 2001).
TEST(FigureSonar, NoEllipseEverGrows) {
  const Figure figure = figure_sonar({});
  int lines = 0;
  for (const Mark& mark : figure.panels.at(2).marks) {
    const auto* line = std::get_if<Polyline>(&mark);
    if (!line || line->pen.dash > 0) continue;
    ++lines;
    ASSERT_GT(line->points.size(), 20U);
    for (std::size_t i = 1; i < line->points.size(); ++i)
      ASSERT_LE(line->points[i].y, line->points[i - 1].y * (1 + 1e-9));
  }
  EXPECT_EQ(lines, 14);
}

}  // namespace
}  // namespace majak::draw
