// SPDX-License-Identifier: Apache-2.0
// What goes wrong with the emulated device when it is asked to, and that nothing else does.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "emulated_host.hpp"
#include "majak/core/random.hpp"
#include "majak/sensor/lms_emulator.hpp"

namespace majak::sensor {
namespace {

using testing::all_at;
using testing::booted;
using testing::Host;
using testing::kMs;

LmsEmulatorOptions streaming() {
  LmsEmulatorOptions o = booted();
  o.baud = 500000;
  o.mode = Mode::continuous;
  return o;
}

std::string text(const std::vector<std::uint16_t>& values) {
  std::string out;
  for (const std::uint16_t v : values) {
    out += static_cast<char>(v & 0xFF);
    out += static_cast<char>(v >> 8);
  }
  return out;
}

/// Scans that are all different, and a list of them.
struct World {
  std::set<std::string> scans;
  RandomStream random{42};

  std::vector<double> operator()(const Variant& v) {
    std::vector<double> out;
    std::vector<std::uint16_t> values;
    for (int i = 0; i < v.beams(); ++i) {
      values.push_back(static_cast<std::uint16_t>(50 + random.below(3000)));
      out.push_back(values.back() * 0.01);
    }
    scans.insert(text(values));
    return out;
  }
};

/// How a stream of so many seconds comes through with these faults.
struct Outcome {
  std::int64_t sent = 0;
  std::int64_t right = 0, wrong = 0;
  std::size_t bytes = 0;
  TelegramFramer::Counts framer;
};

Outcome stream_with(const LmsFaults& faults, Duration duration = 10 * kSecond) {
  World world;
  Host host(streaming(), [&](Time, const Variant& v) { return world(v); });
  host.device.set_faults(faults);
  Outcome out;
  host.wait(duration);
  for (const Frame& f : host.telegrams(Reply::scan)) {
    const auto scan = decode_scan(f.telegram);
    ++(scan && world.scans.contains(text(scan->values)) ? out.right : out.wrong);
  }
  for (const Chunk& c : host.chunks) out.bytes += c.bytes.size();
  out.sent = host.device.counts().scans;
  out.framer = host.framer.counts();
  return out;
}

TEST(LmsFaults, NoneIsNone) {
  const Outcome out = stream_with({});
  EXPECT_NEAR(static_cast<double>(out.sent), 375, 2);
  EXPECT_GE(out.right, out.sent - 1);
  EXPECT_EQ(out.wrong, 0);
  EXPECT_EQ(out.framer.skipped_bytes, 0);
}

TEST(LmsFaults, LostBytesLeaveAtLeast45Percent) {
  LmsFaults faults;
  faults.drop = 0.001;
  const Outcome out = stream_with(faults, 30 * kSecond);
  EXPECT_GT(out.right, out.sent * 45 / 100);
  EXPECT_LT(out.right, out.sent * 52 / 100);
  EXPECT_EQ(out.wrong, 0);
  const double sent = 732 * (static_cast<double>(out.sent) - 0.5);  // the last one is under way
  EXPECT_NEAR(static_cast<double>(out.bytes) / sent, 0.999, 0.0008);
}

TEST(LmsFaults, DoubledAndFlippedBytes) {
  LmsFaults twice, flipped;
  twice.duplicate = flipped.flip = 0.001;
  for (const LmsFaults& faults : {twice, flipped}) {
    const Outcome out = stream_with(faults);
    EXPECT_GT(out.right, out.sent * 40 / 100);
    EXPECT_LT(out.right, out.sent * 56 / 100);
    EXPECT_EQ(out.wrong, 0);
  }
  EXPECT_GT(stream_with(twice).bytes, stream_with(flipped).bytes);
}

TEST(LmsFaults, TruncatedScansCostOnlyThemselves) {
  LmsFaults faults;
  faults.truncate = 0.25;
  const Outcome out = stream_with(faults);
  EXPECT_GT(out.right, out.sent * 65 / 100);
  EXPECT_LT(out.right, out.sent * 85 / 100);
  EXPECT_EQ(out.wrong, 0);
}

TEST(LmsFaults, NoiseWithFalseHeadersCostsNothing) {
  LmsFaults faults;
  faults.noise = 0.5;
  faults.handshakes = 0.5;
  const Outcome out = stream_with(faults);
  EXPECT_GE(out.right, out.sent - 2);
  EXPECT_EQ(out.wrong, 0);
  EXPECT_GT(out.framer.skipped_bytes, 1000);
  EXPECT_GT(out.framer.crc_errors, 100);
}

TEST(LmsFaults, WrongLengthsAreRefused) {
  LmsFaults faults;
  faults.wrong_length = 0.3;
  const Outcome out = stream_with(faults);
  EXPECT_EQ(out.wrong, 0);
  EXPECT_GT(out.right, out.sent * 55 / 100);
  EXPECT_LT(out.right, out.sent * 85 / 100);
}

TEST(LmsFaults, OddCountsDoNotFitTheVariant) {
  LmsEmulatorOptions o = streaming();
  LmsFaults faults;
  faults.odd_count = 0.5;
  Host host(o);
  host.device.set_faults(faults);
  host.wait(5 * kSecond);
  int fitting = 0, odd = 0;
  for (const Frame& f : host.telegrams(Reply::scan)) {
    ++(fits(*decode_scan(f.telegram), o.variant) ? fitting : odd);
  }
  EXPECT_GT(fitting, 60);
  EXPECT_GT(odd, 60);
}

TEST(LmsFaults, DazzleIsABurstOfInvalidBeams) {
  LmsFaults faults;
  faults.dazzle = 1;
  Host host(streaming());
  host.device.set_faults(faults);
  host.wait(5 * kSecond);
  ASSERT_GT(host.telegrams(Reply::scan).size(), 100u);
  for (const Frame& f : host.telegrams(Reply::scan)) {
    const LmsValues values = decode_values(*decode_scan(f.telegram), 0);
    const auto dazzled = std::count(values.flags.begin(), values.flags.end(), LmsValues::kDazzled);
    EXPECT_GE(dazzled, 1);
    EXPECT_LE(dazzled, 34);
    EXPECT_EQ(dazzled, std::count_if(values.ranges.begin(), values.ranges.end(),
                                     [](float r) { return std::isnan(r); }));
  }
}

TEST(LmsFaults, StatusOfEveryTelegram) {
  LmsFaults dirty, implausible, fatal;
  dirty.pollution = implausible.implausible = fatal.fatal = true;
  const auto health = [](const LmsFaults& faults) {
    Host host(booted());
    host.device.set_faults(faults);
    const LmsHealth of_scan = decode_scan(host.answer(ask_scan(), 2 * kSecond))->health();
    EXPECT_EQ(health_of(*host.answer(ask(Command::type)).status), of_scan);
    return of_scan;
  };
  EXPECT_EQ(health({}), LmsHealth{});
  EXPECT_TRUE(health(dirty).pollution);
  EXPECT_EQ(health(dirty).severity, LmsHealth::Severity::warning);
  EXPECT_TRUE(health(implausible).implausible);
  EXPECT_EQ(health(fatal).severity, LmsHealth::Severity::fatal);
}

TEST(LmsFaults, SwallowedCommands) {
  LmsFaults faults;
  faults.swallow_every = 3;
  Host host(booted());
  host.device.set_faults(faults);
  std::string heard;
  for (int i = 0; i < 6; ++i) heard += host.ask(ask(Command::type)).empty() ? '-' : '+';
  EXPECT_EQ(heard, "++-++-");
}

TEST(LmsFaults, NakForTheFirstOnes) {
  LmsFaults faults;
  faults.nak_first = 2;
  Host host(booted());
  host.device.set_faults(faults);
  for (int i = 0; i < 2; ++i) {
    const auto heard = host.ask(ask(Command::type));
    ASSERT_EQ(heard.size(), 1u);
    EXPECT_EQ(heard[0].kind, Frame::Kind::nak);
  }
  EXPECT_TRUE(host.answer(ask(Command::type)).is(Reply::identity));
  EXPECT_EQ(host.device.counts().naks, 2);
}

TEST(LmsFaults, ResetInMidStream) {
  LmsFaults faults;
  faults.reset_at = 3;
  Host host(streaming());
  host.device.set_faults(faults);
  host.wait(2990 * kMs);
  const std::size_t before = host.telegrams(Reply::scan).size();
  EXPECT_GT(before, 100u);
  host.frames.clear();
  host.wait(7 * kSecond);
  EXPECT_LE(host.telegrams(Reply::scan).size(), 1u);
  EXPECT_TRUE(host.telegrams(Reply::power_on_identity).empty());  // at 9600, and we are at 500000
  EXPECT_EQ(host.device.baud(), 9600);
  EXPECT_EQ(host.device.counts().restarts, 1);
  host.baud = 9600;
  EXPECT_TRUE(host.answer(ask(Command::type)).is(Reply::identity));
}

TEST(LmsFaults, HangAndComeBack) {
  LmsFaults faults;
  faults.hang_at = 1;
  faults.hang_for = 2;
  Host host(streaming());
  host.device.set_faults(faults);
  host.wait(1100 * kMs);
  host.chunks.clear();
  host.say(ask_mode(Mode::on_request));  // is not heard
  host.wait(1800 * kMs);
  EXPECT_TRUE(host.chunks.empty());
  host.wait(kSecond);
  EXPECT_FALSE(host.chunks.empty());
}

TEST(LmsFaults, UnplugAndReplug) {
  LmsFaults faults;
  faults.unplug_at = 1;
  faults.unplug_for = 2;
  Host host(streaming());
  host.device.set_faults(faults);
  host.wait(kSecond + kMs);
  EXPECT_TRUE(host.device.unplugged(host.now));
  host.frames.clear();
  host.say(ask_mode(Mode::on_request));
  host.wait(1900 * kMs);
  EXPECT_TRUE(host.frames.empty());
  EXPECT_EQ(host.device.counts().commands, 0);
  host.wait(kSecond);
  EXPECT_FALSE(host.device.unplugged(host.now));
  EXPECT_GT(host.telegrams(Reply::scan).size(), 10u);  // it went on without us
}

TEST(LmsFaults, DescribeThemselves) {
  LmsFaults faults;
  OptionFields fields;
  describe(fields, faults);
  EXPECT_EQ(fields.list.size(), 19u);
  std::set<std::string> names;
  for (const OptionField& f : fields.list) {
    names.insert(f.name);
    if (const auto* number = std::get_if<double*>(&f.value)) {
      EXPECT_GE(**number, f.info.min) << f.name;
      EXPECT_LE(**number, f.info.max) << f.name;
    }
  }
  EXPECT_EQ(names.size(), fields.list.size());
}

// ---- The line itself. --------------------------------------------------------------------------

TEST(LmsUart, BytesLeaveAtTheBaud) {
  LmsUart uart({0, kSecond, 508}, RandomStream(1));
  uart.set_baud(9600);
  uart.send({{1, 2, 3}, 5 * kMs});
  EXPECT_EQ(uart.next(), 5 * kMs + 10 * kSecond / 9600);
  EXPECT_FALSE(uart.advance(5 * kMs).has_value());
  EXPECT_TRUE(uart.take().empty());
  uart.advance(kSecond);
  const auto chunks = uart.take();
  ASSERT_EQ(chunks.size(), 1u);
  EXPECT_EQ(chunks[0].begin, 5 * kMs);
  EXPECT_EQ(chunks[0].end(), 5 * kMs + 3 * (10 * kSecond / 9600));
  EXPECT_TRUE(uart.idle());
}

TEST(LmsUart, FullTurnsWait) {
  LmsUart uart({0, 10 * kMs, 4}, RandomStream(1));
  uart.set_baud(500000);
  uart.send({{1, 2, 3, 4, 5, 6}, 3 * kMs});
  uart.advance(kSecond);
  const auto chunks = uart.take();
  ASSERT_EQ(chunks.size(), 2u);
  EXPECT_EQ(chunks[0].bytes.size(), 4u);
  EXPECT_EQ(chunks[1].begin, 10 * kMs);
}

TEST(LmsUart, CutKeepsHandshakesAndTheByteUnderWay) {
  LmsUart uart({0, kSecond, 508}, RandomStream(1));
  uart.set_baud(10000);  // a byte a millisecond
  uart.send({{1, 2, 3, 4}, 0});
  uart.send({{9}, 0, true});
  uart.send({{}, 0, false, LmsUart::After::set_baud, 38400});
  EXPECT_FALSE(uart.advance(3 * kMs / 2).has_value());
  const auto done = uart.cut(3 * kMs / 2);
  ASSERT_EQ(done.size(), 1u);  // what was to be done is not forgotten
  EXPECT_EQ(done[0].baud, 38400);
  EXPECT_FALSE(uart.advance(kSecond).has_value());
  std::vector<std::uint8_t> all;
  for (const Chunk& c : uart.take()) all.insert(all.end(), c.bytes.begin(), c.bytes.end());
  EXPECT_THAT(all, ::testing::ElementsAre(1, 2, 9));
  EXPECT_TRUE(uart.idle());
}

TEST(LmsUart, WhatIsToBeDoneWaitsForItsTime) {
  LmsUart uart({0, kSecond, 508}, RandomStream(1));
  uart.send({{}, 10 * kMs, false, LmsUart::After::reset, 0});
  EXPECT_EQ(uart.next(), 10 * kMs);
  EXPECT_FALSE(uart.advance(9 * kMs).has_value());
  const auto done = uart.advance(kSecond);
  ASSERT_TRUE(done.has_value());
  EXPECT_EQ(done->at, 10 * kMs);
  EXPECT_EQ(done->after, LmsUart::After::reset);
}

TEST(LmsUart, LostBytesLeaveAGapInTime) {
  LmsUart uart({0, kSecond, 508}, RandomStream(3));
  uart.set_baud(10000);
  uart.set_faults({0.3, 0, 0});
  std::vector<std::uint8_t> bytes(100);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i);
  uart.send({bytes, 0});
  uart.advance(kSecond);
  std::size_t count = 0;
  for (const Chunk& c : uart.take()) {
    for (std::size_t i = 0; i < c.bytes.size(); ++i) {
      ++count;
      EXPECT_EQ(c.left(i), (c.bytes[i] + 1) * kMs);  // its place in time is its own
    }
  }
  EXPECT_GT(count, 50u);
  EXPECT_LT(count, 90u);
}

}  // namespace
}  // namespace majak::sensor
