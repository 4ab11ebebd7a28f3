// SPDX-License-Identifier: Apache-2.0
#include "majak/sensor/cola_scan.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "tests/support/data_folder.hpp"

namespace majak::sensor {
namespace {

using testing::HasSubstr;

constexpr std::array kDialects = {ColaDialect::a, ColaDialect::b};

ColaTelegram text_telegram(std::string payload, Time time = 0) {
  return {time, ColaDialect::a, std::move(payload)};
}

// From SICK's own examples: 21 beams from 10 deg in steps of half a degree.
const std::string kManual =
    "sRA LMDscandata 1 1 89A27F 0 0 343 347 27477BA9 2747813B 0 0 7 0 0 1388 168 0 1 DIST1 "
    "3F800000 00000000 186A0 1388 15 8A1 8A5 8AB 8AC 8A6 8AC 8B6 8C8 8C2 8C9 8CB 8C4 8E4 8E1 8EB "
    "8E0 8F5 908 8FC 907 906 0 0 0 0 0 0";

TEST(ColaScan, ReadsTheManualsExample) {
  const ColaScan scan = decode_scan(text_telegram(kManual, 5));
  EXPECT_EQ(scan.time, 5);
  EXPECT_TRUE(scan.asked);
  EXPECT_EQ(scan.serial, 0x89A27FU);
  EXPECT_EQ(scan.telegram_counter, 0x343);
  EXPECT_EQ(scan.scan_counter, 0x347);
  EXPECT_EQ(scan.transmission - scan.first_shot, 0x592U);
  EXPECT_EQ(scan.outputs, (std::array<std::uint8_t, 2>{7, 0}));
  EXPECT_EQ(scan.mirror_rate, 5000U);
  EXPECT_EQ(scan.measuring_rate, 360U);
  ASSERT_EQ(scan.channels16.size(), 1U);
  EXPECT_TRUE(scan.channels8.empty());
  const ColaChannel& distance = scan.channels16[0];
  EXPECT_EQ(distance.start_angle, 100000);
  EXPECT_EQ(distance.raw.size(), 21U);
  EXPECT_EQ(distance.raw[0], 2209);
  EXPECT_EQ(distance.raw[20], 0x906);
  EXPECT_FALSE(scan.name || scan.comment || scan.date || scan.position);
}

TEST(ColaScan, ReadsEncodersAndTwoChannels) {
  const ColaScan scan = decode_scan(text_telegram(
      "sSN LMDscandata 1 1 1 0 5 FFFF 0 1 2 3 4 5 6 0 9C4 168 2 FFFFFFFF 3E8 7 8 2 DIST1 40000000 "
      "00000000 FFFF3CB0 1388 3 0 10 FFFF RSSI1 3F800000 00000000 FFFF3CB0 1388 3 0 FE FF 0 "
      "1 3F800000 40000000 0 0 0 BF800000 1 1 1 4 a  b 1 0  1 7E9 C 1F 17 3B 3A F423F 0"));
  EXPECT_FALSE(scan.asked);
  EXPECT_STREQ(cola_status_words(scan.status), "pollution error");
  EXPECT_EQ(scan.encoders, (std::vector<ColaEncoder>{{0xffffffff, 1000}, {7, 8}}));
  EXPECT_EQ(scan.inputs, (std::array<std::uint8_t, 2>{3, 4}));
  EXPECT_EQ(scan.channel("RSSI1")->raw, (std::vector<std::uint16_t>{0, 254, 255}));
  EXPECT_EQ(scan.channel("DIST1")->start_angle, -50000);
  EXPECT_EQ(scan.channel("DIST2"), nullptr);
  EXPECT_EQ(scan.position->place, (std::array{1.0F, 2.0F, 0.0F}));
  EXPECT_EQ(scan.position->rotation[2], -1.0F);
  EXPECT_EQ(scan.name, "a  b");
  EXPECT_EQ(scan.comment, "");
  EXPECT_EQ(scan.date, (ColaDate{2025, 12, 31, 23, 59, 58, 999999}));
}

ColaChannel random_channel(RandomStream& random, const char* name, std::uint64_t most) {
  ColaChannel channel{.name = name,
                      .scale = static_cast<float>(random.uniform(0.1, 2)),
                      .offset = static_cast<float>(random.normal()),
                      .start_angle = static_cast<std::int32_t>(random.bits()),
                      .angle_step = static_cast<std::uint16_t>(random.bits()),
                      .raw = {}};
  for (auto n = random.below(30); n > 0; --n)
    channel.raw.push_back(static_cast<std::uint16_t>(random.below(most + 1)));
  return channel;
}

ColaScan random_scan(RandomStream& random) {
  ColaScan scan;
  scan.asked = random.below(2) == 0;
  scan.serial = static_cast<std::uint32_t>(random.bits());
  scan.status = {0, static_cast<std::uint8_t>(random.below(6))};
  scan.telegram_counter = static_cast<std::uint16_t>(random.bits());
  scan.first_shot = static_cast<std::uint32_t>(random.bits());
  scan.transmission = static_cast<std::uint32_t>(random.bits());
  scan.mirror_rate = static_cast<std::uint32_t>(random.below(10000));
  for (auto n = random.below(3); n > 0; --n)
    scan.encoders.push_back({static_cast<std::uint32_t>(random.bits()), 0x2020});
  for (auto n = random.below(3); n > 0; --n)
    scan.channels16.push_back(random_channel(random, "DIST1", 65535));
  for (auto n = random.below(3); n > 0; --n)
    scan.channels8.push_back(random_channel(random, "RSSI1", 255));
  if (random.below(2)) scan.position.emplace().place = {1.5F, -2, 0};
  if (random.below(2)) scan.name = "front left";
  if (random.below(2)) scan.comment = " 0 1 ";
  if (random.below(2)) scan.date = ColaDate{2026, 2, 28, 1, 2, 3, 4};
  return scan;
}

TEST(ColaScan, ReadsWhatItWroteInBothDialects) {
  RandomStream random(4);
  for (int round = 0; round < 200; ++round) {
    const ColaScan scan = random_scan(random);
    for (const ColaDialect dialect : kDialects) {
      ColaFramer framer;
      framer.push(cola_frame(dialect, encode_scan(scan, dialect)), 0);
      const auto telegram = framer.next();
      ASSERT_TRUE(telegram);
      EXPECT_EQ(decode_scan(*telegram), scan);
    }
  }
}

TEST(ColaScan, WhateverIsCutIsAnError) {
  RandomStream random(5);
  for (int round = 0; round < 20; ++round) {
    const ColaScan scan = random_scan(random);
    for (const ColaDialect dialect : kDialects) {
      const std::string whole = encode_scan(scan, dialect);
      for (std::size_t cut = 0; cut < whole.size(); ++cut)
        EXPECT_THROW(decode_scan({0, dialect, whole.substr(0, cut)}), Error) << cut;
    }
  }
}

TEST(ColaScan, ReadsTheOffsetsOfTheListingInB) {
  const ColaScan scan = decode_scan(text_telegram(kManual));
  const auto frame = cola_frame(ColaDialect::b, encode_scan(scan, ColaDialect::b));
  const auto u16 = [&](std::size_t at) { return frame[at] << 8 | frame[at + 1]; };
  EXPECT_EQ(u16(34), 0x343);
  EXPECT_EQ(u16(40), 0x7BA9);
  EXPECT_EQ(u16(44), 0x813B);
  EXPECT_EQ(u16(54), 5000);
  EXPECT_EQ(u16(58), 360);
  EXPECT_EQ(u16(60), 0);  // encoders
  EXPECT_EQ(u16(62), 1);  // channels
  EXPECT_EQ(frame[64], 'D');
  EXPECT_EQ(u16(64 + 21), 2209);
}

TEST(ColaScan, RefusesOtherTelegramsAndNames) {
  EXPECT_THROW(decode_scan(text_telegram("sRA STlms 7")), Error);
  EXPECT_THROW(decode_scan(text_telegram("sEA LMDscandata 1")), Error);
  std::string odd = kManual;
  odd.replace(odd.find("DIST1"), 5, "DIST ");
  EXPECT_THROW(decode_scan(text_telegram(odd)), Error);
}

// ---- real telegrams -------------------------------------------------------------------------

std::string data_file(const char* name) {
  std::ifstream in(data_folder() / "sick" / name, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

TEST(ColaScanData, ReadsARealTim5xx) {
  const std::string text = data_file("tim5xx_sSN_rssi.txt");
  if (text.empty()) GTEST_SKIP() << "the data folder is absent (set MAJAK_DATA)";
  const ColaScan raw = decode_scan(text_telegram(text, kSecond));
  EXPECT_EQ(raw.serial, 0x107375CU);
  EXPECT_EQ(raw.telegram_counter, 0xE784);
  EXPECT_EQ(raw.name, "not defined");
  EXPECT_EQ(raw.channels8.size(), 1U);
  const Scan scan = to_scan(raw);
  ASSERT_EQ(scan.ranges.size(), 271U);
  ASSERT_EQ(scan.intensities.size(), 271U);
  EXPECT_EQ(scan.ranges[0], 0.440F);
  EXPECT_EQ(scan.ranges[270], 1.333F);
  EXPECT_EQ(scan.intensities[0], 170.0F);
  EXPECT_TRUE(std::isnan(scan.ranges[25])) << "code 2";
  EXPECT_EQ(scan.ranges[29], kNoReturn);
  EXPECT_NEAR(scan.angle(0), radians(-135.0), 1e-12);
  EXPECT_NEAR(scan.angle(270), radians(135.0), 1e-12);
  EXPECT_EQ(scan.time, kSecond - 3797 * 1000);
  EXPECT_EQ(encode_scan(raw, ColaDialect::a), text);
}

TEST(ColaScanData, ACutTim551IsAClearError) {
  const std::string text = data_file("tim551_sRA_LMDscandata.txt");
  if (text.empty()) GTEST_SKIP() << "the data folder is absent (set MAJAK_DATA)";
  try {
    decode_scan(text_telegram(text));
    FAIL();
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), HasSubstr("of 271 values of RSSI1; the telegram was cut short"));
    EXPECT_THAT(e.what(), HasSubstr("byte 1447"));
  }
}

// ---- what a scan makes of it ----------------------------------------------------------------

ColaScan scan_of(std::vector<std::uint16_t> raw, float scale = 1, float offset = 0) {
  ColaScan scan;
  scan.mirror_rate = 2500;
  scan.channels16.push_back({"DIST1", scale, offset, -450000, 5000, std::move(raw)});
  return scan;
}

TEST(ColaToScan, RangesAndCodes) {
  const Scan scan = to_scan(scan_of({0, 1, 2, 15, 16, 1000, 65535}), {.max_range = 20});
  EXPECT_EQ(scan.ranges[0], kNoReturn);
  for (int i = 1; i <= 3; ++i) EXPECT_TRUE(std::isnan(scan.ranges[static_cast<std::size_t>(i)]));
  EXPECT_EQ(scan.ranges[4], 0.016F);
  EXPECT_EQ(scan.ranges[5], 1.0F);
  EXPECT_EQ(scan.ranges[6], kNoReturn) << "beyond the reach";
  EXPECT_EQ(scan.max_range, 20.0F);
}

TEST(ColaToScan, ScaleAndOffset) {
  const Scan scan = to_scan(scan_of({1000, 16, 40000}, 2, -100));
  EXPECT_FLOAT_EQ(scan.ranges[0], 1.9F);
  EXPECT_TRUE(std::isnan(scan.ranges[1])) << "behind the laser";
  EXPECT_FLOAT_EQ(scan.ranges[2], 79.9F);
  EXPECT_FLOAT_EQ(scan.max_range, 130.97F);
}

TEST(ColaToScan, ReturnsLieBelowMaxRangeWhateverTheTelegramSays) {
  RandomStream random(6);
  for (int round = 0; round < 300; ++round) {
    ColaScan raw = random_scan(random);
    raw.channels16 = {random_channel(random, "DIST1", 65535)};
    for (const double reach : {0.0, 8.0}) {
      const Scan scan = to_scan(raw, {.max_range = reach});
      for (const float r : scan.ranges)
        EXPECT_TRUE(std::isnan(r) || r == kNoReturn || (r > 0 && r < scan.max_range)) << r;
    }
  }
}

TEST(ColaToScan, BearingsAreMeasuredFromAhead) {
  const Scan scan = to_scan(scan_of({1000, 1000}));
  EXPECT_NEAR(scan.start_angle, radians(-135.0), 1e-15);
  EXPECT_NEAR(scan.angle_step, radians(0.5), 1e-15);
  EXPECT_NEAR(to_scan(scan_of({1}), {.ahead = 0}).start_angle, radians(-45.0), 1e-15);
}

TEST(ColaToScan, ThirdsAndTwelfthsOfADegreeAreExact) {
  EXPECT_DOUBLE_EQ(exact_cola_step(0xD05), 1e4 / 3);
  EXPECT_DOUBLE_EQ(exact_cola_step(0x1A0B), 2e4 / 3);
  EXPECT_DOUBLE_EQ(exact_cola_step(833), 1e4 / 12);
  EXPECT_DOUBLE_EQ(exact_cola_step(417), 1e4 / 24);
  for (const int step : {10000, 5000, 2500, 1250, 1000, 390, 0, 1, 65535})
    EXPECT_DOUBLE_EQ(exact_cola_step(static_cast<std::uint16_t>(step)), step);
  for (int step = 0; step < 65536; ++step)
    EXPECT_LE(std::abs(exact_cola_step(static_cast<std::uint16_t>(step)) - step), 0.5);
}

TEST(ColaToScan, IntensitiesOfTheSameBeams) {
  ColaScan raw = scan_of({100, 200});
  EXPECT_TRUE(to_scan(raw).intensities.empty());
  raw.channels8.push_back({"RSSI1", 1, 0, -450000, 5000, {7, 255}});
  EXPECT_EQ(to_scan(raw).intensities, (std::vector<float>{7, 255}));
  raw.channels8[0].raw.push_back(1);
  EXPECT_TRUE(to_scan(raw).intensities.empty()) << "of other beams";
}

TEST(ColaToScan, EchoesAreChosen) {
  ColaScan raw = scan_of({100});
  raw.channels16.push_back({"DIST2", 1, 0, -450000, 5000, {300}});
  EXPECT_EQ(to_scan(raw, {.echo = 2}).ranges[0], 0.3F);
  EXPECT_THROW(to_scan(raw, {.echo = 3}), Error);
}

TEST(ColaToScan, AScaleThatMeansNothingIsAnError) {
  for (const float scale : {0.0F, -1.0F, std::numeric_limits<float>::infinity(), std::nanf("")})
    EXPECT_THROW(to_scan(scan_of({100}, scale)), Error);
  EXPECT_THROW(to_scan(scan_of({100}, 1, std::nanf(""))), Error);
}

TEST(ColaToScan, TheTimeIsThatOfTheFirstBeamAcrossTheClocksWrap) {
  ColaScan raw = scan_of(std::vector<std::uint16_t>(541, 100));
  raw.time = 10 * kSecond;
  for (const std::uint32_t first : {0U, 1000U, 0xFFFFFFFFU, 0xFFFF8000U, 0x7FFFFFFFU}) {
    raw.first_shot = first;
    raw.transmission = first + 33'000;
    EXPECT_EQ(to_scan(raw).time, 10 * kSecond - 33'000'000);
  }
}

TEST(ColaToScan, AClockThatMakesNoSenseIsNotBelieved) {
  ColaScan raw = scan_of(std::vector<std::uint16_t>(541, 100));
  raw.time = 10 * kSecond;
  raw.first_shot = 5;
  raw.transmission = 4;  // 71 minutes
  EXPECT_EQ(cola_delay(raw), std::nullopt);
  EXPECT_EQ(to_scan(raw).time, 10 * kSecond - from_seconds(0.04 * 541 * 0.5 / 360));
}

TEST(ColaToScan, BeamsFollowTheMirror) {
  const ColaScan raw = scan_of(std::vector<std::uint16_t>(541, 100));
  EXPECT_EQ(cola_beam_time(raw, 0), 0);
  EXPECT_EQ(cola_beam_time(raw, 720), 40'000'000) << "one turn at 25 Hz";
  EXPECT_EQ(cola_beam_time(raw, 180), 10'000'000);
  EXPECT_EQ(cola_beam_time(ColaScan{}, 180), 0);
}

}  // namespace
}  // namespace majak::sensor
