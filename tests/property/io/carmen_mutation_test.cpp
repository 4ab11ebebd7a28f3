// SPDX-License-Identifier: Apache-2.0
// Whatever happens to a log on its way, reading it ends, gives sound events, and throws nothing.
#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <string>

#include "majak/core/random.hpp"
#include "majak/io/carmen_reader.hpp"

namespace majak::io {
namespace {

const std::string kLog =
    "# CARMEN Logfile\n"
    "PARAM robot_frontlaser_offset 0.1 nohost 0\n"
    "PARAM robot_front_laser_max 80.99 nohost 0\n"
    "PARAM laser_front_laser_resolution 1.0 nohost 0\n"
    "ODOM 1.0 2.0 0.5 0.1 0.2 0.0 976052857.337284 nohost 0.0\n"
    "FLASER 5 1.07 81.91 3.00 nan 5.50 1.1 2.0 0.5 1.0 2.0 0.5 976052857.437284 nohost 0.1\n"
    "RLASER 3 1.0 2.0 3.0 1.1 2.0 -2.6 1.0 2.0 0.5 976052857.5 nohost 0.2\n"
    "ROBOTLASER1 0 -1.570796 3.141593 1.570796 81.92 0.01 0 3 1.0 2.0 3.0 3 7 8 9 1 2 0.5 1 2 0.5 "
    "0 0 0 0 0 976052858.0 h 0.3\n"
    "RAWLASER3 2 -2.0 4.0 2.0 5.6 0.01 0 3 1.0 2.0 3.0 0 976052858.1 h 0.4\n"
    "LASER5 2 1.0 2.0 976052858.2 h 0.5\n"
    "TRUEPOS 1 2 0.5 1 2 0.5 976052858.3 h 0.6\n"
    "NMEAGGA 1 120000.0 4800.6000 N 00751.0000 E 1 8 1.2 0 250.5 0 0 0 976052858.4 h 0.7\n"
    "NMEARMC 1 A 120000.0 4800.6000 N 00751.0000 E 0 0 0 E 10104 976052858.5 h 0.8\n"
    "SONAR 1 2 3\nunknown 1 2 3\n";

std::string mutate(std::string text, RandomStream& random) {
  const std::string alphabet =
      "0123456789.-+eE \t\n\r#NaInf\x00\xff\x8a"
      "FLASERODOM";
  const std::uint64_t changes = 1 + random.below(12);
  for (std::uint64_t k = 0; k < changes && !text.empty(); ++k) {
    const std::size_t at = random.below(text.size()),
                      size = random.below(1 + std::min<std::size_t>(40, text.size() - at));
    switch (random.below(6)) {
      case 0:
        text[at] = alphabet[random.below(alphabet.size())];
        break;
      case 1:
        text[at] = static_cast<char>(random.below(256));
        break;
      case 2:
        text.erase(at, size);
        break;
      case 3:
        text.insert(random.below(text.size()), text.substr(at, size));
        break;
      case 4:
        text.insert(at, 1 + random.below(30), alphabet[random.below(alphabet.size())]);
        break;
      default:
        text.resize(at);
        break;
    }
  }
  return text;
}

void expect_sound(const Scan& scan) {
  ASSERT_FALSE(scan.ranges.empty());
  EXPECT_TRUE(std::isfinite(scan.start_angle) && std::isfinite(scan.angle_step));
  EXPECT_TRUE(scan.intensities.empty() || scan.intensities.size() == scan.ranges.size());
  EXPECT_TRUE(scan.T_robot_laser.finite());
  EXPECT_TRUE(scan.laser >= 0 && scan.laser < 5);
  EXPECT_TRUE(!scan.T_odom_robot || scan.T_odom_robot->finite());
  for (const float range : scan.ranges) {
    EXPECT_TRUE(std::isnan(range) || range == kNoReturn || (range > 0 && range < scan.max_range))
        << range;
  }
}

void expect_sound(const Odometry& odometry) { EXPECT_TRUE(odometry.T_odom_robot.finite()); }
void expect_sound(const Truth& truth) { EXPECT_TRUE(truth.T_world_robot.finite()); }
void expect_sound(const GpsFix& fix) { EXPECT_TRUE(std::isfinite(fix.east + fix.north)); }
void expect_sound(const WheelMotion&) { FAIL() << "no CARMEN message says this"; }
void expect_sound(const BeaconSighting&) { FAIL() << "no CARMEN message says this"; }

std::size_t read(std::string bytes) {
  CarmenReader reader(open_bytes_in_memory(std::move(bytes)).bytes, "CARMEN log");
  std::size_t events = 0;
  while (const auto event = reader.next()) {
    std::visit([](const auto& e) { expect_sound(e); }, *event);
    ++events;
  }
  return events;
}

TEST(MutatedCarmenLog, TheWholeLogIsRead) { EXPECT_EQ(read(kLog), 8u); }

TEST(MutatedCarmenLog, GivesSoundEventsOrNone) {
  RandomStream random(11);
  std::size_t events = 0;
  for (int i = 0; i < 5000 && !testing::Test::HasFailure(); ++i)
    events += read(mutate(kLog, random));
  EXPECT_GT(events, 10000u) << "most records survive their neighbours";
}

TEST(MutatedCarmenLog, RandomBytesGiveNothing) {
  RandomStream random(12);
  for (int i = 0; i < 200; ++i) {
    std::string bytes(random.below(5000), '\0');
    for (char& c : bytes) c = static_cast<char>(random.below(256));
    EXPECT_EQ(read(bytes), 0u);
  }
}

TEST(MutatedCarmenLog, DamagedArchivesAreSurvived) {
  std::string packed(4096, '\0');
  auto size = static_cast<uLongf>(packed.size());
  z_stream z{};
  deflateInit2(&z, 9, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY);
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(kLog.data()));
  z.avail_in = static_cast<uInt>(kLog.size());
  z.next_out = reinterpret_cast<Bytef*>(packed.data());
  z.avail_out = static_cast<uInt>(size);
  deflate(&z, Z_FINISH);
  packed.resize(z.total_out);
  deflateEnd(&z);
  EXPECT_EQ(read(packed), 8u);
  RandomStream random(13);
  for (int i = 0; i < 2000 && !testing::Test::HasFailure(); ++i) read(mutate(packed, random));
}

}  // namespace
}  // namespace majak::io
