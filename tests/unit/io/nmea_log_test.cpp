// SPDX-License-Identifier: Apache-2.0
#include "majak/io/nmea_log.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <string>

#include "log_fixtures.hpp"
#include "majak/core/error.hpp"
#include "majak/io/gps_beside.hpp"

namespace majak::io {
namespace {

using testing::Read;

std::string sentence(const std::string& text) {
  unsigned sum = 0;
  for (const char c : text) sum ^= static_cast<unsigned char>(c);
  char tail[8];
  std::snprintf(tail, sizeof tail, "*%02X\r\n", sum);
  return "$" + text + tail;
}

std::string gga(const std::string& time, const std::string& place) {
  return sentence("GNGGA," + time + "," + place + ",1,08,1.5,100,M,50,M,,");
}
std::string rmc(const std::string& time, const std::string& place, const std::string& date) {
  return sentence("GNRMC," + time + ",A," + place + ",0,0," + date + ",,");
}

Read read(std::string text) {
  NmeaLog log(open_bytes_in_memory(std::move(text)).bytes);
  return testing::read_all(log);
}

const char* const kHere = "4800.000,N,00751.000,E";
const char* const kNorth = "4800.100,N,00751.000,E";

TEST(NmeaLog, FixesAreMetresFromTheFirst) {
  const Read r = read(rmc("120000", kHere, "010100") + gga("120000", kHere) +
                      gga("120001", kNorth) + sentence("GNGST,120001,1,1,1,0,0.3,0.4,1"));
  const auto fixes = r.all<GpsFix>();
  ASSERT_EQ(fixes.size(), 2U);
  EXPECT_EQ(fixes[0].time, (10957 * 86400LL + 43200) * kSecond);
  EXPECT_NEAR(fixes[0].east, 0, 1e-8);
  EXPECT_NEAR(fixes[0].sigma, 6, 1e-12);
  EXPECT_NEAR(fixes[1].north, 185.3, 0.1);
  EXPECT_NEAR(fixes[1].sigma, 0.5 / std::sqrt(2), 1e-12);
  EXPECT_TRUE(r.report.empty());
}

TEST(NmeaLog, AcrossTheDateLineAndAtThePole) {
  const auto line = read(gga("1200"
                             "00",
                             "0000.000,N,17959.999,E") +
                         gga("120001", "0000.000,N,17959.999,W"))
                        .all<GpsFix>();
  ASSERT_EQ(line.size(), 2U);
  EXPECT_NEAR(line[1].east, 3.711, 0.001);
  const auto pole =
      read(gga("120000", "8959.999,N,00000.000,E") + gga("120001", "8959.999,N,18000.000,E"))
          .all<GpsFix>();
  ASSERT_EQ(pole.size(), 2U);
  EXPECT_NEAR(pole[1].north, 3.723, 0.001);
  EXPECT_NEAR(pole[1].east, 0, 1e-6);
}

TEST(NmeaLog, TimesOutOfOrderAreToldAndKept) {
  const Read r = read(rmc("120005", kHere, "010100") + gga("120003", kHere) + gga("120006", kHere));
  ASSERT_EQ(r.events.size(), 3U);
  EXPECT_LT(time_of(r.events[1]), time_of(r.events[0]));
  EXPECT_EQ(r.noticed("backwards"), 1);
  EXPECT_EQ(r.first_line("backwards"), 2);
}

TEST(NmeaLog, WithoutADateItSaysSo) {
  const Read r = read(gga("120000", kHere) + gga("120001", kHere));
  EXPECT_EQ(r.all<GpsFix>()[1].time, 43201 * kSecond);
  EXPECT_EQ(r.noticed("without a date"), 2);
}

TEST(NmeaLog, ATruncatedLogGivesItsWholeFixes) {
  const std::string whole = rmc("120000", kHere, "010100") + gga("120001", kHere);
  for (std::size_t n = 0; n <= whole.size(); ++n) {
    const Read r = read(whole.substr(0, n));
    for (const GpsFix& fix : r.all<GpsFix>()) EXPECT_GE(fix.time, 10957 * 86400LL * kSecond);
    EXPECT_LE(r.noticed("cut off"), 1);
  }
  EXPECT_EQ(read(whole.substr(0, whole.size() - 5)).noticed("cut off"), 1);
}

TEST(NmeaLog, IsRecognizedByItsContentPackedOrNot) {
  const std::string text =
      "boot message\r\n" + rmc("120000", kHere, "010100") + gga("120001", kNorth);
  EXPECT_TRUE(looks_like_nmea(text));
  EXPECT_FALSE(looks_like_nmea(""));
  EXPECT_FALSE(looks_like_nmea("$GPGGA,but,no,checksum\n"));
  EXPECT_FALSE(looks_like_nmea(sentence("GPGSV,1")));
  const auto folder = std::filesystem::temp_directory_path() / "majak_nmea_log_test";
  std::filesystem::create_directories(folder);
  for (const std::string& bytes : {text, testing::gzip(text), testing::bzip2(text)}) {
    std::ofstream(folder / "track", std::ios::binary) << bytes;
    const auto log = open_log(folder / "track");
    EXPECT_EQ(log->format().substr(0, 8), "NMEA log");
    EXPECT_EQ(testing::read_all(*log).events.size(), 2U);
    EXPECT_THROW(open_log(folder / "track", {.topic = "/scan"}), Error);
  }
  std::filesystem::remove_all(folder);
}

TEST(GpsBeside, FixesComeBetweenTheEventsByTime) {
  const auto odom = [](int second) {
    return "ODOM 0 0 0 0.1 0 0 " + std::to_string(10957 * 86400LL + 43200 + second) + ".5 h 0\n";
  };
  const auto open = [](std::string text) { return open_bytes_in_memory(std::move(text)).bytes; };
  GpsBeside both(
      std::make_unique<CarmenReader>(open(odom(0) + odom(1) + odom(2)), "CARMEN log"),
      std::make_unique<NmeaLog>(open(rmc("120000", kHere, "010100") + gga("120001", kHere) +
                                     gga("120002", kHere) + gga("120009", kHere) + "noise\n")));
  EXPECT_EQ(both.format(), "CARMEN log with NMEA log");
  const Read r = testing::read_all(both);
  ASSERT_EQ(r.events.size(), 7U);
  for (std::size_t i = 1; i < 7; ++i) EXPECT_LT(time_of(r.events[i - 1]), time_of(r.events[i]));
  EXPECT_EQ(r.all<GpsFix>().size(), 4U);
  EXPECT_EQ(r.noticed("gps: fixes before"), 2);
  EXPECT_EQ(r.noticed("gps: lines that are no sentence"), 1);
}

}  // namespace
}  // namespace majak::io
