// SPDX-License-Identifier: Apache-2.0
// Formats are found by content, errors are one line; and the real logs of the data folder.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "log_fixtures.hpp"
#include "majak/core/error.hpp"
#include "majak/io/log_summary.hpp"
#include "majak/io/source.hpp"

namespace majak::io {
namespace {

namespace fs = std::filesystem;

const std::string kScan = "FLASER 2 1.00 2.00 0 0 0 0 0 0 1.5 host 0.5\n";

class OpenLog : public ::testing::Test {
 protected:
  OpenLog()
      : folder_(fs::path(::testing::TempDir()) / ("majak_open_log_" + std::to_string(::getpid()))) {
    fs::create_directories(folder_);
  }
  ~OpenLog() override { fs::remove_all(folder_); }

  fs::path file(const std::string& name, const std::string& content) const {
    std::ofstream(folder_ / name, std::ios::binary) << content;
    return folder_ / name;
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

TEST_F(OpenLog, FindsTheFormatByContentNotByName) {
  EXPECT_EQ(open_log(file("a.gz", kScan))->format(), "CARMEN log");
  EXPECT_EQ(open_log(file("b.txt", testing::gzip(kScan)))->format(), "CARMEN log, gzip");
  EXPECT_EQ(open_log(file("c.log", testing::bzip2(kScan)))->format(), "CARMEN log, bzip2");
  for (const char* name : {"a.gz", "b.txt", "c.log"}) {
    EXPECT_TRUE(open_log(folder_ / name)->next().has_value()) << name;
  }
}

TEST_F(OpenLog, FindsAVictoriaParkFolder) {
  std::string scan = "0.5";
  for (int i = 0; i < 361; ++i) scan += "\t1.00";
  file("LASER.txt", testing::gzip(scan + "\t"));
  EXPECT_THAT(error_of(folder_), ::testing::HasSubstr("LASER.txt"));
  file("DRS.txt", "0.1 1 0\n");
  const auto source = open_log(folder_);
  EXPECT_EQ(source->format(), "Victoria Park folder");
  EXPECT_TRUE(std::holds_alternative<WheelMotion>(*source->next()));
  EXPECT_TRUE(std::holds_alternative<Scan>(*source->next()));
  EXPECT_FALSE(source->next().has_value());
  fs::rename(folder_ / "LASER.txt", folder_ / "LASER.txt.gz");
  EXPECT_TRUE(open_log(folder_)->next().has_value());
}

TEST_F(OpenLog, ErrorsAreOneLineThatNamesTheFile) {
  const std::vector<std::pair<fs::path, std::string>> cases = {
      {file("empty", ""), "empty"},
      {file("empty.gz", testing::gzip("")), "empty"},
      {file("cut.gz", testing::gzip(kScan).substr(0, 12)), "no log could be unpacked"},
      {file("random", std::string("\x01\x02\x03 ODO", 7)), "no log that majak knows"},
      {file("text", "hello\nworld\n"), "FLASER"},
      {file("bag", "#ROSBAG V2.0\n"), "without messages"},
      {file("old", "#ROSBAG V1.2\n"), "rosbag fix"},
      {folder_ / "missing", "No such file"},
      {folder_, "Victoria Park"}};
  for (const auto& [path, words] : cases) {
    const std::string error = error_of(path);
    EXPECT_TRUE(error.starts_with(path.string() + ": ")) << error;
    EXPECT_THAT(error, ::testing::HasSubstr(words));
    EXPECT_EQ(std::count(error.begin(), error.end(), '\n'), 0) << error;
  }
}

TEST_F(OpenLog, JunkBeforeTheLogDoesNotHideIt) {
  const auto source = open_log(file("x", std::string("\0\xff garbage\nmore\n", 16) + kScan));
  EXPECT_TRUE(source->next().has_value());
}

struct RealLog {
  const char* path;
  std::int64_t scans, odometry;
  std::size_t beams;
  double step_degrees, duration_s, path_m;
  std::int64_t no_returns, backwards;
  float max_range;
  double laser_x;
};

void PrintTo(const RealLog& log, std::ostream* out) { *out << log.path; }

class RealLogs : public ::testing::TestWithParam<RealLog> {};

TEST_P(RealLogs, ReadAsTheirAuthorsDescribeThem) {
  const RealLog& known = GetParam();
  const fs::path path = testing::data_folder() / known.path;
  if (!fs::exists(path)) GTEST_SKIP() << "the data folder is absent (set MAJAK_DATA)";
  const auto source = open_log(path);
  LogSummary summary;
  while (const auto event = source->next()) summary.add(*event);
  ASSERT_EQ(summary.lasers.size(), 1u);
  const LaserSummary& laser = summary.lasers.at(0);
  EXPECT_EQ(laser.stamps.count, known.scans);
  EXPECT_EQ(laser.stamps.backwards, known.backwards);
  EXPECT_EQ(laser.fewest_beams, known.beams);
  EXPECT_EQ(laser.most_beams, known.beams);
  EXPECT_NEAR(degrees(laser.angle_step), known.step_degrees, 1e-9);
  EXPECT_NEAR(degrees(laser.start_angle), -90, 1e-9);
  EXPECT_EQ(laser.no_returns, known.no_returns);
  EXPECT_EQ(laser.invalid, 0);
  EXPECT_NEAR(laser.max_range, known.max_range, 0.006);
  EXPECT_NEAR(laser.T_robot_laser.x, known.laser_x, 1e-9);
  EXPECT_EQ(summary.odometry.count, known.odometry);
  EXPECT_NEAR(to_seconds(summary.latest() - summary.earliest()), known.duration_s, 1.0);
  EXPECT_NEAR(summary.odometry_path.length + summary.wheel_path, known.path_m, 1.5);
  EXPECT_TRUE(source->report().entries().size() <= 2u);
}

INSTANTIATE_TEST_SUITE_P(
    DataFolder, RealLogs,
    ::testing::Values(
        RealLog{"freiburg/intel.clf.bz2", 13631, 26915, 180, 1.0, 2691, 508, 68313, 631, 79.9f, 0},
        RealLog{"freiburg/fr079.clf.bz2", 4934, 8951, 360, 0.5, 1061, 392, 36881, 0, 79.9f, -0.04},
        RealLog{"freiburg/aces.clf.bz2", 7374, 7375, 180, 1.0, 1366, 325, 11139, 0, 50.0f, 0},
        RealLog{"victoria_park", 7230, 0, 361, 0.5, 1545, 4030, 2166417, 0, 79.9f, 3.78}));

}  // namespace
}  // namespace majak::io
