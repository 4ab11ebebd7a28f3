// SPDX-License-Identifier: Apache-2.0
// ROS recordings as events: which topics, which frames, which order; and the bags of the data
// folder.
#include "majak/io/ros_source.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <fstream>
#include <sstream>

#include "majak/core/error.hpp"
#include "majak/io/mcap_writer.hpp"
#include "majak/io/ros1_bag.hpp"
#include "ros_fixtures.hpp"

namespace majak::io {
namespace {

namespace fs = std::filesystem;
using testing::Read;

/// A recording in the memory, as any of the three files.
struct Recording {
  struct Entry {
    std::string topic, type;  ///< type as ROS 1 writes it
    Time time;
    std::function<std::string(ros::Encoding)> bytes;
  };
  std::vector<Entry> entries;

  template <class M>
  void add(std::string topic, std::string type, Time time, const M& message) {
    entries.push_back({std::move(topic), std::move(type), time,
                       [message](ros::Encoding e) { return ros::encode(message, e); }});
  }
  void scan(Time stamp, std::string topic = "/scan", std::string frame = "laser") {
    ros::LaserScan m;
    m.header = {0, stamp, std::move(frame)};
    m.angle_min = -1, m.angle_max = 1, m.angle_increment = 1, m.range_max = 10;
    m.ranges = {1, 2, 3};
    add(std::move(topic), "sensor_msgs/LaserScan", stamp, m);
  }
  void odometry(Time stamp, const Pose2& pose, double speed = 0.5, std::string topic = "/odom") {
    ros::Odometry m;
    m.header = {0, stamp, "odom"};
    m.child_frame = "base_link";
    m.pose = in_space(pose);
    m.linear[0] = speed;
    add(std::move(topic), "nav_msgs/Odometry", stamp, m);
  }
  void tf(Time stamp, std::string parent, std::string child, const ros::Transform& t,
          std::string topic = "/tf") {
    add(std::move(topic), "tf2_msgs/TFMessage", stamp,
        ros::TransformList{{{{0, stamp, std::move(parent)}, std::move(child), t}}});
  }
  void fix(Time stamp, double latitude, double longitude, int status = 0) {
    ros::NavSatFix m;
    m.header.stamp = stamp;
    m.status = static_cast<std::int8_t>(status);
    m.latitude = latitude, m.longitude = longitude;
    add("/fix", "sensor_msgs/NavSatFix", stamp, m);
  }

  static ros::Transform in_space(const Pose2& pose) {
    return {{pose.x, pose.y, 0}, {0, 0, std::sin(pose.theta / 2), std::cos(pose.theta / 2)}};
  }

  std::string bag() const {
    testing::BagBuilder bag;
    std::map<std::string, std::uint32_t> known;
    std::string records;
    for (const Entry& e : entries) {
      const auto [id, is_new] = known.emplace(e.topic, static_cast<std::uint32_t>(known.size()));
      if (is_new) records += bag.connection(id->second, e.topic, e.type);
      records += bag.message(id->second, e.time, e.bytes(ros::Encoding::ros1));
    }
    return bag.bytes + bag.chunk("lz4", records);
  }
  static std::string type2(const std::string& type) {
    const auto slash = type.find('/');
    return type.substr(0, slash) + "/msg" + type.substr(slash);
  }
  std::string mcap() const {
    std::string bytes;
    McapWriter writer([&](std::string_view more) { bytes += more; });
    std::map<std::string, std::uint16_t> known;
    for (const Entry& e : entries) {
      if (!known.contains(e.topic))
        known[e.topic] = writer.add_channel({e.topic, "cdr", type2(e.type), "ros2msg"});
      writer.write(known[e.topic], e.time, e.time, e.bytes(ros::Encoding::cdr));
    }
    writer.close();
    return bytes;
  }
  void sqlite(const fs::path& path, bool packed = false) const {
    fs::remove(path);
    sqlite3* raw = nullptr;
    sqlite3_open(path.c_str(), &raw);
    sqlite3_exec(raw,
                 "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, "
                 "serialization_format TEXT, offered_qos_profiles TEXT);"
                 "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, "
                 "timestamp INTEGER, data BLOB); BEGIN;",
                 nullptr, nullptr, nullptr);
    const auto run = [&](const std::string& sql, std::string_view blob) {
      sqlite3_stmt* statement = nullptr;
      sqlite3_prepare_v2(raw, sql.c_str(), -1, &statement, nullptr);
      sqlite3_bind_blob64(statement, 1, blob.data(), blob.size(), SQLITE_TRANSIENT);
      EXPECT_EQ(sqlite3_step(statement), SQLITE_DONE) << sqlite3_errmsg(raw);
      sqlite3_finalize(statement);
    };
    std::map<std::string, std::size_t> known;
    for (const Entry& e : entries) {
      const auto [id, is_new] = known.emplace(e.topic, known.size() + 3);
      const std::string number = std::to_string(id->second);
      if (is_new)
        run("INSERT INTO topics VALUES(" + number + ",'" + e.topic + "','" + type2(e.type) +
                "','cdr','')",
            "");
      const std::string data = e.bytes(ros::Encoding::cdr);
      run("INSERT INTO messages(topic_id,timestamp,data) VALUES(" + number + "," +
              std::to_string(e.time) + ",?)",
          packed ? pack(ChunkPacking::zstd, data) : data);
    }
    sqlite3_exec(raw, "COMMIT", nullptr, nullptr, nullptr);
    sqlite3_close(raw);
  }
};

OpenMessages from_bag(std::string bytes) {
  return [bytes](Depth depth) {
    return std::make_unique<Ros1Bag>(open_bytes_in_memory(bytes).bytes, depth);
  };
}
Read read(const Recording& recording, const SourceOptions& options = {}) {
  RosSource source(from_bag(recording.bag()), "bag", options);
  return testing::read_all(source);
}
std::string error_of(const Recording& recording, const SourceOptions& options = {}) {
  try {
    read(recording, options);
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

constexpr Time s(double seconds) { return static_cast<Time>(seconds * 1e9); }

/// A robot whose laser sits 0.2 m ahead, with everything.
Recording usual() {
  Recording r;
  r.tf(s(1), "base_link", "laser", Recording::in_space({0.2, 0, 0}), "/tf_static");
  for (int i = 0; i < 5; ++i) {
    r.odometry(s(1 + i), {0.1 * i, 0, 0.25});
    r.scan(s(1.5 + i));
    r.fix(s(1.75 + i), 47, 8 + 0.001 * i);
  }
  return r;
}

TEST(RosSource, GivesEveryEventInTheOrderOfTheStamps) {
  const Read r = read(usual());
  ASSERT_EQ(r.events.size(), 15U);
  for (std::size_t i = 1; i < r.events.size(); ++i)
    EXPECT_LE(time_of(r.events[i - 1]), time_of(r.events[i]));
  const auto scans = r.all<Scan>();
  EXPECT_EQ(scans[0].T_robot_laser, (Pose2{0.2, 0, 0}));
  EXPECT_EQ(scans[0].ranges, (std::vector<float>{1, 2, 3}));
  EXPECT_EQ(scans[0].time, s(1.5));
  const auto odometry = r.all<Odometry>();
  EXPECT_NEAR(odometry[3].T_odom_robot.theta, 0.25, 1e-15);
  EXPECT_EQ(odometry[3].T_odom_robot.x, 0.1 * 3);
  EXPECT_EQ(odometry[3].speed, 0.5);
  EXPECT_EQ(odometry[3].turn_rate, 0.0);
  const auto fixes = r.all<GpsFix>();
  EXPECT_EQ(fixes[0].east, 0);
  EXPECT_NEAR(fixes[1].east, 76.06, 0.01);  // a thousandth of a degree at 47 degrees north
  EXPECT_NEAR(fixes[1].north, 0, 0.001);
  EXPECT_TRUE(r.report.empty());
}

// Unless the map is turned or not on the Earth: then the first fix is the origin, as ever.
TEST(RosSource, FixesAreInTheFrameThatTfPlacesOnTheEarth) {
  const beacon::LocalFrame map({47.001, 8.002, 300});
  const auto first_fix = [&](const Mat3& turn, double factor) {
    const Eigen::Quaterniond q(Mat3(map.axes() * turn));
    const Vec3 p = factor * map.origin();
    Recording r;
    r.tf(s(1), "earth", "map", {{p.x(), p.y(), p.z()}, {q.x(), q.y(), q.z(), q.w()}});
    Recording all = usual();
    for (const auto& e : all.entries) r.entries.push_back(e);
    r.fix(s(20), 47, 8.01);
    return read(r).all<GpsFix>().back();
  };
  const Vec2 there = map.east_north({47, 8.01, 0});
  const GpsFix level = first_fix(Mat3::Identity(), 1);
  EXPECT_NEAR(level.east, there.x(), 1e-6);
  EXPECT_NEAR(level.north, there.y(), 1e-6);
  const Vec2 from_first = beacon::LocalFrame({47, 8, 0}).east_north({47, 8.01, 0});
  const Mat3 turn = Eigen::AngleAxisd(0.1, Vec3::UnitZ()).toRotationMatrix();
  for (const GpsFix& fix : {first_fix(turn, 1), first_fix(Mat3::Identity(), 0)}) {
    EXPECT_NEAR(fix.east, from_first.x(), 1e-6);
    EXPECT_NEAR(fix.north, from_first.y(), 1e-6);
  }
}

TEST(RosSource, LateMessagesAreSorted) {
  Recording r;
  for (int i = 0; i < 20; ++i) {
    r.scan(s(i + 1));
    r.odometry(s(i + 0.7), {0.1 * i, 0, 0});  // arrives after the scan that it precedes
  }
  const Read read_back = read(r);
  EXPECT_EQ(read_back.noticed("backwards"), 0);
  for (std::size_t i = 1; i < read_back.events.size(); ++i)
    EXPECT_LE(time_of(read_back.events[i - 1]), time_of(read_back.events[i]));
  r.scan(s(2));
  EXPECT_EQ(read(r).noticed("scan stamps that run backwards"), 1);
}

TEST(RosSource, OdometryComesFromTfWhereItHasNoTopic) {
  Recording r;
  r.tf(0, "base_link", "laser", Recording::in_space({0.2, 0, 0}));
  r.tf(0, "base_footprint", "base_link", Recording::in_space({1, 0, 0}));
  for (int i = 1; i < 5; ++i) {
    r.tf(s(i), "odom", "base_footprint", Recording::in_space({0.1 * i, 0, kPi / 2}));
    r.tf(s(i), "map", "odom", Recording::in_space({9, 9, 9}));
    r.scan(s(i + 0.5));
  }
  // The frame below the odometry's is the robot's.
  const Read of_tf = read(r);
  const auto odometry = of_tf.all<Odometry>();
  ASSERT_EQ(odometry.size(), 4U);
  EXPECT_EQ(odometry[1].time, s(2));
  EXPECT_EQ(odometry[1].T_odom_robot.x, 0.1 * 2);
  EXPECT_NEAR(odometry[1].T_odom_robot.theta, kPi / 2, 1e-15);
  EXPECT_FALSE(odometry[1].speed);
  EXPECT_NEAR(of_tf.all<Scan>()[0].T_robot_laser.x, 1.2, 1e-12);
  // With a topic of its own, tf's is the same again.
  r.odometry(s(1), {});
  EXPECT_EQ(read(r).all<Odometry>().size(), 1U);
}

TEST(RosSource, TheMountingFollowsTfAndIsKnownFromTheStart) {
  Recording r;
  r.odometry(s(0), {});
  r.scan(s(1));
  r.tf(s(2), "base_link", "laser", Recording::in_space({0.1, 0, 0}));
  r.scan(s(3));
  r.tf(s(4), "base_link", "laser", Recording::in_space({0.2, 0, 0}));
  r.scan(s(5));
  const auto scans = read(r).all<Scan>();
  ASSERT_EQ(scans.size(), 3U);
  EXPECT_EQ(scans[0].T_robot_laser.x, 0.1);
  EXPECT_EQ(scans[1].T_robot_laser.x, 0.1);
  EXPECT_EQ(scans[2].T_robot_laser.x, 0.2);
  const auto told = read(r, {.topic = "", .angle_step = 0, .T_robot_laser = Pose2{7, 8, 0.5}});
  for (const Scan& scan : told.all<Scan>()) EXPECT_EQ(scan.T_robot_laser, (Pose2{7, 8, 0.5}));
}

TEST(RosSource, ALaserUpsideDownIsMirrored) {
  Recording r;
  r.odometry(0, {});
  r.tf(0, "base_link", "laser", {{0.1, 0, 0}, {1, 0, 0, 0}});  // half a turn about x
  r.scan(s(1));
  const Read mirrored = read(r);
  EXPECT_EQ(mirrored.all<Scan>()[0].ranges, (std::vector<float>{3, 2, 1}));
  EXPECT_EQ(mirrored.noticed("upside down"), 1);
}

TEST(RosSource, AnUnknownMountingIsNoticedOnlyWhereItMatters) {
  Recording r;
  r.scan(s(1));
  EXPECT_TRUE(read(r).report.empty());
  r.odometry(s(1), {});
  EXPECT_EQ(read(r).noticed("--mounting"), 1);
  const SourceOptions told{.topic = "", .angle_step = 0, .T_robot_laser = Pose2{}};
  EXPECT_TRUE(read(r, told).report.empty());
}

TEST(RosSource, OneLaserIsChosenAndSeveralAreAsked) {
  Recording r = usual();
  EXPECT_EQ(read(r, {.topic = "/scan"}).all<Scan>().size(), 5U);
  EXPECT_EQ(read(r, {.topic = "scan"}).all<Scan>().size(), 5U);
  EXPECT_THAT(error_of(r, {.topic = "/odom"}), ::testing::HasSubstr("there are /scan"));
  r.scan(s(2), "/rear/scan", "rear");
  const std::string error = error_of(r);
  EXPECT_THAT(error, ::testing::HasSubstr("--topic"));
  EXPECT_THAT(error, ::testing::HasSubstr("/rear/scan, /scan"));
  EXPECT_EQ(error.find('\n'), std::string::npos);
  EXPECT_EQ(read(r, {.topic = "/rear/scan"}).all<Scan>().size(), 1U);
}

TEST(RosSource, TheWheelsAreChosenAmongOdometry) {
  Recording r = usual();
  r.odometry(s(2), {9, 9, 9}, 0, "/odometry/filtered");
  const Read chosen = read(r);
  EXPECT_EQ(chosen.all<Odometry>().size(), 5U);
  EXPECT_EQ(chosen.noticed("/odometry/filtered is left out"), 1);
}

TEST(RosSource, ARecordingWithoutALaserSaysWhatItHas) {
  Recording r;
  r.tf(0, "a", "b", {});
  EXPECT_THAT(error_of(r), ::testing::HasSubstr("/tf (tf2_msgs/TFMessage)"));
  EXPECT_THAT(error_of({}), ::testing::HasSubstr("without messages"));
  r.odometry(0, {});
  EXPECT_EQ(read(r).all<Odometry>().size(), 1U);
}

TEST(RosSource, WhatCannotBeUsedIsCounted) {
  Recording r = usual();
  r.fix(s(9), 1, 2, -1);
  r.fix(s(9), 91, 2);
  r.odometry(s(9), {std::numeric_limits<double>::quiet_NaN(), 0, 0});
  r.entries.push_back(
      {"/scan", "sensor_msgs/LaserScan", s(9), [](ros::Encoding) { return std::string("short"); }});
  r.scan(0);
  r.entries.back().time = s(9.5);
  const Read counted = read(r);
  EXPECT_EQ(counted.noticed("without a fix"), 2);
  EXPECT_EQ(counted.noticed("pose is no number"), 1);
  EXPECT_EQ(counted.noticed("cannot be decoded"), 1);
  EXPECT_EQ(counted.noticed("without a stamp"), 1);
  EXPECT_EQ(counted.all<Scan>().back().time, s(9.5));
}

TEST(RosSource, SpeedsThatAreAlwaysZeroWhileItDrivesSayNothing) {
  Recording r;
  for (int i = 0; i < 5; ++i) r.odometry(s(i), {0.1 * i, 0, 0}, 0);
  EXPECT_FALSE(read(r).all<Odometry>()[0].speed);
}

TEST(RosSource, ClocksThatDisagreeAreReplacedByTheTimesOfRecording) {
  Recording r = usual();
  for (auto& e : r.entries) {
    if (e.topic != "/scan") continue;
    ros::LaserScan m;
    ros::decode(e.bytes(ros::Encoding::cdr), ros::Encoding::cdr, m);
    m.header.stamp += s(1000);  // since its power came on, say
    e.bytes = [m](ros::Encoding encoding) { return ros::encode(m, encoding); };
  }
  const Read mended = read(r);
  EXPECT_EQ(mended.all<Scan>()[0].time, s(1.5));
  EXPECT_EQ(mended.noticed("different clocks"), 15);
}

TEST(RosSource, TheAngleStepIsCheckedAndUsed) {
  EXPECT_NEAR(read(usual(), {.topic = "", .angle_step = 0.5}).all<Scan>()[0].angle_step,
              radians(0.5), 1e-15);
  for (const double step : {-1.0, 31.0, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_THAT(error_of(usual(), {.topic = "", .angle_step = step}),
                ::testing::HasSubstr("--angle-step"));
}

TEST(RosSource, ATruncatedBagGivesTheFirstEvents) {
  const std::string whole = usual().bag();
  std::size_t most = 0;
  for (std::size_t size = 0; size < whole.size(); size += 3) {
    try {
      RosSource source(from_bag(whole.substr(0, size)), "bag", {});
      most = std::max(most, testing::read_all(source).events.size());
    } catch (const Error&) {  // nothing of it is whole yet
    }
  }
  EXPECT_LE(most, 15U);
}

// ---- files and folders --------------------------------------------------------------------------

class RosFiles : public ::testing::Test {
 protected:
  RosFiles()
      : folder_(fs::path(::testing::TempDir()) / ("majak_ros_" + std::to_string(::getpid()))) {
    fs::create_directories(folder_);
  }
  ~RosFiles() override { fs::remove_all(folder_); }

  fs::path file(const std::string& name, const std::string& content) const {
    std::ofstream(folder_ / name, std::ios::binary) << content;
    return folder_ / name;
  }
  static Read read(const fs::path& path, const SourceOptions& options = {}) {
    const auto source = open_log(path, options);
    return testing::read_all(*source);
  }
  static std::string error_of(const fs::path& path) {
    try {
      open_log(path);
    } catch (const Error& e) {
      return e.what();
    }
    return "no error";
  }

  fs::path folder_;
};

/// Text that is equal where events are.
std::string told(const Read& read) {
  std::ostringstream text;
  text.precision(17);
  for (const Event& event : read.events) {
    text << time_of(event) << ' ' << event.index();
    if (const auto* scan = std::get_if<Scan>(&event))
      for (const float range : scan->ranges) text << ' ' << range;
    if (const auto* odometry = std::get_if<Odometry>(&event))
      text << ' ' << odometry->T_odom_robot.x;
    text << '\n';
  }
  return text.str();
}

TEST_F(RosFiles, EveryKindOfRecordingGivesTheSameEvents) {
  const Read expected = read(file("a.log", usual().bag()));
  EXPECT_EQ(expected.events.size(), 15U);
  EXPECT_EQ(open_log(folder_ / "a.log")->format(), "ROS 1 bag");
  EXPECT_EQ(told(read(file("b", testing::gzip(usual().bag())))), told(expected));
  EXPECT_EQ(told(read(file("c.bag", usual().mcap()))), told(expected));
  EXPECT_EQ(open_log(folder_ / "c.bag")->format(), "MCAP recording");
  for (const bool packed : {false, true}) {
    usual().sqlite(folder_ / "d.db3", packed);
    EXPECT_EQ(told(read(folder_ / "d.db3")), told(expected)) << packed;
  }
  EXPECT_EQ(open_log(folder_ / "d.db3")->format(), "ROS 2 bag, SQLite");
}

TEST_F(RosFiles, AFolderOfRos2IsReadInTheOrderOfItsMetadata) {
  Recording first, second;
  const Recording whole = usual();
  for (std::size_t i = 0; i < whole.entries.size(); ++i)
    (i < 7 ? first : second).entries.push_back(whole.entries[i]);
  first.sqlite(folder_ / "z_0.db3");
  file("a_1.mcap", second.mcap());
  EXPECT_THAT(error_of(folder_), ::testing::HasSubstr("metadata.yaml"));
  file("metadata.yaml",
       "rosbag2_bagfile_information:\n"
       "  version: 5\n"
       "  storage_identifier: sqlite3\n"
       "  relative_file_paths:\n"
       "    - z_0.db3\n"
       "    - 'bag/a_1.mcap'\n"
       "  duration:\n"
       "    nanoseconds: 1\n"
       "  files:\n"
       "    - path: other.db3\n");
  const Read read_back = read(folder_);
  EXPECT_EQ(read_back.events.size(), 15U);
  EXPECT_EQ(open_log(folder_)->format(), "ROS 2 bag");
  EXPECT_EQ(read_back.all<Scan>().back().T_robot_laser.x, 0.2);

  file("metadata.yaml", "x:\n  relative_file_paths:\n    - a.db3.zstd\n");
  EXPECT_THAT(error_of(folder_), ::testing::HasSubstr("zstd -d a.db3.zstd"));
  file("metadata.yaml", "x:\n  relative_file_paths:\n    - missing.db3\n");
  EXPECT_THAT(error_of(folder_), ::testing::HasSubstr("missing.db3"));
  file("metadata.yaml", "x:\n");
  EXPECT_THAT(error_of(folder_), ::testing::HasSubstr("lists no files"));
  file("metadata.yaml", "x:\n  relative_file_paths:\n    - metadata.yaml\n");
  EXPECT_THAT(error_of(folder_), ::testing::HasSubstr("no recording that majak knows"));
}

TEST_F(RosFiles, ADamagedDatabaseKeepsWhatCameBefore) {
  Recording r;
  for (int i = 0; i < 3000; ++i) r.scan(s(i));
  r.sqlite(folder_ / "a.db3");
  std::ifstream in(folder_ / "a.db3", std::ios::binary);
  const std::string whole(std::istreambuf_iterator<char>(in), {});
  std::string damaged = whole;
  damaged.replace(whole.size() / 2, 20000, std::string(20000, '\xee'));
  for (const std::string& content : {damaged, whole.substr(0, whole.size() / 2)}) {
    try {
      EXPECT_LT(read(file("b.db3", content)).events.size(), 3000U);
    } catch (const Error& e) {
      EXPECT_THAT(e.what(), ::testing::HasSubstr("b.db3"));
    }
  }
  EXPECT_EQ(read(folder_ / "a.db3").events.size(), 3000U);
  file("a.db3-wal", "something");
  EXPECT_EQ(read(folder_ / "a.db3").noticed("-wal"), 1);
}

TEST_F(RosFiles, OtherDatabasesAreRefused) {
  sqlite3* raw = nullptr;
  sqlite3_open((folder_ / "x.db").c_str(), &raw);
  sqlite3_exec(raw, "CREATE TABLE other(x);", nullptr, nullptr, nullptr);
  sqlite3_close(raw);
  const std::string error = error_of(folder_ / "x.db");
  EXPECT_TRUE(error.starts_with((folder_ / "x.db").string() + ": ")) << error;
  EXPECT_THAT(error, ::testing::HasSubstr("without the tables of a ROS 2 bag"));
}

TEST_F(RosFiles, OptionsThatMeanNothingToALogAreErrors) {
  const auto path = file("a.log", "FLASER 2 1.00 2.00 0 0 0 0 0 0 1.5 host 0.5\n");
  EXPECT_THROW(open_log(path, {.topic = "/scan"}), Error);
  EXPECT_THROW(open_log(path, {.topic = "", .angle_step = 1}), Error);
  EXPECT_THROW(open_log(path, {.topic = "", .angle_step = 0, .T_robot_laser = Pose2{}}), Error);
}

// ---- bags of the data folder ----------------------------------------------------------------

fs::path data(const char* name) { return testing::data_folder() / name; }

TEST_F(RosFiles, TheBagOfFr079HasTheScansOfItsCarmenLog) {
  if (!fs::exists(data("bags/fr079.orig.bag")))
    GTEST_SKIP() << "the data folder is absent (set MAJAK_DATA)";
  const Read carmen = read(data("freiburg/fr079.clf.bz2"));
  const Read stated = read(data("bags/fr079.orig.bag"));
  // It states 359 steps over 180 degrees, and the laser before the robot's centre, not behind it.
  EXPECT_EQ(stated.noticed("--angle-step 0.5 corrects it"), 4934);
  EXPECT_EQ(stated.all<Scan>()[0].T_robot_laser.x, 0.04);
  const Read bag = read(data("bags/fr079.orig.bag"),
                        {.topic = "", .angle_step = 0.5, .T_robot_laser = Pose2{-0.04, 0, 0}});
  EXPECT_TRUE(bag.report.empty());
  const auto scans = bag.all<Scan>(), expected = carmen.all<Scan>();
  ASSERT_EQ(scans.size(), expected.size());
  for (std::size_t i = 0; i < scans.size(); ++i) {
    ASSERT_EQ(scans[i].time, expected[i].time) << i;
    ASSERT_EQ(scans[i].ranges, expected[i].ranges) << i;
    ASSERT_EQ(scans[i].start_angle, expected[i].start_angle);
    ASSERT_EQ(scans[i].angle_step, expected[i].angle_step);
    ASSERT_EQ(scans[i].T_robot_laser, expected[i].T_robot_laser);
  }
  const auto odometry = bag.all<Odometry>(), wheels = carmen.all<Odometry>();
  ASSERT_EQ(odometry.size(), wheels.size());
  for (std::size_t i = 0; i < odometry.size(); ++i) {
    ASSERT_EQ(odometry[i].time, wheels[i].time) << i;
    ASSERT_LT((odometry[i].T_odom_robot.vector() - wheels[i].T_odom_robot.vector()).norm(), 1e-14);
    ASSERT_EQ(odometry[i].speed, wheels[i].speed);
  }
}

TEST_F(RosFiles, ReadsTheOtherBags) {
  if (!fs::exists(data("bags/sick_rms_lms1xx.bag")))
    GTEST_SKIP() << "the data folder is absent (set MAJAK_DATA)";
  const Read lms = read(data("bags/sick_rms_lms1xx.bag"));
  ASSERT_EQ(lms.all<Scan>().size(), 89U);
  EXPECT_EQ(lms.all<Scan>()[0].ranges.size(), 541U);
  EXPECT_EQ(lms.all<Scan>()[0].angle_step, radians(0.5));
  EXPECT_EQ(lms.all<Scan>()[0].start_angle, radians(-135));
  EXPECT_EQ(lms.all<Scan>()[0].intensities.size(), 541U);
  EXPECT_EQ(read(data("bags/ccny_laser_scan_matcher_demo.bag")).all<Scan>().size(), 360U);
  EXPECT_THAT(error_of(data("bags/ccny_laser_scan_sparsifier_demo.bag")),
              ::testing::HasSubstr("rosbag fix"));
  EXPECT_THAT(error_of(data("bags/foxglove_example-lz4.bag")),
              ::testing::HasSubstr("without a sensor_msgs/LaserScan"));
}

}  // namespace
}  // namespace majak::io
