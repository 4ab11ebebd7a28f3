// SPDX-License-Identifier: Apache-2.0
#include "majak/sensor/lms_scan.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "sick_data.hpp"

namespace majak::sensor {
namespace {

using testing::Bytes;
using testing::bytes;
using ::testing::ElementsAre;

LmsScan whole(int count, std::uint16_t value, Unit unit) {
  LmsScan scan;
  scan.unit = unit;
  scan.values.assign(static_cast<std::size_t>(count), value);
  return scan;
}

LmsConfiguration mode(int measuring_mode, Unit unit = Unit::centimetre) {
  LmsConfiguration c = LmsConfiguration::factory();
  c.set_measuring_mode(measuring_mode);
  c.set_unit(unit);
  return c;
}

/// Head and tail of the frame that a scan becomes.
void expect_frame(const LmsScan& scan, std::size_t size, const char* head, const char* tail) {
  const Bytes frame = encode(tell_scan(scan)), first = bytes(head), last = bytes(tail);
  ASSERT_EQ(frame.size(), size);
  EXPECT_EQ(Bytes(frame.begin(), frame.begin() + static_cast<std::ptrdiff_t>(first.size())), first);
  EXPECT_EQ(Bytes(frame.end() - static_cast<std::ptrdiff_t>(last.size()), frame.end()), last);
  EXPECT_EQ(decode_scan(*decode(frame)), scan);
}

TEST(LmsScan, FramesOfTheDocument) {
  expect_frame(whole(361, 1000, Unit::millimetre), 732, "02 80 D6 02 B0 69 41 E8 03", "10 55 F1");
  expect_frame(whole(401, 100, Unit::centimetre), 812, "02 80 26 03 B0 91 01 64 00", "10 A9 F1");
  LmsScan ramp = whole(181, 0, Unit::centimetre);
  for (std::size_t i = 0; i < 181; ++i) ramp.values[i] = static_cast<std::uint16_t>(i);
  expect_frame(ramp, 372, "02 80 6E 01 B0 B5 00 00 00 01 00", "B4 00 10 D5 D8");
  LmsScan turn = whole(181, 2000, Unit::millimetre);
  turn.partial = true;
  expect_frame(turn, 372, "02 80 6E 01 B0 B5 60 D0 07", "10 8D 13");
  turn = whole(180, 2000, Unit::millimetre);
  turn.partial = true;
  turn.quarter = 1;
  expect_frame(turn, 370, "02 80 6C 01 B0 B4 68 D0 07", "10 B9 B4");
}

TEST(LmsScan, LengthsOfTheManual) {
  const int counts[5] = {101, 201, 401, 181, 361};
  const std::uint16_t lengths[5] = {0x00CE, 0x0196, 0x0326, 0x016E, 0x02D6};
  for (int i = 0; i < 5; ++i) {
    const Bytes frame = encode(tell_scan(whole(counts[i], 1, Unit::centimetre)));
    EXPECT_EQ(frame[2] | frame[3] << 8, lengths[i]);
  }
}

/// One of each telegram that carries values.
std::vector<LmsScan> one_of_each() {
  RandomStream random(1);
  std::vector<LmsScan> all;
  for (const Reply code :
       {Reply::scan, Reply::mean_scan, Reply::subrange_scan, Reply::mean_subrange_scan,
        Reply::fields_scan, Reply::reflectivity_scan, Reply::s14_scan}) {
    LmsScan scan;
    scan.code = code;
    scan.unit = Unit::millimetre;
    scan.status = 0xD1;
    if (code == Reply::mean_scan || code == Reply::mean_subrange_scan) scan.mean_of = 7;
    if (code == Reply::scan || code == Reply::mean_scan || code == Reply::s14_scan) {
      scan.values.resize(181);
    } else {
      scan.beams = {{11, 20}};
      if (code == Reply::reflectivity_scan) scan.beams.push_back({100, 100, true});
      scan.values.resize(code == Reply::reflectivity_scan ? 11 : 10);
    }
    for (auto& v : scan.values) v = static_cast<std::uint16_t>(random.below(65536));
    if (code == Reply::fields_scan) scan.fields.assign(10, {1, 0, 65535});
    if (code == Reply::reflectivity_scan) scan.reflectivities.assign(11, 12345);
    if (code == Reply::s14_scan) {
      scan.reflectivities.assign(50, 200);
      scan.reflectivity_beams = {31, 80};
    }
    all.push_back(scan);
  }
  return all;
}

TEST(LmsScan, DecodingUndoesEncoding) {
  for (LmsScan scan : one_of_each()) {
    EXPECT_EQ(decode_scan(tell_scan(scan)), scan) << static_cast<int>(scan.code);
    scan.scan_index = 255;
    scan.telegram_index = 3;
    EXPECT_EQ(decode_scan(tell_scan(scan)), scan) << static_cast<int>(scan.code);
  }
}

TEST(LmsScan, WrongLengthsAndCountsAreRefused) {
  for (const LmsScan& scan : one_of_each()) {
    const Telegram right = tell_scan(scan);
    for (std::size_t n = 0; n < right.data.size() + 5; ++n) {
      // Two bytes more are the indices.
      if (n == right.data.size() || n == right.data.size() + 2) continue;
      Telegram wrong = right;
      wrong.data.resize(n);
      EXPECT_FALSE(decode_scan(wrong).has_value()) << static_cast<int>(scan.code) << ' ' << n;
    }
    Telegram host = right;
    host.status.reset();
    EXPECT_FALSE(decode_scan(host).has_value());
    host.code = 0xA0;
    EXPECT_FALSE(decode_scan(host).has_value());
  }
  Telegram empty;
  empty.code = 0xB0;
  empty.data = {0, 0};
  empty.status = 0x10;
  EXPECT_FALSE(decode_scan(empty).has_value());
}

TEST(LmsScan, AnyByteInAnyPlaceIsSurvived) {
  RandomStream random(5);
  int understood = 0;
  for (const LmsScan& scan : one_of_each()) {
    for (int i = 0; i < 3000; ++i) {
      Telegram t = tell_scan(scan);
      t.data[random.below(std::min<std::size_t>(t.data.size(), 12))] =
          static_cast<std::uint8_t>(random.below(256));
      const auto out = decode_scan(t);
      if (!out) continue;
      ++understood;
      EXPECT_EQ(tell_scan(*out).data.size(), t.data.size());
    }
  }
  EXPECT_GT(understood, 1000);
}

TEST(LmsScan, CountsThatDoNotFitCannotBeSaid) {
  EXPECT_THROW(tell_scan(LmsScan{}), Error);
  for (LmsScan scan : one_of_each()) {
    if (scan.beams.empty()) continue;
    scan.values.push_back(1);
    EXPECT_THROW(tell_scan(scan), Error);
    scan.values.resize(3);
    EXPECT_THROW(tell_scan(scan), Error);
  }
  LmsScan other = whole(181, 1, Unit::centimetre);
  other.code = Reply::mode;
  EXPECT_THROW(tell_scan(other), Error);
}

TEST(LmsScan, StatusByte) {
  EXPECT_EQ(health_of(0x10), LmsHealth{});
  EXPECT_EQ(health_of(0x11).severity, LmsHealth::Severity::info);
  EXPECT_EQ(health_of(0x14).severity, LmsHealth::Severity::fatal);
  EXPECT_TRUE(health_of(0x30).restart);
  EXPECT_TRUE(health_of(0x50).implausible);
  EXPECT_FALSE(health_of(0x50).pollution);
  EXPECT_TRUE(health_of(0x90).pollution);
}

float range_of(unsigned value, int measuring_mode, Unit unit) {
  const LmsScan scan = whole(1, static_cast<std::uint16_t>(value), unit);
  return decode_values(scan, measuring_mode).ranges[0];
}

TEST(LmsValues, DistancesByUnitAndMode) {
  EXPECT_FLOAT_EQ(range_of(1234, 0, Unit::centimetre), 12.34f);
  EXPECT_FLOAT_EQ(range_of(1234, 0, Unit::millimetre), 1.234f);
  EXPECT_FLOAT_EQ(range_of(123, 0, Unit::decimetre), 12.3f);
  // The longest of each mode, in millimetres, and the code behind it: too far.
  const int modes[8] = {0x00, 0x01, 0x02, 0x03, 0x04, 0x05, 0x06, 0x0F};
  const unsigned first_code[8] = {0x1FF7, 0x1FF7, 0x1FF7, 0x3FF7, 0x3FF7, 0x7FF7, 0x7FF7, 0x7FF7};
  for (int i = 0; i < 8; ++i) {
    const float longest = static_cast<float>(first_code[i] - 1) * 0.001f;
    EXPECT_FLOAT_EQ(range_of(first_code[i] - 1, modes[i], Unit::millimetre), longest);
    EXPECT_EQ(range_of(first_code[i], modes[i], Unit::millimetre), kNoReturn);
    const LmsValues v = decode_values(whole(1, 5, Unit::millimetre), modes[i]);
    EXPECT_GT(v.max_range, longest);
    EXPECT_LT(v.max_range, longest + 0.002f);
  }
}

TEST(LmsValues, CodesThatAreNoDistances) {
  for (const int m : {0x00, 0x04, 0x06}) {
    const unsigned first = value_layout(m)->first_code();
    for (unsigned k = 0; k < 9; ++k) {
      const float range = range_of(first + k, m, Unit::centimetre);
      if (k == 0 || k == 8) {
        EXPECT_EQ(range, kNoReturn) << k;
      } else {
        EXPECT_TRUE(std::isnan(range)) << k;
      }
    }
  }
  EXPECT_EQ(range_of(0x1FFF, 0, Unit::centimetre), kNoReturn);
  EXPECT_TRUE(std::isnan(range_of(0, 0, Unit::centimetre)));
}

TEST(LmsValues, FlagsByMode) {
  const auto flags = [](unsigned value, int m) {
    return decode_values(whole(1, static_cast<std::uint16_t>(value), Unit::centimetre), m).flags[0];
  };
  const auto level = [](unsigned value, int m) {
    return decode_values(whole(1, static_cast<std::uint16_t>(value), Unit::centimetre), m)
        .reflector[0];
  };
  EXPECT_EQ(flags(0x2001, 0), LmsValues::kFieldA);
  EXPECT_EQ(flags(0x4001, 0), LmsValues::kFieldB);
  EXPECT_EQ(flags(0x8001, 0), LmsValues::kDazzled);
  EXPECT_EQ(flags(0xE001, 1), 0);
  EXPECT_EQ(level(0xE001, 1), 7);
  EXPECT_EQ(flags(0x8001, 2), LmsValues::kFieldC);
  EXPECT_EQ(level(0xC001, 3), 3);
  EXPECT_EQ(flags(0xC001, 4), LmsValues::kFieldA | LmsValues::kFieldB);
  EXPECT_EQ(level(0x8001, 5), 1);
  EXPECT_EQ(flags(0x8001, 6), LmsValues::kFieldA);
  // The flag changes nothing about the distance, only dazzle does.
  EXPECT_FLOAT_EQ(range_of(0x6064, 0, Unit::centimetre), 1.0f);
  EXPECT_TRUE(std::isnan(range_of(0x8064, 0, Unit::centimetre)));
  EXPECT_EQ(flags(0x1FFE, 0), LmsValues::kDazzled);
}

TEST(LmsValues, ModesWithoutDistancesAreAnError) {
  EXPECT_THROW(decode_values(whole(1, 1, Unit::centimetre), 0x3F), Error);
  EXPECT_THROW(decode_values(whole(1, 1, Unit::centimetre), 0x21), Error);
  EXPECT_THROW(decode_values(whole(1, 1, static_cast<Unit>(3)), 0), Error);
}

TEST(LmsToScan, AheadIsTheMiddleAndTimeTheFirstBeam) {
  for (const Variant& v : kVariants) {
    LmsScan lms = whole(v.beams(), 500, Unit::centimetre);
    lms.values[static_cast<std::size_t>(v.beams() / 2)] = 123;
    const Scan scan = to_scan(lms, mode(0), v, kSecond);
    EXPECT_EQ(scan.time, kSecond - v.turns() * kMirrorTurn);
    EXPECT_GE(scan.time + scan_duration(v), kSecond - kMirrorTurn);  // sent when it is over,
    EXPECT_LT(scan.time + scan_duration(v), kSecond);                // and not before
    ASSERT_EQ(scan.ranges.size(), static_cast<std::size_t>(v.beams()));
    for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
      const bool middle = scan.ranges[i] < 2;
      EXPECT_EQ(middle, std::abs(scan.angle(i)) < 1e-12);
    }
    EXPECT_NEAR(scan.angle(0), -v.field_of_view * kPi / 360, 1e-12);  // begins on the right
    EXPECT_NEAR(scan.max_range, 81.83f, 1e-4);
    EXPECT_TRUE(scan.intensities.empty());
  }
}

TEST(LmsToScan, TurnsOfTheMirrorByThemselves) {
  for (int quarter = 0; quarter < 4; ++quarter) {
    LmsScan lms = whole(quarter == 0 ? 181 : 180, 500, Unit::centimetre);
    lms.partial = true;
    lms.quarter = quarter;
    const Variant set{100, 25};  // a turn has 180 degrees all the same
    const Scan scan = to_scan(lms, mode(0), set, kSecond);
    EXPECT_NEAR(scan.start_angle, radians(-90 + quarter * 0.25), 1e-12);
    EXPECT_NEAR(scan.angle_step, radians(1), 1e-12);
    const double mirror = static_cast<double>(scan.time - (kSecond - kMirrorTurn)) /
                          static_cast<double>(kMirrorTurn) * 360;
    EXPECT_NEAR(mirror, quarter * 0.25, 1e-4);
    lms.values.push_back(1);
    EXPECT_THROW(to_scan(lms, mode(0), set, 0), Error);
  }
}

TEST(LmsToScan, SomeBeamsKeepTheirPlaces) {
  const Variant v{180, 100};
  LmsScan lms;
  lms.code = Reply::reflectivity_scan;
  lms.beams = {{1, 2}, {91, 91}};
  lms.values = {100, 200, 300};
  lms.reflectivities = {10, 20, 30};
  const Scan scan = to_scan(lms, mode(0x0E), v, 0);
  ASSERT_EQ(scan.ranges.size(), 181u);
  EXPECT_FLOAT_EQ(scan.ranges[0], 1);
  EXPECT_FLOAT_EQ(scan.ranges[1], 2);
  EXPECT_FLOAT_EQ(scan.ranges[90], 3);
  EXPECT_FLOAT_EQ(scan.intensities[90], 30);
  EXPECT_EQ(
      std::count_if(scan.ranges.begin(), scan.ranges.end(), [](float r) { return std::isnan(r); }),
      178);
  lms.beams[1] = {182, 182};
  EXPECT_THROW(to_scan(lms, mode(0x0E), v, 0), Error);
}

TEST(LmsToScan, AMeanReachesBackOverAllItsScans) {
  LmsScan lms = whole(361, 500, Unit::centimetre);
  lms.code = Reply::mean_scan;
  lms.mean_of = 10;
  EXPECT_EQ(to_scan(lms, mode(0), {180, 50}, 0).time, -20 * kMirrorTurn);
}

TEST(LmsToScan, WrongNumberOfBeamsIsAnError) {
  EXPECT_FALSE(fits(whole(181, 1, Unit::centimetre), {180, 50}));
  EXPECT_THROW(to_scan(whole(181, 1, Unit::centimetre), mode(0), {180, 50}, 0), Error);
}

TEST(LmsToScan, RecordedScansOfAStandingDevice) {
  MAJAK_NEEDS_SICK_DATA();
  const Variant v{180, 50};
  std::vector<Scan> scans;
  for (const Bytes& frame : testing::sick_recorded()) {
    const auto lms = decode_scan(*decode(frame));
    if (!lms) continue;
    EXPECT_EQ(lms->values.size(), 361u);
    EXPECT_EQ(lms->unit, Unit::millimetre);
    EXPECT_FALSE(lms->partial);
    EXPECT_FALSE(lms->scan_index.has_value());
    EXPECT_EQ(encode(tell_scan(*lms)), frame);
    scans.push_back(to_scan(*lms, mode(4, Unit::millimetre), v, 0));
  }
  ASSERT_EQ(scans.size(), 22u);
  for (const Scan& scan : scans) {
    int measured = 0, alike = 0;
    for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
      if (!std::isfinite(scan.ranges[i])) continue;
      ++measured;
      EXPECT_GT(scan.ranges[i], 0.1f);
      EXPECT_LT(scan.ranges[i], 16.374f);
      // Three millimetres of noise, up to a centimetre between the steps of its clock.
      alike += std::abs(scan.ranges[i] - scans[0].ranges[i]) < 0.03f ? 1 : 0;
    }
    EXPECT_GT(measured, 340);
    EXPECT_GT(alike, measured * 9 / 10);
  }
}

}  // namespace
}  // namespace majak::sensor
