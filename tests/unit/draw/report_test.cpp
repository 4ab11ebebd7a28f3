// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/report.hpp"
#include "majak/draw/viewer_page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "majak/draw/map_figure.hpp"
#include "tests/support/well_formed.hpp"

namespace majak::draw {
namespace {

using test::expect_well_formed;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// A robot that drives along x in a corridor, scans each metre.
Site corridor(int scans) {
  Site site;
  site.source_name = "corridor <1>.clf";
  for (int i = 0; i < scans; ++i) {
    PosedScan p;
    p.scan.time = i * kSecond;
    p.scan.start_angle = -kPi / 2;
    p.scan.angle_step = kPi / 2;
    p.scan.ranges = {2, 5, 2};
    p.estimate.T_map_robot = {static_cast<double>(i), 0, 0};
    p.estimate.covariance = Mat3::Identity() * 1e-4 * (i + 1);
    p.estimate.health = i == 3 ? Health::degraded : i == 5 ? Health::lost : Health::ok;
    p.T_map_robot_front_end = {static_cast<double>(i), 0.1 * i, 0};
    p.T_odom_robot = Pose2{7, 1.1 * i, kPi / 2};
    p.key = true;
    p.match_score = 0.75F;
    site.scans.push_back(p);
  }
  return site;
}

Constraint closure(std::size_t from, std::size_t to, double chi2, bool enabled = true) {
  Constraint c;
  c.kind = ConstraintKind::closure;
  c.from = from;
  c.to = to;
  c.chi2 = chi2;
  c.enabled = enabled;
  c.score = 0.875;
  return c;
}

std::string report_of(const Site& site, const ReportExtras& extras = {}) {
  return report_html(site, map::build_occupancy_grid(site), extras);
}

TEST(FitOf, FollowsChiSquare) {
  EXPECT_EQ(fit_of(closure(0, 1, 0)), Fit::good);
  EXPECT_EQ(fit_of(closure(0, 1, 7.8)), Fit::good);
  EXPECT_EQ(fit_of(closure(0, 1, 7.9)), Fit::strained);
  EXPECT_EQ(fit_of(closure(0, 1, 16.3)), Fit::poor);
  EXPECT_EQ(fit_of(closure(0, 1, 0, false)), Fit::rejected);
}

TEST(PathsOf, LaysOdometryOntoTheFirstPose) {
  const Paths paths = paths_of(corridor(5));
  ASSERT_EQ(paths.odometry.size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(paths.odometry[i].x, 1.1 * static_cast<double>(i), 1e-12);
    EXPECT_NEAR(paths.odometry[i].y, 0, 1e-12);
    EXPECT_EQ(paths.final[i], (Point{static_cast<double>(i), 0}));
  }
  EXPECT_TRUE(paths.truth.empty());
}

TEST(PathsOf, LaysTruthOntoTheFirstPose) {
  Site site = corridor(3);
  site.truth = {{-5 * kSecond, {0, 0, 0}}, {0, {3, 3, kPi}}, {kSecond, {2, 3, kPi}}};
  const Paths paths = paths_of(site);
  ASSERT_EQ(paths.truth.size(), 3U);
  EXPECT_NEAR(paths.truth[2].x, 1, 1e-12);
  EXPECT_NEAR(paths.truth[2].y, 0, 1e-12);
}

TEST(MapFigure, PutsThePathWhereThePictureHasIt) {
  const Site site = corridor(2);
  const map::OccupancyGrid grid = map::build_occupancy_grid(site);
  const MapFigure figure = map_figure(site, grid, paths_of(site));
  // Cells from x = 0 on, y from -2 to 2 m; 8 cells of margin; 20 cells a metre; y runs down.
  EXPECT_THAT(figure.svg, HasSubstr("<path class=\"layer line after\" d=\"M8 49L28 49\"/>"));
}

TEST(MapFigure, NamesTheLayersThatAreThere) {
  Site site = corridor(8);
  site.constraints = {closure(0, 4, 1), closure(0, 6, 30), closure(1, 7, 1, false)};
  const MapFigure figure = map_figure(site, map::build_occupancy_grid(site), paths_of(site));
  std::vector<std::string> styles;
  for (const Layer& layer : figure.layers) styles.push_back(layer.style);
  EXPECT_THAT(styles,
              testing::ElementsAre("picture", "odometry", "before", "after", "weak", "lost",
                                   "closure.rejected", "closure.good", "closure.poor", "ellipses"));
  EXPECT_EQ(figure.closures_drawn, 3U);
  EXPECT_GT(figure.ellipse_scale, 1);
}

TEST(Report, ListsTheBiggestSlips) {
  const std::string head = "Slips and bumps";
  const Site site = corridor(5);
  EXPECT_EQ(report_of(site).find(head), std::string::npos);
  const Time start = site.scans.front().scan.time;
  ReportExtras extras;
  extras.slips.assign(
      12, {start + 7 * kSecond, start + 9 * kSecond, motion::SlipKind::push, 0.25, radians(-30)});
  const std::string html = report_of(site, extras);
  expect_well_formed(html);
  EXPECT_NE(html.find(": 12; the 10 biggest"), std::string::npos);
  const std::string row = "<tr><td class=\"l\">push</td><td>7</td><td>2</td><td>25</td>";
  std::size_t rows = 0;
  for (std::size_t at = html.find(row); at != std::string::npos; at = html.find(row, at + 1))
    ++rows;
  EXPECT_EQ(rows, 10U) << html.substr(html.find(head), 600);
}

/// Without the viewer's own program, which speaks of addresses and never goes there:
/// tests/e2e/report.ts.
std::string without_program(std::string html) {
  const std::size_t begin = html.find("<script data-mount");
  if (begin == std::string::npos) return html;  // built without the viewer
  const std::size_t end = html.find("</script>", begin);
  return html.erase(begin, end + 9 - begin);
}

TEST(Report, HoldsTheViewerWithTheRunInIt) {
  const std::string html = report_of(corridor(3));
  if (viewer_page().script.empty()) GTEST_SKIP() << "built without the viewer";
  const std::string opening = "id=\"majak-data\">";
  const std::size_t data = html.find(opening);
  ASSERT_NE(data, std::string::npos);
  EXPECT_EQ(html.compare(data + opening.size(), 4, "H4sI"), 0);  // gzip's first bytes in base64
  // Scripts end where they are meant to.
  EXPECT_LT(without_program(html).size() + viewer_page().script.size(), html.size() + 1000);
}

TEST(Report, IsOneWellFormedPageThatNeedsNothingElse) {
  Site site = corridor(20);
  site.used_odometry = true;
  site.constraints = {closure(0, 4, 1), closure(0, 9, 12), closure(2, 19, 100),
                      closure(3, 8, 0, false)};
  site.report.count("carmen: <truncated> FLASER", 4711);
  site.options_toml = "[match]\nname = \"<&>\"\n";
  const std::string html =
      without_program(report_of(site, {{{"matching_cpu_s", 1.25}}, {{"ate_m", 0.033}}, "0.1.0"}));
  expect_well_formed(html);
  for (const char* outside : {"http:", "https:", "src=", "@import", "url("})
    EXPECT_THAT(html, Not(HasSubstr(outside)));
  EXPECT_THAT(html, AllOf(HasSubstr("corridor &lt;1&gt;.clf"),
                          HasSubstr("carmen: &lt;truncated&gt; FLASER"), HasSubstr("4711"),
                          HasSubstr("matching_cpu_s"), HasSubstr("1.25"), HasSubstr("ate_m"),
                          HasSubstr("&lt;&amp;&gt;"), HasSubstr("3 accepted, 1 rejected"),
                          HasSubstr("fits badly"), HasSubstr("under strain")));
}

TEST(Report, HidesTheLayersThatAreSwitchedOff) {
  Site site = corridor(20);
  site.constraints = {closure(0, 4, 1), closure(3, 8, 0, false)};
  const std::string html = report_of(site);
  EXPECT_THAT(html, HasSubstr("class=\"layer line before hide\""));
  EXPECT_THAT(html, HasSubstr("class=\"layer closure rejected hide\""));
  EXPECT_THAT(html, HasSubstr("class=\"layer closure good\""));
  EXPECT_THAT(html, HasSubstr("data-layer=\"before\">"));
  EXPECT_THAT(html, HasSubstr("data-layer=\"after\" checked>"));
}

TEST(Report, GivesTheSameBytesEachTime) {
  const Site site = corridor(30);
  EXPECT_EQ(report_of(site), report_of(site));
}

TEST(Report, ManagesWithLittle) {
  for (const int scans : {0, 1, 2}) {
    Site site = corridor(scans);
    for (PosedScan& p : site.scans) {
      p.T_odom_robot.reset();
      p.estimate.covariance.setZero();
    }
    const std::string html = report_of(site);
    expect_well_formed(html);
    EXPECT_THAT(html, Not(HasSubstr("nan")));
  }
}

TEST(Report, ManagesWithNumbersThatAreNone) {
  Site site = corridor(6);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  site.scans[2].estimate.T_map_robot = {nan, 0, 0};
  site.scans[3].estimate.covariance.setConstant(nan);
  site.constraints = {closure(2, 5, nan)};
  const std::string html = report_of(site);
  expect_well_formed(html);
  EXPECT_THAT(html, Not(HasSubstr("nan ")));
}

TEST(Report, StaysSmallForALongRun) {
  Site site;
  for (int i = 0; i < 20'000; ++i) {
    PosedScan p;
    p.scan.time = i * kSecond / 10;
    p.estimate.T_map_robot = {20 * std::sin(i * 1e-3), 15 * std::sin(i * 1.37e-3), 0};
    p.T_map_robot_front_end = p.T_odom_robot.emplace(p.estimate.T_map_robot);
    p.estimate.health = i % 2 ? Health::ok : Health::degraded;  // flickers
    site.scans.push_back(p);
  }
  for (std::size_t i = 1; i < 5000; ++i) site.constraints.push_back(closure(i, 4 * i, 1));
  EXPECT_LT(report_of(site).size(), 2'000'000U);
}

}  // namespace
}  // namespace majak::draw
