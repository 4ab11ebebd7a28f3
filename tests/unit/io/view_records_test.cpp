// SPDX-License-Identifier: Apache-2.0
// The viewer's stream is MCAP: what other programs read of recordings they read of it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "majak/io/mcap_reader.hpp"
#include "majak/io/ros_wire.hpp"
#include "majak/io/view_records.hpp"
#include "ros_fixtures.hpp"

namespace majak::io {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;

struct Read {
  std::string topic, data;
  Time time = 0;
};

std::vector<Read> read(const std::string& records) {
  McapReader reader(open_bytes_in_memory(view_head() + records).bytes);
  std::vector<Read> all;
  Message m;
  while (reader.next(m))
    all.push_back({reader.topics()[m.topic].name, std::string(m.data), m.time});
  return all;
}

Read read_one(const std::string& record) {
  const auto all = read(record);
  EXPECT_EQ(all.size(), 1U);
  return all.empty() ? Read{} : all[0];
}

Scan three_beams() {
  Scan scan;
  scan.time = 12 * kSecond + 34;
  scan.start_angle = -kPi / 2;
  scan.angle_step = kPi / 2;
  scan.max_range = 80;
  scan.ranges = {1.25F, kNoReturn, kInvalidRange};
  return scan;
}

TEST(ViewHead, NamesEveryTopicOnce) {
  McapReader reader(open_bytes_in_memory(view_head()).bytes);
  Message none;
  EXPECT_FALSE(reader.next(none));
  std::vector<std::string> names;
  for (const auto& topic : reader.topics()) names.push_back(topic.name);
  EXPECT_THAT(names, ElementsAre("/scan", "/estimate", "/key_poses", "/map", "/graph", "/truth",
                                 "/segments", "/particles", "/hypotheses", "/landmarks", "/run",
                                 "/closures", "/edits", "/status"));
}

TEST(ViewScan, IsTheLaserScanOfRecordings) {
  const Read got = read_one(view_scan(7, three_beams(), 2));
  EXPECT_EQ(got.topic, "/scan");
  EXPECT_EQ(got.time, three_beams().time);
  ros::LaserScan scan;
  ros::decode(got.data, ros::Encoding::cdr, scan);
  EXPECT_EQ(scan.header.frame, "laser2");
  EXPECT_EQ(scan.header.stamp, three_beams().time);
  ASSERT_EQ(scan.ranges.size(), 3U);
  EXPECT_EQ(scan.ranges[0], 1.25F);
  EXPECT_TRUE(std::isinf(scan.ranges[1]));
  EXPECT_TRUE(std::isnan(scan.ranges[2]));
}

TEST(ViewScan, StampsThatRosCannotWriteAreTheNearest) {
  Scan scan = three_beams();
  scan.time = -5;
  EXPECT_EQ(read_one(view_scan(0, scan, 0)).time, 0);
  scan.time = std::numeric_limits<Time>::max();
  EXPECT_EQ(read_one(view_scan(0, scan, 0)).time, Time{0x7fffffff} * kSecond);
}

TEST(ViewEstimate, HoldsWhatItsDefinitionSays) {
  ViewedPose pose;
  pose.scan = 9;
  pose.key = 8;
  pose.estimate.time = 3 * kSecond + 5;
  pose.estimate.T_map_robot = {1, 2, 3};
  pose.estimate.covariance << 1, 2, 3, 2, 4, 5, 3, 5, 6;
  pose.estimate.health = Health::lost;
  pose.match_score = 0.5F;
  pose.particles = 60;
  pose.T_map_front_end = Pose2{7, 8, 0.5};
  const Read got = read_one(view_estimate(pose));
  EXPECT_EQ(got.topic, "/estimate");

  ros::Reader wire(got.data, ros::Encoding::cdr);
  Time stamp = 0;
  std::uint32_t scan = 0, key = 0, particles = 0;
  std::uint8_t health = 0, is_key = 1;
  float score = 0, milliseconds = 0;
  std::array<double, 3> map{}, odometry{}, front_end{};
  std::array<float, 6> covariance{};
  wire.stamp(stamp);
  wire(scan), wire(key), wire(health), wire(is_key), wire(score), wire(milliseconds);
  wire(particles), wire(map), wire(covariance), wire(odometry), wire(front_end);
  EXPECT_EQ(stamp, pose.estimate.time);
  EXPECT_THAT((std::array{scan, key, particles}), ElementsAre(9, 8, 60));
  EXPECT_EQ(health, 2);
  EXPECT_EQ(is_key, 0);
  EXPECT_EQ(score, 0.5F);
  EXPECT_TRUE(std::isnan(milliseconds));
  EXPECT_THAT(map, ElementsAre(1, 2, 3));
  EXPECT_THAT(covariance, ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_THAT(odometry, Each(::testing::IsNan()));
  EXPECT_THAT(front_end, ElementsAre(7, 8, 0.5));
}

TEST(ViewMap, HasPercentFromTheLowestRowOn) {
  map::OccupancyGrid grid(0.5);
  grid.set_log_odds(-1, 2, 4);
  grid.set_log_odds(1, 3, -4);
  const Read got = read_one(view_map(grid));
  ros::Reader wire(got.data, ros::Encoding::cdr);
  Time stamp = 1;
  std::string frame;
  float resolution = 0;
  std::uint32_t width = 0, height = 0;
  std::array<double, 3> origin{};
  std::array<double, 4> turn{};
  std::vector<std::int8_t> cells;
  wire.stamp(stamp), wire(frame), wire.stamp(stamp), wire(resolution), wire(width), wire(height);
  wire(origin), wire(turn), wire(cells);
  EXPECT_EQ(frame, "map");
  EXPECT_EQ(resolution, 0.5F);
  EXPECT_THAT((std::array{width, height}), ElementsAre(3, 2));
  EXPECT_THAT(origin, ElementsAre(-0.5, 1, 0));
  EXPECT_THAT(turn, ElementsAre(0, 0, 0, 1));
  EXPECT_THAT(cells, ElementsAre(98, -1, -1, -1, -1, 2));
}

TEST(ViewRecords, ListsKeepTheirOrder) {
  Site site;
  site.scans.resize(2);
  Constraint c;
  c.kind = ConstraintKind::closure;
  c.from = 0, c.to = 1, c.chi2 = 2.5, c.enabled = false;
  site.constraints = {c};
  const std::vector<std::size_t> scans{4, 6};
  const std::vector<Pose2> poses{{1, 2, 0.5}, {3, 4, -0.5}};
  const std::vector<float> weights{0.25F, 0.75F};
  const auto all =
      read(view_graph(site) + view_key_poses(scans, poses) + view_truth({{10, 20}, poses}) +
           view_segments({1, 2, 3, 4}) + view_particles(kSecond, poses, weights) +
           view_json(ViewTopic::status, "{}"));
  ASSERT_EQ(all.size(), 6U);
  const auto wire = [&](std::size_t i) { return ros::Reader(all[i].data, ros::Encoding::cdr); };
  std::vector<std::uint32_t> from, to, keys;
  std::vector<std::uint8_t> kind, enabled;
  std::vector<float> chi2, ends, floats;
  std::vector<double> doubles;
  std::vector<std::int64_t> stamps;
  Time time = 0;
  auto graph = wire(0);
  graph(from), graph(to), graph(kind), graph(enabled), graph(chi2);
  EXPECT_THAT(from, ElementsAre(0));
  EXPECT_THAT(to, ElementsAre(1));
  EXPECT_THAT(kind, ElementsAre(2));
  EXPECT_THAT(enabled, ElementsAre(0));
  EXPECT_THAT(chi2, ElementsAre(2.5F));
  auto key_poses = wire(1);
  key_poses(keys), key_poses(doubles);
  EXPECT_THAT(keys, ElementsAre(4, 6));
  EXPECT_THAT(doubles, ElementsAre(1, 2, 0.5, 3, 4, -0.5));
  auto truth = wire(2);
  truth(stamps), truth(doubles);
  EXPECT_THAT(stamps, ElementsAre(10, 20));
  EXPECT_THAT(doubles, ElementsAre(1, 2, 0.5, 3, 4, -0.5));
  auto segments = wire(3);
  segments(ends);
  EXPECT_THAT(ends, ElementsAre(1, 2, 3, 4));
  auto particles = wire(4);
  particles.stamp(time), particles(floats);
  EXPECT_EQ(time, kSecond);
  EXPECT_THAT(floats, ElementsAre(1, 2, 0.5F, 3, 4, -0.5F));
  particles(floats);
  EXPECT_THAT(floats, ElementsAre(0.25F, 0.75F));
  EXPECT_EQ(all[5].topic, "/status");
  EXPECT_EQ(all[5].data, "{}");
}

}  // namespace
}  // namespace majak::io
