// SPDX-License-Identifier: Apache-2.0
#include "majak/io/carmen_writer.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/io/source.hpp"

namespace majak::io {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class CarmenWriterTest : public testing::Test {
 protected:
  CarmenWriterTest() {
    std::string name = (fs::temp_directory_path() / "majak-carmen-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
    log_ = folder_ / "a.log";
  }
  ~CarmenWriterTest() override { fs::remove_all(folder_); }

  std::string text_of(const std::vector<Event>& events, std::string_view comment = {}) {
    CarmenWriter writer(log_, comment);
    for (const Event& e : events) writer.write(e);
    writer.commit();
    std::ifstream in(log_, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  std::vector<Event> read_back() {
    std::vector<Event> events;
    const auto source = open_log(log_);
    while (auto e = source->next()) events.push_back(std::move(*e));
    return events;
  }

  fs::path folder_, log_;
};

Scan scan_of(std::size_t beams, double start_degrees, double step_degrees) {
  Scan s;
  s.time = 1'000'000'000'133'333'000;
  s.start_angle = radians(start_degrees);
  s.angle_step = radians(step_degrees);
  s.max_range = 80;
  s.T_robot_laser = {0.1, 0, 0};
  s.T_odom_robot = Pose2{1.5, -2.25, 0.5};
  for (std::size_t i = 0; i < beams; ++i)
    s.ranges.push_back(static_cast<float>(100 + i % 50) / 100);
  s.ranges[3] = kNoReturn;
  s.ranges[4] = kInvalidRange;
  return s;
}

TEST_F(CarmenWriterTest, WritesWhatACarmenLogLooksLike) {
  Scan s = scan_of(180, -90, 1);
  std::fill(s.ranges.begin() + 5, s.ranges.end(), 2.5f);
  const std::string text = text_of(
      {Odometry{1'000'000'000'000'000'000, {1, 2, -0.5}, 0.25, -0.1}, s, Truth{s.time, {7, 8, 3}}},
      "made for a test\nseed 1");
  std::string ranges = " 1.00 1.01 1.02 81.91 0.00";
  for (int i = 5; i < 180; ++i) ranges += " 2.50";
  const std::string end = " 1000000000.133333 majak 0.133333\n";
  EXPECT_EQ(text,
            "# CARMEN Logfile\n# made for a test\n# seed 1\n"
            "ODOM 1.000000 2.000000 -0.500000 0.250000 -0.100000 0.000000 1000000000.000000 majak "
            "0.000000\n"
            "PARAM robot_frontlaser_offset 0.100000" +
                end + "PARAM robot_frontlaser_side_offset 0.000000" + end +
                "PARAM robot_front_laser_max 80.00" + end + "PARAM laser_front_laser_resolution 1" +
                end + "FLASER 180" + ranges +
                " 1.587758 -2.202057 0.500000 1.500000 -2.250000 0.500000" + end +
                "TRUEPOS 7.000000 8.000000 3.000000 1.500000 -2.250000 0.500000" + end);
}

TEST_F(CarmenWriterTest, EveryVariantReadsBack) {
  struct Case {
    std::size_t beams;
    double start, step;
    const char* record;
  };
  for (const Case& c : {Case{180, -90, 1, "\nFLASER 180 "},
                        {181, -90, 1, "\nFLASER 181 "},
                        {360, -90, 0.5, "\nFLASER 360 "},
                        {361, -90, 0.5, "\nFLASER 361 "},
                        {101, -50, 1, "\nROBOTLASER1 99 "},
                        {201, -50, 0.5, "\nROBOTLASER1 99 "},
                        {401, -50, 0.25, "\nROBOTLASER1 99 "},
                        {1081, -135, 0.25, "\nROBOTLASER1 99 "},
                        {180, -89.5, 1, "\nROBOTLASER1 99 "}}) {
    const Scan s = scan_of(c.beams, c.start, c.step);
    EXPECT_THAT(text_of({s}), HasSubstr(c.record));
    const auto events = read_back();
    ASSERT_EQ(events.size(), 1u) << c.record;
    const Scan& back = std::get<Scan>(events[0]);
    EXPECT_EQ(back.time, s.time);
    EXPECT_NEAR(back.start_angle, s.start_angle, 1e-9);
    EXPECT_NEAR(back.angle_step, s.angle_step, 1e-9);
    EXPECT_LT(log(between(back.T_robot_laser, s.T_robot_laser)).norm(), 1e-5);
    EXPECT_LT(log(between(*back.T_odom_robot, *s.T_odom_robot)).norm(), 1e-5);
    ASSERT_EQ(back.ranges.size(), s.ranges.size());
    for (std::size_t i = 0; i < s.ranges.size(); ++i) {
      if (std::isfinite(s.ranges[i])) {
        EXPECT_NEAR(back.ranges[i], s.ranges[i], 1e-6);
      } else {
        EXPECT_EQ(std::isnan(back.ranges[i]), std::isnan(s.ranges[i])) << i;
        EXPECT_FALSE(std::isfinite(back.ranges[i]));
      }
    }
  }
}

TEST_F(CarmenWriterTest, RearLaserWithoutOdometryAndIntensities) {
  Scan rear = scan_of(181, -90, 1), bare = rear, bright = rear;
  rear.laser = 1;
  rear.T_robot_laser = {-0.3, 0, kPi};
  EXPECT_THAT(text_of({rear}), HasSubstr("\nRLASER 181 "));
  EXPECT_LT(log(between(std::get<Scan>(read_back()[0]).T_robot_laser, rear.T_robot_laser)).norm(),
            1e-5);
  bare.T_odom_robot.reset();
  EXPECT_THAT(text_of({bare}), HasSubstr("\nRAWLASER1 99 "));
  EXPECT_FALSE(std::get<Scan>(read_back()[0]).T_odom_robot.has_value());
  bright.intensities.assign(181, 12);
  bright.intensities[7] = 0.5f;
  EXPECT_THAT(text_of({bright}), HasSubstr("\nROBOTLASER1 99 "));
  EXPECT_EQ(std::get<Scan>(read_back()[0]).intensities, bright.intensities);
  bright.laser = 5;
  EXPECT_THROW(text_of({bright}), Error);
}

TEST_F(CarmenWriterTest, ShortSightedLaserHasItsOwnCode) {
  Scan s = scan_of(181, -90, 1);
  s.max_range = 8;
  EXPECT_THAT(text_of({s}), testing::AllOf(HasSubstr(" 8.19 0.00 "), HasSubstr("laser_max 8.00")));
  const Scan back = std::get<Scan>(read_back()[0]);
  EXPECT_EQ(back.ranges[3], kNoReturn);
  EXPECT_EQ(back.max_range, 8.0f);
}

TEST_F(CarmenWriterTest, RandomEventsReadBackInOrder) {
  RandomStream r(1);
  std::vector<Event> events;
  Time time = 5 * kSecond;
  for (int i = 0; i < 300; ++i) {
    time += 1000 * static_cast<Duration>(1 + r.below(200'000));
    const double x = r.uniform(-50, 50), y = r.uniform(-50, 50), theta = r.uniform(-3.1, 3.1);
    const Pose2 pose{x, y, theta};
    if (i % 3 == 0) {
      Scan s = scan_of(181, -90, 1);
      s.time = time;
      s.T_odom_robot = pose;
      for (float& range : s.ranges) range = 0.01f * static_cast<float>(1 + r.below(3000));
      events.push_back(s);
    } else if (i % 3 == 1) {
      events.push_back(Odometry{time, pose, r.uniform(-1, 1), r.uniform(-1, 1)});
    } else {
      events.push_back(Truth{time, pose});
    }
  }
  text_of(events);
  const auto back = read_back();
  ASSERT_EQ(back.size(), events.size());
  for (std::size_t i = 0; i < events.size(); ++i) {
    ASSERT_EQ(back[i].index(), events[i].index());
    EXPECT_EQ(time_of(back[i]), time_of(events[i]));
    if (const auto* truth = std::get_if<Truth>(&back[i])) {
      const Pose2 T = std::get<Truth>(events[i]).T_world_robot;
      EXPECT_LT(log(between(truth->T_world_robot, T)).norm(), 2e-6);
    } else if (const auto* scan = std::get_if<Scan>(&back[i])) {
      const Scan& s = std::get<Scan>(events[i]);
      for (std::size_t k = 0; k < s.ranges.size(); ++k)
        EXPECT_NEAR(scan->ranges[k], s.ranges[k], 1e-5);
    }
  }
}

TEST_F(CarmenWriterTest, FineRangesKeepTheirMillimetres) {
  Scan s = scan_of(181, -90, 1);
  s.ranges[0] = 1.2345f;
  EXPECT_THAT(text_of({s}), HasSubstr("FLASER 181 1.2345 1.01 "));
}

TEST_F(CarmenWriterTest, EventsWithoutARecordAreCounted) {
  CarmenWriter writer(log_);
  writer.write(WheelMotion{});
  writer.write(GpsFix{});
  ASSERT_EQ(writer.report().entries().size(), 1u);
  EXPECT_EQ(writer.report().entries().begin()->second.count, 2);
}

TEST_F(CarmenWriterTest, NoLogWithoutCommitAndNoneOnAFullDisk) {
  {
    CarmenWriter writer(log_);
    writer.write(scan_of(181, -90, 1));
  }
  EXPECT_TRUE(fs::is_empty(folder_));
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  CarmenWriter full("/dev/full");
  full.write(scan_of(181, -90, 1));
  EXPECT_THAT([&] { full.commit(); }, testing::ThrowsMessage<Error>(HasSubstr("/dev/full")));
}

}  // namespace
}  // namespace majak::io
