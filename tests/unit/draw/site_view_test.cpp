// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/site_view.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "majak/io/mcap_reader.hpp"
#include "majak/io/ros_wire.hpp"
#include "majak/io/view_records.hpp"
#include "majak/map/edits.hpp"

namespace majak::draw {
namespace {

using ::testing::ElementsAre;

/// Five scans a metre apart, every other a key scan; the last closes a loop with the first.
std::shared_ptr<Site> five_scans() {
  auto site = std::make_shared<Site>();
  site->source_name = "five <1>.log";
  for (int i = 0; i < 5; ++i) {
    PosedScan p;
    p.scan.time = 100 * kSecond + i * kSecond;
    p.scan.angle_step = 0.1;
    p.scan.max_range = 8;
    p.scan.ranges = {static_cast<float>(i + 1)};
    p.scan.T_robot_laser = {i == 3 ? 0.5 : 0.25, 0, 0};
    p.estimate.T_map_robot = {1.0 + i, 0, 0};
    p.T_map_robot_front_end = {2.0 * i, 3, 0};
    p.T_odom_robot = Pose2{0, 1.5 * i, kPi / 2};
    p.key = i % 2 == 0;
    site->scans.push_back(p);
  }
  Constraint c;
  c.kind = ConstraintKind::closure;
  c.from = 0, c.to = 4, c.T_from_to = {4, 0, 0}, c.score = 0.875;
  site->constraints = {c};
  return site;
}

struct Told {
  std::vector<std::string> topics, scans;
  nlohmann::json run, closures, edits;
  std::vector<double> truth;
};

Told told(const SiteView& view) {
  io::McapReader reader(
      io::open_bytes_in_memory(view_stream(view, map::OccupancyGrid(0.05))).bytes);
  Told all;
  io::Message m;
  while (reader.next(m)) {
    const std::string& topic = reader.topics()[m.topic].name;
    all.topics.push_back(topic);
    if (topic == "/run") all.run = nlohmann::json::parse(m.data);
    if (topic == "/closures") all.closures = nlohmann::json::parse(m.data);
    if (topic == "/edits") all.edits = nlohmann::json::parse(m.data);
    if (topic == "/truth") {
      io::ros::Reader wire(m.data, io::ros::Encoding::cdr);
      std::vector<std::int64_t> stamps;
      wire(stamps), wire(all.truth);
    }
    if (topic == "/scan") {
      io::ros::LaserScan scan;
      io::ros::decode(m.data, io::ros::Encoding::cdr, scan);
      all.scans.push_back(scan.header.frame + ":" +
                          std::to_string(static_cast<int>(scan.ranges[0])));
    }
  }
  return all;
}

TEST(SiteView, TellsEstimatesThenKeyScansThenTheOthers) {
  const Told all = told(SiteView(five_scans(), {}));
  EXPECT_THAT(all.topics, ElementsAre("/run", "/map", "/estimate", "/estimate", "/estimate",
                                      "/estimate", "/estimate", "/graph", "/closures", "/edits",
                                      "/scan", "/scan", "/scan", "/scan", "/scan"));
  EXPECT_THAT(all.scans, ElementsAre("laser0:1", "laser0:3", "laser0:5", "laser0:2", "laser1:4"));
  EXPECT_EQ(all.run["name"], "five <1>.log");
  EXPECT_EQ(all.run["scans"], 5);
  EXPECT_EQ(all.run["begin"], "100000000000");
  EXPECT_EQ(all.run["lasers"][1]["pose"], (nlohmann::json{0.5, 0.0, 0.0}));
}

TEST(SiteView, LeavesOutWhatIsBetweenKeyScansWhereTold) {
  const Told all = told(SiteView(five_scans(), {.keys_only = true}));
  EXPECT_EQ(std::count(all.topics.begin(), all.topics.end(), "/estimate"), 3);
  EXPECT_THAT(all.scans, ElementsAre("laser0:1", "laser0:3", "laser0:5"));
}

TEST(SiteView, LaysOdometryAndFrontEndOntoTheFirstPose) {
  const SiteView view(five_scans(), {});
  io::McapReader reader(io::open_bytes_in_memory(io::view_head() + view.estimates()).bytes);
  io::Message m;
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(reader.next(m));
  io::ros::Reader wire(m.data, io::ros::Encoding::cdr);
  Time stamp = 0;
  std::uint32_t scan = 0, key = 0, particles = 0;
  std::uint8_t health = 0, is_key = 0;
  float score = 0, milliseconds = 0;
  std::array<double, 3> pose{}, odometry{}, front_end{};
  std::array<float, 6> covariance{};
  wire.stamp(stamp), wire(scan), wire(key), wire(health), wire(is_key), wire(score);
  wire(milliseconds), wire(particles), wire(pose), wire(covariance), wire(odometry);
  wire(front_end);
  EXPECT_EQ(key, 2U);
  EXPECT_NEAR(odometry[0], 1 + 3, 1e-12);  // 1.5 m a scan ahead
  EXPECT_NEAR(odometry[1], 0, 1e-12);
  EXPECT_THAT(front_end, ElementsAre(5, 0, 0));
}

TEST(SiteView, AClosuresEffectIsWhatItMovedTheFrontEndsPoses) {
  const Told all = told(SiteView(five_scans(), {}));
  ASSERT_EQ(all.closures.size(), 1U);
  EXPECT_EQ(all.closures[0]["effect_m"], 4);  // 8 m by the front end, 4 m as measured
  EXPECT_EQ(all.closures[0]["score"], 0.875);
  EXPECT_EQ(all.closures[0]["enabled"], true);
}

TEST(SiteView, TellsEditsWhereTheyLieInTheMap) {
  auto site = five_scans();
  const std::vector<Vec2> wall{{1, 2}, {3, 2}};
  map::add_edit(*site, map::anchored(*site, EditKind::wall, wall));
  Edit off;
  off.kind = EditKind::closure_off;
  off.to = 4;
  map::add_edit(*site, off);
  const Told all = told(SiteView(site, {}));
  EXPECT_EQ(all.closures[0]["by_hand"], true);
  ASSERT_EQ(all.edits["edits"].size(), 2U);
  EXPECT_EQ(all.edits["edits"][0]["kind"], "wall");
  EXPECT_NEAR(all.edits["edits"][0]["points"][1][0].get<double>(), 3, 1e-12);
  EXPECT_EQ(all.edits["edits"][1]["to"], 4);
  EXPECT_EQ(all.edits["can_undo"], true);
  EXPECT_EQ(all.edits["can_redo"], false);
}

TEST(SiteView, LaysTheTruthOntoTheMap) {
  auto site = five_scans();
  for (const PosedScan& p : site->scans) {
    const double x = p.estimate.T_map_robot.x;
    site->truth.push_back({p.scan.time, Pose2{10, x, kPi / 2}});
  }
  const Told all = told(SiteView(site, {}));
  ASSERT_EQ(all.truth.size(), 15U);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(all.truth[3 * i], 1.0 + static_cast<double>(i), 1e-9);
    EXPECT_NEAR(all.truth[3 * i + 1], 0, 1e-9);
    EXPECT_NEAR(all.truth[3 * i + 2], 0, 1e-9);
  }
}

}  // namespace
}  // namespace majak::draw
