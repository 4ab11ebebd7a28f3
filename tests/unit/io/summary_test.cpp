// SPDX-License-Identifier: Apache-2.0
#include "majak/io/summary.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

namespace majak::io {
namespace {

using Json = nlohmann::json;

/// A square of 10 m sides, one scan a metre, every fifth one a key scan.
Site square() {
  Site site;
  site.source_name = "square.clf";
  for (int i = 0; i <= 40; ++i) {
    PosedScan p;
    p.scan.time = (100 - i) * kSecond;  // backwards: the duration does not depend on the order
    const int side = std::min(i / 10, 3), along = i - 10 * side;
    const double at = along;
    p.estimate.T_map_robot = side == 0   ? Pose2{at, 0, 0}
                             : side == 1 ? Pose2{10, at, kPi / 2}
                             : side == 2 ? Pose2{10 - at, 10, kPi}
                                         : Pose2{0, 10 - at, -kPi / 2};
    p.T_map_robot_front_end = p.estimate.T_map_robot * Pose2{i == 20 ? 0.5 : 0.1, 0, 0};
    p.estimate.covariance = Mat3::Identity() * 1e-4 * i * i;
    p.estimate.health = i == 3 ? Health::lost : i < 6 ? Health::degraded : Health::ok;
    p.key = i % 5 == 0;
    p.match_score = 0.5F;
    site.scans.push_back(p);
  }
  Constraint c;
  for (const bool enabled : {true, true, false}) {
    c.kind = ConstraintKind::closure;
    c.enabled = enabled;
    site.constraints.push_back(c);
  }
  c.kind = ConstraintKind::match;
  site.constraints.push_back(c);
  site.report.count("truncated line", 12);
  site.report.count("truncated line", 15);
  return site;
}

map::OccupancyGrid two_cells() {
  map::OccupancyGrid grid(0.5);
  grid.set_log_odds(0, 0, 1);
  grid.set_log_odds(5, 3, -1);
  return grid;
}

TEST(Figures, CountAndMeasure) {
  const Figures f = figures_of(square(), two_cells());
  EXPECT_EQ(f.scans, 41U);
  EXPECT_EQ(f.key_scans, 9U);
  EXPECT_EQ(f.lost, 1U);
  EXPECT_EQ(f.degraded, 5U);
  EXPECT_EQ(f.ok, 35U);
  EXPECT_EQ(f.closures, 2U);
  EXPECT_EQ(f.closures_rejected, 1U);
  EXPECT_EQ(f.matches, 1U);
  EXPECT_DOUBLE_EQ(f.duration_s, 40);
  EXPECT_DOUBLE_EQ(f.path_m, 40);
  EXPECT_NEAR(f.turned_rad, 3 * kPi / 2, 1e-12);
  EXPECT_NEAR(f.front_end_shift_max_m, 0.5, 1e-12);
  EXPECT_NEAR(f.position_sigma_median_m, 0.20, 1e-12);
  EXPECT_NEAR(f.position_sigma_max_m, 0.40, 1e-12);
  EXPECT_NEAR(f.match_score_mean, 0.5, 1e-12);
  EXPECT_DOUBLE_EQ(f.width_m, 3);
  EXPECT_DOUBLE_EQ(f.height_m, 2);
  EXPECT_DOUBLE_EQ(f.known_area_m2, 0.5);
  EXPECT_EQ(f.skipped, 2);
}

TEST(Figures, OfAnEmptySiteAreZero) {
  const Figures f = figures_of({}, map::OccupancyGrid(0.05));
  EXPECT_EQ(f.scans, 0U);
  EXPECT_EQ(f.path_m, 0);
  EXPECT_EQ(f.match_score_mean, 0);
}

TEST(Figures, MeasureThePathWithoutKeyScansToo) {
  Site site = square();
  for (PosedScan& p : site.scans) p.key = false;
  EXPECT_DOUBLE_EQ(figures_of(site, two_cells()).path_m, 40);
}

TEST(SummaryJson, CountsSlipsAndListsTheFirstTwenty) {
  EXPECT_EQ(Json::parse(summary_json(square(), two_cells()))["slips"]["count"], 0);
  std::vector<motion::SlipEvent> slips(
      23, {2 * kSecond, 3 * kSecond, motion::SlipKind::push, 0.25, radians(10)});
  slips[1].kind = motion::SlipKind::jump;
  const Json json = Json::parse(summary_json(square(), two_cells(), {}, {}, slips))["slips"];
  EXPECT_EQ(json["count"], 23);
  ASSERT_EQ(json["biggest"].size(), 20U);
  const Json& first = json["biggest"][0];
  EXPECT_EQ(first["kind"], "push");
  EXPECT_EQ(json["biggest"][1]["kind"], "jump");
  EXPECT_EQ(first["begin_s"], 2);
  EXPECT_EQ(first["end_s"], 3);
  EXPECT_EQ(first["way_m"], 0.25);
  EXPECT_DOUBLE_EQ(first["turn_deg"], 10);
}

TEST(SummaryJson, HoldsFiguresFindingsAndWhatWasSkipped) {
  Site site = square();
  site.used_odometry = true;
  site.odometry.lag_s = {0.1, 0.01, true};
  site.odometry.reversed_records = 320;
  site.odometry.jumps = 2;
  const Json json = Json::parse(summary_json(site, two_cells(), {{"ate_m", 0.25}}));
  EXPECT_EQ(json["log"], "square.clf");
  EXPECT_EQ(json["scans"], 41);
  EXPECT_EQ(json["closures"], 2);
  EXPECT_DOUBLE_EQ(json["path_m"], 40);
  EXPECT_EQ(json["odometry"]["used"], true);
  EXPECT_EQ(json["odometry"]["lag_s"]["value"], 0.1);
  EXPECT_EQ(json["odometry"]["lag_s"]["used"], true);
  EXPECT_EQ(json["odometry"]["reversed_records"], 320);
  EXPECT_EQ(json["odometry"]["jumps"], 2);
  EXPECT_EQ(json["skipped"][0]["what"], "truncated line");
  EXPECT_EQ(json["skipped"][0]["count"], 2);
  EXPECT_EQ(json["skipped"][0]["first_line"], 12);
  EXPECT_EQ(json["evaluation"]["ate_m"], 0.25);
  EXPECT_FALSE(json.contains("timing")) << "or equal runs would differ";
}

TEST(SummaryJson, PutsTimingApart) {
  const Json json = Json::parse(summary_json(square(), two_cells(), {}, {{"total_cpu_s", 1.5}}));
  EXPECT_EQ(json["timing"]["total_cpu_s"], 1.5);
}

TEST(SummaryJson, StaysJsonWithNumbersThatAreNoneAndNamesThatAreNoUtf8) {
  Site site = square();
  site.source_name = "caf\xe9\n\".clf";
  site.odometry.lag_s.sigma = std::numeric_limits<double>::quiet_NaN();
  const Json json = Json::parse(summary_json(site, two_cells()));
  EXPECT_TRUE(json["odometry"]["lag_s"]["sigma"].is_null());
  EXPECT_EQ(json["scans"], 41);
}

TEST(Summary, ListsTheEditsWhereTheyLie) {
  Site site = square();
  Edit wall, turn, off;
  wall.id = 1, wall.kind = EditKind::wall, wall.points = {{0, {1, 2}}, {10, {1, 0}}};
  turn.id = 4, turn.kind = EditKind::turn, turn.radians = 0.25;
  off.id = 5, off.kind = EditKind::closure_off, off.from = 3, off.to = 9;
  site.edits = {wall, turn, off};
  const Json edits = Json::parse(summary_json(site, two_cells()))["edits"];
  ASSERT_EQ(edits.size(), 3U);
  EXPECT_EQ(edits[0]["kind"], "wall");
  EXPECT_EQ(edits[0]["points"][0], (Json{1.0, 2.0}));
  EXPECT_NEAR(edits[0]["points"][1][1].get<double>(), 1, 1e-12);
  EXPECT_EQ(edits[1], (Json{{"id", 4}, {"kind", "turn"}, {"radians", 0.25}}));
  EXPECT_EQ(edits[2], (Json{{"id", 5}, {"kind", "closure_off"}, {"from", 3}, {"to", 9}}));
}

}  // namespace
}  // namespace majak::io
