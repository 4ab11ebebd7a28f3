// SPDX-License-Identifier: Apache-2.0
#include "majak/sensor/lms_driver.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/unit/sensor/lms_wire.hpp"

namespace majak::sensor {
namespace {

constexpr Duration kMinute = 60 * kSecond;

LmsEmulatorOptions booted(int baud = 9600) {
  LmsEmulatorOptions o = lms291_s05();
  o.booted = true;
  o.baud = baud;
  return o;
}

/// Ten scans within `most`, each one that the device measured.
void expect_flows(Wire& wire, Duration most, const std::string& what) {
  const std::size_t before = wire.arrived.size();
  const Time began = wire.now;
  wire.run(began + most, before + 10);
  EXPECT_GE(wire.arrived.size(), before + 10)
      << what << ": " << wire.driver.activity() << " after " << to_seconds(wire.now - began);
  for (std::size_t i = before; i < wire.arrived.size(); ++i)
    EXPECT_TRUE(wire.was_measured(wire.arrived[i])) << what << " scan " << i;
}

TEST(LmsDriver, FindsTheDeviceAtAnyRate) {
  for (const int baud : kBauds) {
    Wire wire(booted(baud));
    expect_flows(wire, 20 * kSecond, std::to_string(baud));
    EXPECT_EQ(wire.driver.baud(), std::max(baud, 38400));
    EXPECT_EQ(wire.device.baud(), wire.driver.baud());
    EXPECT_EQ(wire.driver.device().identity->model, "LMS291");
  }
}

TEST(LmsDriver, DeliversEveryVariantInEveryUnitAtEveryRate) {
  for (const int baud : kBauds)
    for (const Variant& variant : kVariants)
      for (const Unit unit : {Unit::centimetre, Unit::millimetre}) {
        LmsDriverOptions wanted;
        wanted.baud = baud;
        wanted.variant = variant;
        wanted.unit = unit;
        Wire wire(booted(38400), wanted);
        const std::string what = std::to_string(baud) + " " +
                                 std::to_string(variant.field_of_view) + "/" +
                                 std::to_string(variant.resolution);
        expect_flows(wire, kMinute, what);
        if (wire.arrived.size() < 10) continue;
        EXPECT_EQ(wire.device.baud(), baud) << what;
        EXPECT_EQ(wire.device.variant(), variant) << what;
        EXPECT_EQ(wire.device.configuration().unit(), unit) << what;
        EXPECT_EQ(wire.device.counts().writes, unit == Unit::centimetre ? 0 : 1);
        const std::size_t from = wire.arrived.size();
        wire.run(wire.now + 30 * kSecond, from + 60);
        const double rate = static_cast<double>(wire.arrived.size() - from) /
                            to_seconds(wire.arrived.back().at - wire.arrived[from - 1].at);
        EXPECT_NEAR(rate, delivered_rate(variant, baud), 0.01 * rate) << what;
      }
}

TEST(LmsDriver, TimesAreThoseOfTheFirstBeam) {
  for (const int baud : {38400, 500000}) {
    LmsDriverOptions wanted;
    wanted.baud = baud;
    Wire wire(booted(38400), wanted);
    wire.run(kMinute);
    ASSERT_GT(wire.arrived.size(), 200U);
    double worst = 0;
    for (std::size_t i = wire.arrived.size() / 4; i < wire.arrived.size(); ++i)
      worst = std::max(worst, wire.off(wire.arrived[i]));
    EXPECT_LT(worst, 1e-4) << baud;
  }
}

TEST(LmsDriver, ADeviceThatStreamsAlreadyIsTaken) {
  for (const int baud : kBauds) {
    LmsEmulatorOptions device = booted(baud);
    device.mode = Mode::continuous;
    Wire wire(device);
    expect_flows(wire, 20 * kSecond, std::to_string(baud));
  }
}

TEST(LmsDriver, ADeviceThatBootsIsWaitedFor) {
  for (const Duration boot : {kSecond, 20 * kSecond, 60 * kSecond}) {
    LmsEmulatorOptions device = lms291_s05();
    device.boot = boot;
    Wire wire(device);
    expect_flows(wire, boot + 20 * kSecond, "boot");
    EXPECT_EQ(wire.driver.report().entries().count("the device has restarted"), 0U);
  }
}

TEST(LmsDriver, AnyAddressAndOldFirmwareAreTaken) {
  LmsEmulatorOptions device = booted();
  device.address = 1;
  device.configuration = LmsConfiguration::factory(LmsConfiguration::kOldSize);
  LmsDriverOptions wanted;
  wanted.unit = Unit::millimetre;
  Wire wire(device, wanted);
  expect_flows(wire, 20 * kSecond, "address 1");
  EXPECT_EQ(wire.driver.device().address, 0x81);
  EXPECT_EQ(wire.device.configuration().unit(), Unit::millimetre);
  EXPECT_EQ(wire.device.configuration().raw.size(), LmsConfiguration::kOldSize);
}

TEST(LmsDriver, TheEepromIsWrittenOnlyWhereItDiffers) {
  LmsDriverOptions wanted;
  wanted.unit = Unit::centimetre;
  wanted.measuring_mode = 0;
  Wire same(booted(), wanted);
  expect_flows(same, 20 * kSecond, "same");
  EXPECT_EQ(same.device.counts().writes, 0);
  wanted.measuring_mode = 6;
  wanted.real_time_indices = true;
  Wire other(booted(), wanted);
  expect_flows(other, 20 * kSecond, "other");
  EXPECT_EQ(other.device.counts().writes, 1);
  EXPECT_EQ(other.device.configuration().measuring_mode(), 6);
  EXPECT_TRUE(other.arrived.back().delivery.scan.scan_index.has_value());
}

TEST(LmsDriver, WhatTheDeviceRefusesStaysAsItIs) {
  LmsDriverOptions wanted;
  wanted.variant = Variant{180, 25};  // no device has it
  wanted.unit = Unit::millimetre;
  wanted.password = "WRONG___";
  Wire wire(booted(), wanted);
  expect_flows(wire, 30 * kSecond, "refused");
  EXPECT_EQ(wire.device.variant(), (Variant{180, 50}));
  EXPECT_EQ(wire.device.counts().writes, 0);
  EXPECT_GE(wire.driver.report().entries().size(), 2U);
}

TEST(LmsDriver, InterlacedTurnsArriveOneByOne) {
  LmsDriverOptions wanted;
  wanted.interlaced = true;
  wanted.baud = 500000;
  Wire wire(booted(), wanted);
  wire.run(kMinute, 100);
  ASSERT_EQ(wire.arrived.size(), 100U);
  for (const auto& a : wire.arrived) {
    EXPECT_TRUE(a.delivery.scan.partial);
    EXPECT_NEAR(a.scan.angle_step, radians(1.0), 1e-9);
  }
}

// ---- Faults ---------------------------------------------------------------------------------

TEST(LmsDriver, CommandsThatAreLostOrDamagedAreSaidAgain) {
  LmsFaults faults;
  faults.swallow_every = 2;
  Wire deaf(booted(), {}, faults);
  expect_flows(deaf, 30 * kSecond, "swallowed");
  faults = {};
  faults.nak_first = 3;
  Wire noisy(booted(), {}, faults);
  expect_flows(noisy, 30 * kSecond, "NAK");
}

TEST(LmsDriver, ARestartSetsEverythingAnew) {
  LmsFaults faults;
  faults.reset_at = 15;
  LmsDriverOptions wanted;
  wanted.variant = Variant{100, 100};
  wanted.baud = 500000;
  Wire wire(booted(), wanted, faults);
  wire.run(15 * kSecond);
  ASSERT_GT(wire.arrived.size(), 100U);
  expect_flows(wire, 20 * kSecond, "after the restart");
  EXPECT_EQ(wire.device.variant(), (Variant{100, 100}));
  EXPECT_EQ(wire.device.baud(), 500000);
}

TEST(LmsDriver, ARestartIsToldWhereTheBootIsHeard) {
  LmsFaults faults;
  faults.reset_at = 15;
  LmsEmulatorOptions device = booted(38400);
  device.permanent_baud = true;
  device.boot = kSecond / 2;
  Wire wire(device, {}, faults);
  const auto told = [&] {
    return wire.driver.report().entries().count("the device has restarted");
  };
  wire.run(15 * kSecond);
  EXPECT_EQ(told(), 0U);
  expect_flows(wire, 20 * kSecond, "after the restart");
  EXPECT_EQ(told(), 1U);
}

TEST(LmsDriver, ADeviceThatHangsOrIsUnpluggedComesBack) {
  LmsFaults faults;
  faults.hang_at = 10;
  Wire hangs(booted(), {}, faults);
  hangs.run(15 * kSecond);
  expect_flows(hangs, 15 * kSecond, "hung");
  faults = {};
  faults.unplug_at = 10;
  Wire unplugged(booted(), {}, faults);
  unplugged.run(12 * kSecond);
  expect_flows(unplugged, 15 * kSecond, "unplugged");
}

TEST(LmsDriver, DamagedTelegramsAreLeftOutAndNothingElse) {
  const auto with = [](double LmsFaults::*fault) {
    LmsFaults f;
    f.*fault = 0.3;
    return f;
  };
  for (const LmsFaults& faults :
       {with(&LmsFaults::truncate), with(&LmsFaults::noise), with(&LmsFaults::handshakes),
        with(&LmsFaults::wrong_length), with(&LmsFaults::odd_count)}) {
    Wire wire(booted(38400), {}, faults);
    wire.run(60 * kSecond);
    EXPECT_GT(wire.arrived.size(), 130U);  // of about 270
    for (const auto& a : wire.arrived) EXPECT_LT(wire.off(a), 0.02);
  }
}

TEST(LmsDriver, WithOneByteInAThousandLostNearlyHalfTheScansArriveAndNoWrongOne) {
  LmsFaults faults;
  faults.drop = 1e-3;
  LmsDriverOptions wanted;
  wanted.baud = 500000;
  Wire wire(booted(500000), wanted, faults);
  wire.run(120 * kSecond);
  EXPECT_GT(static_cast<double>(wire.arrived.size()),
            0.45 * static_cast<double>(wire.device.counts().scans));
  for (const auto& a : wire.arrived) EXPECT_LT(wire.off(a), 0.02);
}

TEST(LmsDriver, FlippedAndDoubledBytesNeverMakeAScan) {
  LmsFaults faults;
  faults.flip = 5e-4;
  faults.duplicate = 5e-4;
  Wire wire(booted(500000), {}, faults);
  wire.run(60 * kSecond);
  EXPECT_GT(wire.arrived.size(), 500U);
  for (const auto& a : wire.arrived) EXPECT_LT(wire.off(a), 0.02);
}

TEST(LmsDriver, NothingAtTheOtherEndIsLookedForWithoutEnd) {
  LmsEmulatorOptions device = lms291_s05();
  device.boot = 100 * kMinute;
  Wire wire(device);
  wire.run(5 * kMinute);
  EXPECT_EQ(wire.driver.state(), LmsDriver::State::searching);
  EXPECT_TRUE(wire.arrived.empty());
}

TEST(LmsDriver, EqualRunsAreEqual) {
  const auto run = [] {
    LmsFaults faults;
    faults.drop = 1e-3;
    Wire wire(booted(), {}, faults);
    wire.run(20 * kSecond);
    std::vector<Time> stamps;
    for (const auto& a : wire.arrived) stamps.push_back(a.scan.time);
    return stamps;
  };
  EXPECT_EQ(run(), run());
}

}  // namespace
}  // namespace majak::sensor
