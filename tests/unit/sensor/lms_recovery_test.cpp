// SPDX-License-Identifier: Apache-2.0
// How long it takes from the end of a fault to the first scan that is measured after it. What it
// may take is a sum of times of the telegram listing, each with a reason at its row.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "tests/unit/sensor/lms_wire.hpp"

namespace majak::sensor {
namespace {

// s. At 38400 Bd a scan comes every 213 ms. The telegram that is under way when the fault ends does
// not count, the next one does as soon as it is through.
constexpr double kNextScan = 2 * 0.213;
// 20 25, 3A, 31, 74, 20 24: an ACK each within 60 ms, and the answer as long after it (31 takes
// 110 ms); then the next scan.
constexpr double kSetUp = 5 * 0.12 + kNextScan;
// At 9600 Bd 31 alone takes 170 ms; then 20 40, 300 ms of rest and 31 again, at 38400 Bd.
constexpr double kSetUpSlow = kSetUp + 0.06 + 0.12 + 0.3 + 0.12;
// A rate is tried twice, 350 ms each, with 20 ms before and 8 bytes at 9600 Bd.
constexpr double kTry = 0.74;
constexpr double kOthers = 3 * kTry;  // the three other rates had just come to their turn
constexpr double kSilence = 1.0;      // max(1 s, 4 periods) without a scan
constexpr double kSaidAgain = 0.22;   // no ACK within 60 ms, and the way of a USB adapter
constexpr double kMode = 3, kAck = 0.06, kWrite = 7;
constexpr double kModeWait = kMode + 0.3;  // with room for an adapter

enum class When { always, in_stream, while_asking };

struct Row {
  const char* what;
  LmsFaults faults;  ///< times in it count from where it begins
  When when;
  double lasts;  ///< s, then all is well again
  double bound;  ///< s
  const char* why;
  LmsEmulatorOptions device;
  LmsDriverOptions wanted = {};
  double digit = 0.01;  ///< m
};

LmsEmulatorOptions booted(int baud = 38400, Duration boot = 2 * kSecond) {
  LmsEmulatorOptions o = lms291_s05();
  o.booted = true;
  o.baud = baud;
  o.boot = boot;
  return o;
}

template <typename T>
LmsFaults with(T LmsFaults::*fault, T value) {
  LmsFaults faults;
  faults.*fault = value;
  return faults;
}

LmsFaults hang(double seconds) {
  LmsFaults faults = with(&LmsFaults::hang_at, 0.0);
  faults.hang_for = seconds;
  return faults;
}

LmsFaults unplug(double seconds) {
  LmsFaults faults = with(&LmsFaults::unplug_at, 0.0);
  faults.unplug_for = seconds;
  return faults;
}

/// s; infinite if it never comes back. `phase`: s, by which the fault begins and ends later.
double recovery(const Row& row, double phase) {
  Wire wire(row.device, row.wanted);
  wire.digit = row.digit;
  double begin = 0;
  if (row.when == When::in_stream) begin = 6 + phase;
  if (row.when == When::while_asking) begin = 0.01 + phase;
  wire.run(from_seconds(begin));
  EXPECT_TRUE(row.when != When::in_stream || wire.arrived.size() >= 3) << row.what;
  LmsFaults faults = row.faults;
  for (double* at : {&faults.reset_at, &faults.hang_at, &faults.unplug_at})
    if (*at >= 0) *at = begin;
  wire.device.set_faults(faults);
  Time over = from_seconds(begin);
  if (row.lasts > 0) {
    wire.run(over = from_seconds(begin + row.lasts));
    wire.device.set_faults({});
  }
  const auto later = [&](const Wire::Arrival& a) { return a.delivery.first_byte >= over; };
  std::size_t first = wire.arrived.size();
  for (std::size_t seen = first; first == seen && wire.now < over + 200 * kSecond; ++seen) {
    wire.run(over + 200 * kSecond, seen + 1);
    if (seen < wire.arrived.size() && !later(wire.arrived[seen])) ++first;
  }
  wire.run(wire.now + kSecond, first + 3);
  if (wire.arrived.size() < first + 3) return INFINITY;  // not one, and nothing again
  for (std::size_t i = first; i < first + 3; ++i)
    EXPECT_TRUE(row.faults.dazzle > 0 || wire.was_measured(wire.arrived[i])) << row.what;
  return to_seconds(wire.arrived[first].at - over);
}

/// The longest of several that meet the beats of scans and of the search otherwise.
double longest_recovery(const Row& row) {
  double longest = 0;
  for (int i = 0; i < 8; ++i) longest = std::max(longest, recovery(row, 0.371 * i));
  return longest;
}

LmsEmulatorOptions changed(const std::function<void(LmsEmulatorOptions&)>& change,
                           LmsEmulatorOptions device = booted(9600)) {
  change(device);
  return device;
}

/// What is damaged on the way, or measured badly.
std::vector<Row> telegram_rows() {
  constexpr double kFew = 0.02;  // of all bytes: no telegram of 732 is whole, those of 10 are
  // No scan for a second, so the device is looked for - or the answer to a change of mode, which
  // was damaged, may still be on its way for all the driver knows.
  const auto damage = [](const char* what, double LmsFaults::*fault, double share) {
    return Row{what,
               with(fault, share),
               When::in_stream,
               3,
               std::max(kOthers, kModeWait) + kSetUp,
               "looked for, or waited for",
               booted()};
  };
  const auto harmless = [](const char* what, const LmsFaults& faults) {
    return Row{what, faults, When::in_stream, 3, kNextScan, "no scan is lost", booted()};
  };
  return {damage("bytes lost", &LmsFaults::drop, kFew),
          damage("bytes doubled", &LmsFaults::duplicate, kFew),
          damage("bits flipped", &LmsFaults::flip, kFew),
          damage("scans truncated", &LmsFaults::truncate, 1),
          damage("wrong lengths", &LmsFaults::wrong_length, 1),
          damage("odd counts", &LmsFaults::odd_count, 1),
          harmless("noise with 02 80", with(&LmsFaults::noise, 1.0)),
          harmless("spurious 06 and 15", with(&LmsFaults::handshakes, 1.0)),
          harmless("dazzle", with(&LmsFaults::dazzle, 1.0)),
          harmless("pollution", with(&LmsFaults::pollution, true)),
          harmless("implausible", with(&LmsFaults::implausible, true)),
          harmless("fatal", with(&LmsFaults::fatal, true))};
}

/// The device or its cable is gone for a while.
std::vector<Row> absence_rows() {
  const auto reset = with(&LmsFaults::reset_at, 0.0);
  constexpr double kBack = kOthers + kTry + kSetUpSlow;
  LmsEmulatorOptions permanent = booted();
  permanent.permanent_baud = true;
  return {
      {"restart, 2 s", reset, When::in_stream, 0, 2 + kBack, "boot, 9600 Bd, all anew", booted()},
      {"restart, 60 s", reset, When::in_stream, 0, 60 + kBack, "boot, 9600 Bd, all anew",
       booted(38400, 60 * kSecond)},
      {"restart, baud kept", reset, When::in_stream, 0, 2 + kOthers + kTry + kSetUp,
       "boot, all anew", permanent},
      {"restart while asked", reset, When::while_asking, 0, 2 + kModeWait + kBack,
       "it may have said ACK: what was asked is waited for", booted()},
      {"hangs 0.5 s", hang(1e3), When::in_stream, 0.5, kNextScan, "is not even missed", booted()},
      {"hangs 5 s", hang(1e3), When::in_stream, 5, kOthers + kTry + kSetUp, "looked for", booted()},
      {"hangs 60 s", hang(1e3), When::in_stream, 60, kOthers + kTry + kSetUp, "looked for",
       booted()},
      {"hangs while asked", hang(1e3), When::while_asking, 5, kOthers + kTry + kSetUpSlow,
       "looked for", booted()},
      {"unplugged 2 s", unplug(1e3), When::in_stream, 2, kTry + kSetUp, "last rate first",
       booted()},
      {"unplugged 60 s", unplug(1e3), When::in_stream, 60, kTry + kSetUp, "last rate first",
       booted()},
  };
}

/// From the start of the driver.
std::vector<Row> peculiarity_rows() {
  constexpr double kFrom9600 = 2 * kTry + kSetUpSlow;  // 38400 and 500000 Bd are tried first
  constexpr int kCommands = 7;
  const auto row = [](const char* what, const LmsFaults& faults, double bound, const char* why,
                      const LmsEmulatorOptions& device) {
    return Row{what, faults, When::always, 0, bound, why, device};
  };
  std::vector<Row> rows{
      row("nothing", {}, kSetUp, "the rate is the first one tried", booted()),
      row("commands swallowed", with(&LmsFaults::swallow_every, 2),
          kFrom9600 + kTry / 2 + (kCommands - 1) * kSaidAgain, "each is said twice", booted(9600)),
      row("NAK, 3 times", with(&LmsFaults::nak_first, 3), kFrom9600 + 3 * 0.06,
          "30 ms after a NAK it is said again", booted(9600)),
      row("address 81", {}, kFrom9600, "as any other", changed([](auto& d) { d.address = 1; })),
      row("32 bytes", {}, kFrom9600, "as any other", changed([](auto& d) {
            d.configuration = LmsConfiguration::factory(LmsConfiguration::kOldSize);
          })),
      row("decimetres", {}, kFrom9600, "as any other",
          changed([](auto& d) { d.configuration.set_unit(Unit::decimetre); })),
      row("slowest", {}, kSetUp + 5 * kAck + 2 * kMode, "20 25 and 20 24 take 3 s each",
          changed(
              [](auto& d) {
                d.ack_delay = from_seconds(kAck);
                d.mode_delay = from_seconds(kMode);
              },
              booted())),
      row("slowest EEPROM", {}, kSetUp + 3 * 0.12 + kWrite, "and 20 00, 77, 20 25",
          changed([](auto& d) { d.write_delay = from_seconds(kWrite); }, booted())),
  };
  rows[rows.size() - 3].digit = 0.1;
  rows.back().digit = 0.001;
  rows.back().wanted.unit = Unit::millimetre;
  return rows;
}

void expect_within(const std::vector<Row>& rows) {
  for (const Row& row : rows) {
    const double s = longest_recovery(row);
    EXPECT_LE(s, row.bound) << row.what << ": " << row.why;
  }
}

TEST(LmsRecovery, EachFaultWithinTheDocumentsTime) {
  expect_within(telegram_rows());
  expect_within(absence_rows());
  expect_within(peculiarity_rows());
}

// The device sends what nobody set it to, for ever: it is asked anew what it is.
TEST(LmsRecovery, AVariantThatAnotherProgramHasSet) {
  Wire wire(booted());
  wire.run(6 * kSecond);
  ASSERT_GT(wire.arrived.size(), 3U);
  wire.device.receive(encode(ask_variant({100, 100})), 38400, wire.now);
  const std::size_t before = wire.arrived.size();
  wire.run(wire.now + from_seconds(kSilence + kSetUp), before + 3);
  ASSERT_GE(wire.arrived.size(), before + 3);
  EXPECT_EQ(wire.driver.device().variant, (Variant{100, 100}));
  EXPECT_TRUE(wire.was_measured(wire.arrived.back()));
}

}  // namespace
}  // namespace majak::sensor
