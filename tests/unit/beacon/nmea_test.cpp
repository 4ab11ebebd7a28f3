// SPDX-License-Identifier: Apache-2.0
#include "majak/beacon/nmea.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

namespace majak::beacon {
namespace {

/// "$" + text + "*" + checksum.
std::string sentence(const std::string& text) {
  unsigned sum = 0;
  for (const char c : text) sum ^= static_cast<unsigned char>(c);
  char tail[8];
  std::snprintf(tail, sizeof tail, "*%02X", sum);
  return "$" + text + tail;
}

constexpr const char* kGga = "GPGGA,123519.25,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,";
constexpr const char* kRmc = "GPRMC,123519.25,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W";
constexpr const char* kGst = "GPGST,123519.25,3.2,6.6,4.7,47.3,3.0,4.0,7.1";
constexpr const char* kGsa = "GPGSA,A,3,04,05,,09,12,,,24,,,,,2.5,1.3,2.1";

struct Result {
  std::vector<SatelliteFix> fixes;
  Report report;

  std::int64_t noticed(const std::string& words) const {
    std::int64_t sum = 0;
    for (const auto& [what, entry] : report.entries())
      if (what.find(words) != std::string::npos) sum += entry.count;
    return sum;
  }
  std::int64_t first_line(const std::string& words) const {
    for (const auto& [what, entry] : report.entries())
      if (what.find(words) != std::string::npos) return entry.first_line;
    return -1;
  }
};

/// Fixes of a log whose lines are sentences already, or the text of one.
Result read(const std::vector<std::string>& lines) {
  Result r;
  NmeaFixes fixes;
  std::int64_t number = 0;
  const auto take = [&] {
    while (const auto fix = fixes.take()) r.fixes.push_back(*fix);
  };
  for (const std::string& line : lines) {
    fixes.add(line.starts_with("GP") || line.starts_with("GN") ? sentence(line) : line, ++number,
              r.report);
    take();
  }
  fixes.finish(r.report);
  take();
  return r;
}

std::string gga(const std::string& time, const std::string& place = "4807.038,N,01131.000,E") {
  return "GPGGA," + time + "," + place + ",1,08,1.5,545.4,M,46.9,M,,";
}
std::string rmc(const std::string& time, const std::string& date) {
  return "GPRMC," + time + ",A,4807.038,N,01131.000,E,022.4,084.4," + date + ",003.1,W";
}

// ---- one sentence -----------------------------------------------------------------------------

TEST(Nmea, ChecksumsOfThePrintedExamples) {
  EXPECT_EQ(
      parse_nmea("$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\r\n").kind,
      NmeaKind::gga);
  EXPECT_EQ(parse_nmea("$GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W*6A").kind,
            NmeaKind::rmc);
  EXPECT_EQ(parse_nmea("$GPGSA,A,3,04,05,,09,12,,,24,,,,,2.5,1.3,2.1*39").kind, NmeaKind::gsa);
  EXPECT_EQ(parse_nmea("$GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W*6a").kind,
            NmeaKind::rmc);
}

TEST(Nmea, Gga) {
  const auto s = parse_nmea(sentence(kGga));
  ASSERT_EQ(s.kind, NmeaKind::gga) << s.problem;
  EXPECT_EQ(s.time_of_day, (12 * 3600 + 35 * 60 + 19) * kSecond + 250'000'000);
  EXPECT_NEAR(s.place->latitude, 48 + 7.038 / 60, 1e-12);
  EXPECT_NEAR(s.place->longitude, 11 + 31.0 / 60, 1e-12);
  EXPECT_NEAR(s.place->altitude, 545.4 + 46.9, 1e-12);  // above the ellipsoid
  EXPECT_EQ(s.quality, 1);
  EXPECT_EQ(s.hdop, 0.9);
}

TEST(Nmea, Rmc) {
  const auto s = parse_nmea(sentence(kRmc));
  ASSERT_EQ(s.kind, NmeaKind::rmc) << s.problem;
  EXPECT_EQ(s.day, 8847);                                               // 1994-03-23
  EXPECT_EQ(parse_nmea(sentence(rmc("000000", "010100"))).day, 10957);  // 2000-01-01
  EXPECT_EQ(parse_nmea(sentence(rmc("000000", "290224"))).day, 19782);  // 2024-02-29
  EXPECT_EQ(s.quality, std::nullopt);
}

TEST(Nmea, GstAndGsa) {
  const auto gst = parse_nmea(sentence(kGst));
  ASSERT_EQ(gst.kind, NmeaKind::gst);
  EXPECT_EQ(gst.sigma_north, 3.0);
  EXPECT_EQ(gst.sigma_east, 4.0);
  const auto gsa = parse_nmea(sentence(kGsa));
  ASSERT_EQ(gsa.kind, NmeaKind::gsa);
  EXPECT_EQ(gsa.hdop, 1.3);
}

TEST(Nmea, SouthAndWestAndAllTalkers) {
  for (const std::string talker : {"GP", "GN", "GL", "GA", "GB", "GQ", "BD"}) {
    const auto s = parse_nmea(
        sentence(talker + "GGA,000000,4807.038,S,01131.000,W,1,08,0.9,545.4,M,46.9,M,,"));
    ASSERT_EQ(s.kind, NmeaKind::gga) << talker;
    EXPECT_LT(s.place->latitude, -48);
    EXPECT_LT(s.place->longitude, -11);
  }
}

TEST(Nmea, EmptyFieldsAreAbsent) {
  const auto s = parse_nmea(sentence("GPGGA,,,,,,0,00,,,M,,M,,"));
  ASSERT_EQ(s.kind, NmeaKind::gga);
  EXPECT_FALSE(s.time_of_day || s.place || s.hdop);
  EXPECT_EQ(s.quality, 0);
  EXPECT_EQ(parse_nmea(sentence("GPRMC,,V,,,,,,,,,")).quality, 0);
  EXPECT_EQ(parse_nmea(sentence("GPGST,120000,,,,,,,")).kind, NmeaKind::gst);
}

TEST(Nmea, OtherSentencesAreKnownToBeOther) {
  for (const char* text :
       {"GPGSV,3,1,11,03,03,111,00", "PGRME,15.0,M,45.0,M,25.0,M", "GPGGAX,1", "GP", ""}) {
    EXPECT_EQ(parse_nmea(sentence(text)).kind, NmeaKind::other) << text;
  }
  EXPECT_EQ(parse_nmea(sentence(std::string(100, ','))).kind, NmeaKind::other);
}

TEST(Nmea, BrokenLinesSayWhy) {
  const std::string good = sentence(kGga);
  EXPECT_EQ(parse_nmea("").kind, NmeaKind::none);
  EXPECT_EQ(parse_nmea(" \r\n").kind, NmeaKind::none);
  std::string wrong = good;
  wrong[20] = wrong[20] == '1' ? '2' : '1';
  EXPECT_NE(std::string(parse_nmea(wrong).problem).find("checksum"), std::string::npos);
  for (std::size_t n = 1; n < good.size(); ++n) {
    EXPECT_EQ(parse_nmea(good.substr(0, n)).kind, NmeaKind::damaged) << n;
    EXPECT_EQ(parse_nmea(good.substr(n)).kind, NmeaKind::damaged) << n;
  }
  EXPECT_EQ(parse_nmea("$" + std::string(300, 'A') + "*00").kind, NmeaKind::damaged);
}

TEST(Nmea, BadFieldsAreDamage) {
  const auto bad = [](const std::string& text) {
    const auto s = parse_nmea(sentence(text));
    return s.kind == NmeaKind::damaged &&
           std::string(s.problem).find("unreadable number") != std::string::npos;
  };
  EXPECT_TRUE(bad(gga("12x519")));
  EXPECT_TRUE(bad(gga("245959")));
  EXPECT_TRUE(bad(gga("126000")));
  EXPECT_TRUE(bad(gga("120061")));
  EXPECT_TRUE(bad(gga("120000,5")));
  EXPECT_TRUE(bad(gga("120000", "9000.001,N,01131.000,E")));
  EXPECT_TRUE(bad(gga("120000", "4860.000,N,01131.000,E")));
  EXPECT_TRUE(bad(gga("120000", "4807.038,X,01131.000,E")));
  EXPECT_TRUE(bad(gga("120000", "4807.038,N,18000.100,E")));
  EXPECT_TRUE(bad(gga("120000", "4807.038,N,,")));
  EXPECT_TRUE(bad(gga("120000", "nan,N,01131.000,E")));
  EXPECT_TRUE(bad("GPGGA,120000,4807.038,N,01131.000,E,x,08,0.9,545.4,M,46.9,M,,"));
  EXPECT_TRUE(bad("GPGGA,120000,4807.038,N"));
  EXPECT_TRUE(bad(rmc("120000", "320100")));
  EXPECT_TRUE(bad(rmc("120000", "011300")));
  EXPECT_TRUE(bad(rmc("120000", "0101")));
  EXPECT_TRUE(bad("GPGST,120000,1,2"));
  EXPECT_FALSE(bad(gga("235960")));  // a leap second
  EXPECT_FALSE(bad(gga("120000", "9000.000,N,18000.000,W")));
}

// ---- fixes ------------------------------------------------------------------------------------

TEST(NmeaFixes, SentencesOfOneTimeAreOneFix) {
  const auto r = read({kGga, kGsa, kGst, kRmc});
  ASSERT_EQ(r.fixes.size(), 1U);
  EXPECT_EQ(r.fixes[0].time, 8847 * kDay + (12 * 3600 + 35 * 60 + 19) * kSecond + 250'000'000);
  EXPECT_TRUE(r.fixes[0].dated);
  EXPECT_NEAR(r.fixes[0].sigma, std::sqrt(0.5 * (9 + 16)), 1e-12);
  EXPECT_NEAR(r.fixes[0].place.altitude, 592.3, 1e-9);
  EXPECT_EQ(r.fixes[0].line, 1);
  EXPECT_TRUE(r.report.empty());
}

TEST(NmeaFixes, SigmaComesFromGstElseFromDilution) {
  EXPECT_NEAR(read({kGga}).fixes[0].sigma, 0.9 * 4, 1e-12);
  EXPECT_NEAR(read({rmc("120000", "010100"), kGsa}).fixes[0].sigma, 1.3 * 4, 1e-12);
  EXPECT_EQ(read({rmc("120000", "010100")}).fixes[0].sigma, 0);  // it does not say
  EXPECT_NEAR(fix_sigma(2, 1), 2, 1e-12);
  EXPECT_NEAR(fix_sigma(4, 1.5), 0.03, 1e-12);
  EXPECT_NEAR(fix_sigma(5, 1), 0.5, 1e-12);
  EXPECT_EQ(fix_sigma(1, 0), 0);
  EXPECT_EQ(fix_sigma(1, std::nan("")), 0);
  EXPECT_EQ(fix_sigma(1, 99.99), 399.96);
  EXPECT_EQ(fix_sigma(1, 100), 0);
}

TEST(NmeaFixes, MidnightWithoutADate) {
  const auto r = read({gga("235958"), gga("235959.5"), gga("000000.5"), gga("000001"),
                       gga("235959"), gga("000002")});
  ASSERT_EQ(r.fixes.size(), 6U);
  EXPECT_FALSE(r.fixes[0].dated);
  EXPECT_EQ(r.fixes[2].time - r.fixes[1].time, kSecond);
  EXPECT_EQ(r.fixes[3].time, kDay + kSecond);
  EXPECT_EQ(r.fixes[4].time, kDay - kSecond);  // late, not a day ahead
  EXPECT_EQ(r.fixes[5].time, kDay + 2 * kSecond);
}

TEST(NmeaFixes, MidnightBeforeTheNewDateIsTold) {
  const auto r =
      read({rmc("235959", "281299"), gga("000000"), gga("000001"), rmc("000001", "291299")});
  ASSERT_EQ(r.fixes.size(), 3U);
  EXPECT_EQ(r.fixes[1].time - r.fixes[0].time, kSecond);
  EXPECT_EQ(r.fixes[2].time - r.fixes[0].time, 2 * kSecond);
}

TEST(NmeaFixes, ThoseBeforeTheFirstDateGetIt) {
  const auto r = read({gga("235958"), gga("235959"), gga("000000"), rmc("000001", "010100")});
  ASSERT_EQ(r.fixes.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_TRUE(r.fixes[i].dated);
    EXPECT_EQ(r.fixes[i].time, 10957 * kDay + (static_cast<Time>(i) - 2) * kSecond);
  }
}

TEST(NmeaFixes, TheDateIsNotAwaitedForEver) {
  NmeaFixes fixes;
  Report report;
  int taken = 0;
  for (int i = 0; i < 6000; ++i) {
    char time[16];
    std::snprintf(time, sizeof time, "%02d%02d%02d", i / 3600, i / 60 % 60, i % 60);
    fixes.add(sentence(gga(time)), i + 1, report);
    while (fixes.take()) ++taken;
  }
  EXPECT_EQ(taken, 5999);  // the last may still be told more of
  fixes.add(sentence(rmc("020000", "010100")), 6001, report);
  fixes.finish(report);
  const auto last = fixes.take(), after = fixes.take();
  ASSERT_TRUE(last && after);
  EXPECT_EQ(after->time, 7200 * kSecond);  // no jump by thirty years in the middle
}

TEST(NmeaFixes, WithoutAFixIsCounted) {
  const auto r =
      read({"GPGGA,120000,,,,,0,00,,,M,,M,,", "GPRMC,120001,V,,,,,,,010100,,", gga("120002"),
            "GPRMC,,V,,,,,,,,,", gga("120003"), "GPGSA,A,1,,,,,,,,,,,,,,,"});
  EXPECT_EQ(r.fixes.size(), 2U);
  EXPECT_EQ(r.noticed("without a fix"), 3);
  EXPECT_EQ(r.first_line("without a fix"), 1);
}

TEST(NmeaFixes, DamageAndOtherSentencesAreCountedWithTheirLine) {
  const auto r = read({gga("120000"), "$GPGGA,1*00", "noise", gga("12000"), sentence("GPGSV,1"),
                       gga("120001"), ""});
  EXPECT_EQ(r.fixes.size(), 2U);
  EXPECT_EQ(r.first_line("wrong checksum"), 2);
  EXPECT_EQ(r.first_line("no sentence"), 3);
  EXPECT_EQ(r.first_line("unreadable number"), 4);
  EXPECT_EQ(r.first_line("other kinds"), 5);
}

TEST(NmeaFixes, OfTwoPlacesGgaKnowsTheAltitude) {
  for (const auto& lines : {std::vector<std::string>{kGga, kRmc}, {kRmc, kGga}}) {
    EXPECT_NEAR(read(lines).fixes.at(0).place.altitude, 592.3, 1e-9);
  }
}

}  // namespace
}  // namespace majak::beacon
