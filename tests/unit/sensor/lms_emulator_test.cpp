// SPDX-License-Identifier: Apache-2.0
// The emulated device: boot, commands, rates, beam times.
#include "majak/sensor/lms_emulator.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "emulated_host.hpp"
#include "majak/core/event.hpp"
#include "sick_data.hpp"

namespace majak::sensor {
namespace {

using testing::all_at;
using testing::booted;
using testing::bytes;
using testing::Host;
using testing::kMs;

TEST(LmsEmulator, BootsAndTellsItsName) {
  LmsEmulatorOptions o = lms291_s05();
  o.boot = 2 * kSecond;
  Host host(o);
  host.say(ask(Command::status));  // nobody hears
  host.wait(1990 * kMs);
  EXPECT_TRUE(host.chunks.empty());
  EXPECT_FALSE(host.device.ready());
  host.wait(100 * kMs);
  ASSERT_EQ(host.frames.size(), 1u);
  const auto identity = decode_identity(host.frames[0].telegram);
  ASSERT_TRUE(identity.has_value());
  EXPECT_TRUE(host.frames[0].telegram.is(Reply::power_on_identity));
  EXPECT_EQ(identity->model, "LMS291");
  EXPECT_EQ(identity->type, "S05");
  EXPECT_EQ(identity->text.size(), 21u);
  EXPECT_EQ(host.frames[0].first_byte, 2 * kSecond);
  EXPECT_TRUE(host.device.ready());
}

TEST(LmsEmulator, AnswersWhatItIsAsked) {
  Host host(booted());
  const auto status = decode_status(host.answer(ask(Command::status)));
  ASSERT_TRUE(status.has_value());
  EXPECT_EQ(status->mode, 0x25);
  EXPECT_EQ(status->baud, 9600);
  EXPECT_EQ(status->variant, (Variant{180, 50}));
  EXPECT_EQ(status->motor, 148);
  EXPECT_EQ(status->unit, Unit::centimetre);
  EXPECT_EQ(decode_identity(host.answer(ask(Command::type)))->model, "LMS291");
  EXPECT_EQ(decode_errors(host.answer(ask(Command::errors)))->size(), 0u);
  EXPECT_EQ(decode_counters(host.answer(ask(Command::counters)))->hours, 1234);
  EXPECT_EQ(decode_configuration(host.answer(ask(Command::configuration))),
            LmsConfiguration::factory());
  EXPECT_EQ(decode_raw(Reply::configuration_2, host.answer(ask(Command::configuration_2)))->size(),
            84u);
  EXPECT_EQ(encode(host.answer(ask(Command::outputs))), bytes("02 80 05 00 CA 01 01 01 10 2C B8"));
  EXPECT_EQ(host.device.counts().commands, 7);
  EXPECT_EQ(host.device.counts().writes, 0);
}

TEST(LmsEmulator, HandshakesComeFirstAndInTime) {
  Host host(booted());
  const Time asked = host.now + kMs;
  const auto heard = host.ask(ask(Command::type));
  ASSERT_EQ(heard.size(), 2u);
  EXPECT_EQ(heard[0].kind, Frame::Kind::ack);
  EXPECT_GT(heard[0].first_byte, asked);
  EXPECT_LE(heard[0].first_byte, asked + 60 * kMs);
  EXPECT_GT(heard[1].first_byte, heard[0].first_byte);
}

TEST(LmsEmulator, RefusesWhatItDoesNotKnow) {
  Host host(booted());
  Telegram unknown;
  unknown.code = 0x5A;
  EXPECT_TRUE(host.answer(unknown).is(Reply::refused));
  EXPECT_TRUE(host.answer(ask_mode(static_cast<Mode>(0x77))).is(Reply::refused));
  EXPECT_TRUE(host.answer(ask_mode(Mode::continuous_mean)).is(Reply::refused));  // of how many?
  EXPECT_TRUE(host.answer(ask_mode(Mode::installation)).is(Reply::refused));     // no password
  EXPECT_TRUE(host.answer(ask_subrange_scan({1, 401})).is(Reply::refused));      // 361 beams
  EXPECT_TRUE(host.answer(ask_fields_scan({1, 101})).is(Reply::refused));
  EXPECT_TRUE(host.answer(ask_s14_scan({1, 100})).is(Reply::refused));
  EXPECT_EQ(host.device.counts().refused, 7);
}

TEST(LmsEmulator, DamagedCommandsGetNakAndForeignOnesNothing) {
  Host host(booted());
  auto damaged = encode(ask(Command::status));
  damaged[4] ^= 1;
  host.device.receive(damaged, host.baud, host.now);
  host.wait(100 * kMs);
  ASSERT_EQ(host.frames.size(), 1u);
  EXPECT_EQ(host.frames[0].kind, Frame::Kind::nak);
  Telegram foreign = ask(Command::status);
  foreign.address = 5;
  EXPECT_TRUE(host.ask(foreign).empty());
  EXPECT_TRUE(host.answer(ask(Command::status)).is(Reply::status));
}

TEST(LmsEmulator, AddressOne) {
  LmsEmulatorOptions o = booted();
  o.address = 1;
  Host host(o);
  EXPECT_EQ(host.answer(ask(Command::type)).address, 0x81);
  Telegram own = ask(Command::type);
  own.address = 1;
  EXPECT_EQ(host.answer(own).address, 0x81);
}

TEST(LmsEmulator, HalfACommandIsForgottenAfterSilence) {
  Host host(booted());
  const auto command = encode(ask(Command::type));
  host.device.receive(std::span(command).first(4), host.baud, host.now);
  host.wait(40 * kMs);
  host.device.receive(std::span(command).subspan(4), host.baud, host.now);
  host.wait(200 * kMs);
  EXPECT_EQ(host.frames.size(), 2u);  // 40 ms are forgiven, as a busy host needs it
  host.frames.clear();
  host.device.receive(std::span(command).first(4), host.baud, host.now);
  host.wait(60 * kMs);
  host.device.receive(std::span(command).subspan(4), host.baud, host.now);
  host.wait(200 * kMs);
  EXPECT_TRUE(host.frames.empty());
}

TEST(LmsEmulator, VariantsAreSetOrRefused) {
  Host host(booted());
  for (const Variant& v : kVariants) {
    const auto result = decode_variant_result(host.answer(ask_variant(v)));
    EXPECT_TRUE(result->accepted);
    EXPECT_EQ(result->variant, v);
    EXPECT_EQ(host.device.variant(), v);
  }
  const auto result = decode_variant_result(host.answer(ask_variant({180, 25})));
  EXPECT_FALSE(result->accepted);
  EXPECT_EQ(result->variant, (Variant{100, 25}));
}

TEST(LmsEmulator, TheEepromIsWrittenOnlyWithThePassword) {
  for (const std::size_t size : {LmsConfiguration::kSize, LmsConfiguration::kOldSize}) {
    LmsEmulatorOptions o = booted();
    o.configuration = LmsConfiguration::factory(size);
    Host host(o);
    LmsConfiguration mm = o.configuration;
    mm.set_unit(Unit::millimetre);
    EXPECT_TRUE(host.answer(ask_write_configuration(mm)).is(Reply::refused));
    EXPECT_EQ(decode_mode_result(host.answer(ask_installation("SICK_LMX"))),
              ModeResult::wrong_password);
    EXPECT_TRUE(host.answer(ask_write_configuration(mm)).is(Reply::refused));
    EXPECT_EQ(decode_mode_result(host.answer(ask_test_password("SICK_LMS"))), ModeResult::done);
    EXPECT_TRUE(host.answer(ask_write_configuration(mm)).is(Reply::refused));
    EXPECT_EQ(host.device.counts().writes, 0);
    EXPECT_EQ(decode_mode_result(host.answer(ask_installation())), ModeResult::done);
    // The other firmware's length.
    const std::size_t other = LmsConfiguration::kSize + LmsConfiguration::kOldSize - size;
    const auto refused = decode_configuration_result(
        host.answer(ask_write_configuration(LmsConfiguration::factory(other))));
    EXPECT_FALSE(refused->accepted);
    EXPECT_EQ(refused->configuration, o.configuration);
    const auto written = decode_configuration_result(host.answer(ask_write_configuration(mm)));
    EXPECT_TRUE(written->accepted);
    EXPECT_EQ(written->configuration, mm);
    EXPECT_EQ(host.device.counts().writes, 1);
    EXPECT_EQ(decode_mode_result(host.answer(ask_mode(Mode::on_request))), ModeResult::done);
    EXPECT_EQ(decode_configuration(host.answer(ask(Command::configuration))), mm);
    host.device.reset(host.now);
    host.wait(3 * kSecond);
    EXPECT_EQ(host.device.configuration(), mm);  // outlives the restart
  }
}

TEST(LmsEmulator, BaudChangesBehindItsAnswer) {
  Host host(booted());
  for (const int baud : {500000, 38400, 19200, 9600, 500000}) {
    EXPECT_EQ(decode_mode_result(host.answer(ask_baud(baud))), ModeResult::done);  // at the old one
    EXPECT_EQ(host.device.baud(), baud);
    host.baud = baud;
    EXPECT_EQ(decode_status(host.answer(ask(Command::status)))->baud, baud);
  }
  host.device.reset(host.now);
  host.wait(3 * kSecond);
  EXPECT_EQ(host.device.baud(), 9600);
}

TEST(LmsEmulator, ThePermanentBaudOutlivesARestart) {
  Host host(booted());
  EXPECT_TRUE(host.answer(ask_power_on(1)).is(Reply::refused));
  host.answer(ask_installation());
  EXPECT_TRUE(decode_power_on_result(host.answer(ask_power_on(1)))->accepted);
  host.answer(ask_baud(38400));
  host.baud = 38400;
  host.device.reset(host.now);
  host.frames.clear();
  host.wait(3 * kSecond);
  ASSERT_EQ(host.frames.size(), 1u);
  EXPECT_TRUE(host.frames[0].telegram.is(Reply::power_on_identity));
  EXPECT_TRUE(decode_status(host.answer(ask(Command::status)))->permanent_baud);
}

TEST(LmsEmulator, AWrongBaudIsGarbageBothWays) {
  LmsEmulatorOptions o = booted();
  o.mode = Mode::continuous;
  for (const int device : kBauds) {
    for (const int other : kBauds) {
      if (device == other) continue;
      o.baud = device;
      Host host(o);
      host.baud = other;
      host.say(ask_mode(Mode::on_request));
      host.wait(2 * kSecond);
      EXPECT_FALSE(host.chunks.empty());
      EXPECT_TRUE(host.frames.empty());
      EXPECT_EQ(host.device.counts().commands, 0);
      host.baud = device;
      host.wait(2 * kSecond);
      EXPECT_FALSE(host.telegrams(Reply::scan).empty());
    }
  }
}

TEST(LmsEmulator, ResetForgetsModeVariantAndErrors) {
  LmsEmulatorOptions o = booted();
  o.errors = {{LmsErrorEntry::Severity::info, true, 7}};
  Host host(o);
  host.answer(ask_variant({100, 100}));
  EXPECT_EQ(decode_errors(host.answer(ask(Command::errors)))->size(), 1u);
  const auto heard = host.ask(ask(Command::reset), 3 * kSecond);
  ASSERT_EQ(heard.size(), 3u);
  EXPECT_TRUE(heard[1].telegram.is(Reply::reset));
  EXPECT_TRUE(heard[2].telegram.is(Reply::power_on_identity));
  EXPECT_EQ(host.device.variant(), o.variant);
  EXPECT_EQ(decode_errors(host.answer(ask(Command::errors)))->size(), 0u);
}

// ---- Scans. ------------------------------------------------------------------------------------

/// Beam i is 1 m + 1 cm * i away.
std::vector<double> ramp(Time, const Variant& v) {
  std::vector<double> out;
  for (int i = 0; i < v.beams(); ++i) out.push_back(1 + 0.01 * i);
  return out;
}

TEST(LmsEmulator, OneScanOnRequest) {
  Host host(booted(), ramp);
  for (const Variant& v : kVariants) {
    host.answer(ask_variant(v));
    const auto scan = decode_scan(host.answer(ask_scan(), 2 * kSecond));
    ASSERT_TRUE(scan.has_value());
    EXPECT_TRUE(fits(*scan, v));
    EXPECT_EQ(scan->values.front(), 100);
    EXPECT_EQ(scan->values.back(), 99 + v.beams());
  }
}

TEST(LmsEmulator, OtherScansOnRequest) {
  Host host(booted(), ramp);
  const auto mean = decode_scan(host.answer(ask_mean_scan(10), 2 * kSecond));
  EXPECT_EQ(mean->mean_of, 10);
  EXPECT_EQ(mean->values.size(), 361u);
  const auto some = decode_scan(host.answer(ask_subrange_scan({11, 20}), kSecond));
  EXPECT_THAT(some->values,
              ::testing::ElementsAre(110, 111, 112, 113, 114, 115, 116, 117, 118, 119));
  const auto both = decode_scan(host.answer(ask_mean_subrange_scan(3, {2, 4}), kSecond));
  EXPECT_EQ(both->mean_of, 3);
  EXPECT_THAT(both->values, ::testing::ElementsAre(101, 102, 103));
  const auto fields = decode_scan(host.answer(ask_fields_scan({1, 2}), kSecond));
  EXPECT_EQ(fields->fields.size(), 2u);
  const std::vector<Subrange> two{{1, 2}, {361, 361}};
  const auto reflected = decode_scan(host.answer(ask_reflectivity_scan(two), kSecond));
  EXPECT_THAT(reflected->values, ::testing::ElementsAre(100, 101, 460));
  EXPECT_EQ(reflected->reflectivities.size(), 3u);
  const auto turn = decode_scan(host.answer(ask_scan(ScanKind::partial), kSecond));
  EXPECT_TRUE(turn->partial);
}

TEST(LmsEmulator, S14HasReflectivities) {
  LmsEmulatorOptions o = booted();
  o.identity = "LMS291;S14;V02.19    ";
  o.variant = {180, 100};
  Host host(o);
  EXPECT_TRUE(host.answer(ask_variant({180, 50})).is(Reply::refused));
  const auto scan = decode_scan(host.answer(ask_s14_scan({1, 20}), kSecond));
  ASSERT_TRUE(scan.has_value());
  EXPECT_EQ(scan->values.size(), 181u);
  EXPECT_EQ(scan->reflectivities.size(), 20u);
}

struct RateRow {
  int baud;
  Variant variant;
  Mode mode;
  double rate;  // Hz
};

// The maker's table, and what its rule gives for the interlaced mode.
const RateRow kRates[] = {
    {9600, {180, 100}, Mode::continuous, 2.50},   {9600, {180, 50}, Mode::continuous, 1.294},
    {9600, {100, 25}, Mode::continuous, 1.173},   {9600, {180, 50}, Mode::interlaced, 2.50},
    {19200, {180, 100}, Mode::continuous, 5.01},  {19200, {180, 50}, Mode::continuous, 2.50},
    {19200, {100, 25}, Mode::continuous, 2.346},  {19200, {180, 50}, Mode::interlaced, 5.01},
    {38400, {180, 100}, Mode::continuous, 9.38},  {38400, {180, 50}, Mode::continuous, 4.69},
    {38400, {100, 25}, Mode::continuous, 4.69},   {38400, {180, 50}, Mode::interlaced, 9.38},
    {500000, {180, 100}, Mode::continuous, 75.1}, {500000, {180, 50}, Mode::continuous, 37.5},
    {500000, {100, 25}, Mode::continuous, 18.8},  {500000, {100, 25}, Mode::interlaced, 75.1},
};

TEST(LmsEmulator, RatesOfTheTable) {
  for (const RateRow& row : kRates) {
    LmsEmulatorOptions o = booted();
    o.baud = row.baud;
    o.variant = row.variant;
    o.mode = row.mode;
    Host host(o);
    host.wait(10 * kSecond);
    const auto scans = host.telegrams(Reply::scan);
    ASSERT_GT(scans.size(), 5u);
    const double span = to_seconds(scans.back().first_byte - scans.front().first_byte);
    const double rate = static_cast<double>(scans.size() - 1) / span;
    EXPECT_NEAR(rate / row.rate, 1, 0.01) << row.baud << ' ' << row.variant.resolution;
    EXPECT_EQ(host.framer.counts().skipped_bytes, 0);
  }
}

TEST(LmsEmulator, SpacingOfTheRecordedDevice) {
  LmsEmulatorOptions o = booted();
  o.baud = 38400;
  o.mode = Mode::continuous;
  Host host(o);
  host.wait(5 * kSecond);
  const auto scans = host.telegrams(Reply::scan);
  for (std::size_t i = 1; i < scans.size(); ++i) {
    const double ms = to_seconds(scans[i].first_byte - scans[i - 1].first_byte) * 1e3;
    EXPECT_NEAR(ms, 213.1, 0.1);
  }
}

TEST(LmsEmulator, AtMost508BytesATurn) {
  LmsEmulatorOptions o = booted();
  o.baud = 500000;
  o.mode = Mode::continuous;
  Host host(o);
  host.wait(2 * kSecond);
  std::vector<int> in_turn;
  for (const Chunk& chunk : host.chunks) {
    for (std::size_t i = 0; i < chunk.bytes.size(); ++i) {
      const Time begin = chunk.left(i) - chunk.byte_time;
      const auto turn = static_cast<std::size_t>(begin / o.mirror_turn);
      if (in_turn.size() <= turn) in_turn.resize(turn + 1);
      ++in_turn[turn];
    }
  }
  EXPECT_EQ(*std::max_element(in_turn.begin(), in_turn.end()), 508);
  EXPECT_EQ(*std::max_element(in_turn.begin() + 10, in_turn.end() - 1) +
                *std::min_element(in_turn.begin() + 10, in_turn.end() - 1),
            732);
}

TEST(LmsEmulator, InterlacedPartsAreThoseOfTheWholeScan) {
  for (const Variant& v : {Variant{180, 100}, Variant{180, 50}, Variant{100, 25}}) {
    LmsEmulatorOptions o = booted();
    o.baud = 500000;
    o.variant = v;
    o.mode = Mode::interlaced;
    Host host(o, ramp);
    host.wait(kSecond);
    const auto scans = host.telegrams(Reply::scan);
    ASSERT_GT(scans.size(), 60u);
    int before = -1;
    for (const Frame& frame : scans) {
      const auto scan = decode_scan(frame.telegram);
      EXPECT_TRUE(scan->partial);
      EXPECT_TRUE(fits(*scan, v));
      const int part = scan->quarter * v.turns() / 4;
      EXPECT_TRUE(before < 0 || part == (before + 1) % v.turns());
      before = part;
      for (std::size_t i = 0; i < scan->values.size(); ++i) {
        EXPECT_EQ(scan->values[i], 100 + static_cast<int>(i) * v.turns() + part);
      }
    }
  }
}

// Beam i sees the time at which it was fired, written in millimetres of its range.
TEST(LmsEmulator, ScansTellWhenTheyWereMeasured) {
  for (const Mode mode : {Mode::continuous, Mode::interlaced}) {
    for (const Variant& v : kVariants) {
      LmsEmulatorOptions o = booted();
      o.baud = 500000;
      o.variant = v;
      o.mode = mode;
      o.configuration.set_unit(Unit::millimetre);
      o.configuration.set_measuring_mode(6);
      const auto clock = [](Time first_beam, const Variant& shape) {
        std::vector<double> out;
        for (int i = 0; i < shape.beams(); ++i) {
          const Time fired = first_beam + beam_time(shape, i);
          out.push_back(1 + to_seconds(fired) * 10);  // a millimetre is 0.1 ms
        }
        return out;
      };
      Host host(o, clock);
      host.wait(kSecond);
      const auto telegrams = host.telegrams(Reply::scan);
      ASSERT_GT(telegrams.size(), 10u);
      for (const Frame& frame : telegrams) {
        const auto lms = decode_scan(frame.telegram);
        const Scan scan = to_scan(*lms, o.configuration, v, frame.first_byte);
        const Variant shape = lms->partial ? Variant{180, 100} : v;
        for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
          const Time fired = scan.time + beam_time(shape, static_cast<int>(i));
          // The millimetre's rounding, and 0.1 % between the mirror's turn and the nominal one.
          EXPECT_NEAR(scan.ranges[i], 1 + to_seconds(fired) * 10, 0.0011);
        }
      }
    }
  }
}

TEST(LmsEmulator, IndicesCountTurnsAndTelegrams) {
  LmsEmulatorOptions o = booted();
  o.baud = 38400;
  o.mode = Mode::continuous;
  o.configuration.set_real_time_indices(true);
  Host host(o);
  host.wait(10 * kSecond);
  const auto scans = host.telegrams(Reply::scan);
  ASSERT_GT(scans.size(), 40u);
  for (std::size_t i = 1; i < scans.size(); ++i) {
    const auto a = decode_scan(scans[i - 1].telegram), b = decode_scan(scans[i].telegram);
    EXPECT_EQ(static_cast<std::uint8_t>(*b->scan_index - *a->scan_index), 16);
    EXPECT_EQ(static_cast<std::uint8_t>(*b->telegram_index - *a->telegram_index), 1);
  }
}

TEST(LmsEmulator, ACommandCutsTheScanOffAndIsAnswered) {
  LmsEmulatorOptions o = booted();
  o.baud = 38400;
  o.mode = Mode::continuous;
  Host host(o);
  host.wait(300 * kMs);
  const auto heard = host.ask(ask_mode(Mode::on_request), kSecond);
  EXPECT_EQ(host.device.counts().cut_off, 1);
  ASSERT_FALSE(heard.empty());
  EXPECT_EQ(decode_mode_result(heard.back().telegram), ModeResult::done);
  EXPECT_TRUE(host.telegrams(Reply::scan).empty());
  EXPECT_GT(host.framer.counts().skipped_bytes, 10);
  // Another question does not end the stream.
  host.ask(ask_mode(Mode::continuous), kSecond);
  host.ask(ask(Command::type), kSecond);
  EXPECT_FALSE(host.telegrams(Reply::identity).empty());
  EXPECT_FALSE(host.telegrams(Reply::scan).empty());
}

TEST(LmsEmulator, StreamsOfEveryKind) {
  LmsEmulatorOptions o = booted();
  o.baud = 500000;
  const std::vector<Subrange> beams{{1, 100}};
  const std::pair<Telegram, Reply> streams[] = {
      {ask_mode(Mode::continuous), Reply::scan},
      {ask_mode(Mode::interlaced), Reply::scan},
      {ask_mean_stream(5), Reply::mean_scan},
      {ask_subrange_stream(beams[0]), Reply::subrange_scan},
      {ask_mean_subrange_stream(5, beams[0]), Reply::mean_subrange_scan},
      {ask_fields_stream(beams[0]), Reply::fields_scan},
      {ask_reflectivity_stream(beams), Reply::reflectivity_scan},
  };
  Host host(o);
  for (const auto& [command, code] : streams) {
    host.ask(command, kSecond);
    const auto scans = host.telegrams(code);
    EXPECT_GT(scans.size(), 5u) << static_cast<int>(code);
    for (const Frame& f : scans) EXPECT_TRUE(decode_scan(f.telegram).has_value());
  }
  // Beams that are no longer there end the stream.
  host.ask(ask_subrange_stream({1, 361}), kSecond);
  EXPECT_FALSE(host.telegrams(Reply::subrange_scan).empty());
  host.ask(ask_variant({100, 100}), kSecond);
  host.frames.clear();
  host.wait(kSecond);
  EXPECT_TRUE(host.frames.empty());
}

TEST(LmsEmulator, MeansAreMeansAndForgiveAFifth) {
  LmsEmulatorOptions o = booted();
  o.variant = {180, 100};
  int calls = 0;
  Host host(o, [&](Time, const Variant& v) {
    std::vector<double> out(static_cast<std::size_t>(v.beams()), 1 + calls % 10);
    if (calls % 10 < 2) out[0] = kNoReturn;
    if (calls % 10 < 3) out[1] = kNoReturn;
    ++calls;
    return out;
  });
  const auto scan = decode_scan(host.answer(ask_mean_scan(10), 2 * kSecond));
  ASSERT_TRUE(scan.has_value());
  EXPECT_EQ(calls, 10);
  EXPECT_EQ(scan->values[0], 650);
  EXPECT_EQ(scan->values[1], 0x1FFF);
  EXPECT_EQ(scan->values[2], 550);
}

TEST(LmsEmulator, SameCallsSameBytes) {
  LmsEmulatorOptions o = booted();
  o.baud = 500000;
  o.mode = Mode::continuous;
  LmsFaults faults;
  faults.drop = faults.flip = faults.duplicate = 0.01;
  faults.noise = faults.truncate = faults.dazzle = 0.3;
  const auto run = [&](std::uint64_t seed) {
    o.seed = seed;
    Host host(o);
    host.device.set_faults(faults);
    host.wait(kSecond);
    std::string all;
    for (const Chunk& c : host.chunks) all.append(c.bytes.begin(), c.bytes.end());
    return all;
  };
  EXPECT_EQ(run(1), run(1));
  EXPECT_NE(run(1), run(2));
}

TEST(LmsEmulator, TheSizeOfTheStepsChangesNothing) {
  LmsEmulatorOptions o = booted();
  o.baud = 500000;
  o.mode = Mode::continuous;
  const auto run = [&](Duration step) {
    LmsEmulator device(o, ramp, 0);
    std::string all;
    for (Time now = 0; now < kSecond; now += step) {
      for (const Chunk& c : device.transmit(now, o.baud)) {
        all.append(c.bytes.begin(), c.bytes.end());
      }
    }
    for (const Chunk& c : device.transmit(kSecond, o.baud)) {
      all.append(c.bytes.begin(), c.bytes.end());
    }
    return all;
  };
  const std::string fine = run(100'000);
  EXPECT_GT(fine.size(), 20000u);
  EXPECT_EQ(fine, run(7 * kMs));
  EXPECT_EQ(fine, run(kSecond));
}

TEST(LmsEmulator, NextEventIsWhenSomethingHappens) {
  LmsEmulatorOptions o = booted();
  LmsEmulator device(o, ramp, 0);
  device.receive(encode(ask(Command::type)), o.baud, 0);
  // Going from event to event loses nothing.
  Time now = 0;
  std::size_t heard = 0;
  for (int i = 0; i < 200; ++i) {
    const Time next = device.next_event();
    EXPECT_GT(next, now);
    now = next;
    for (const Chunk& c : device.transmit(now, o.baud)) heard += c.bytes.size();
  }
  EXPECT_EQ(heard, 30u);
}

TEST(LmsEmulator, ReplaysRecordedScans) {
  MAJAK_NEEDS_SICK_DATA();
  LmsEmulatorOptions o = lms200_recorded();
  o.booted = true;
  o.baud = 38400;
  o.mode = Mode::continuous;
  std::vector<LmsScan> recorded;
  for (const testing::Bytes& frame : testing::sick_recorded()) {
    if (auto scan = decode_scan(*decode(frame))) recorded.push_back(*scan);
  }
  std::size_t next = 0;
  Host host(o, [&](Time, const Variant&) {
    const LmsValues values =
        decode_values(recorded[next++ % recorded.size()], o.configuration.measuring_mode());
    return std::vector<double>(values.ranges.begin(), values.ranges.end());
  });
  host.wait(2 * kSecond);
  const auto scans = host.telegrams(Reply::scan);
  ASSERT_GT(scans.size(), 8u);
  int different = 0;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const auto scan = decode_scan(scans[i].telegram);
    const LmsValues a = decode_values(*scan, 4), b = decode_values(recorded[i], 4);
    for (std::size_t k = 0; k < a.ranges.size(); ++k) {
      const bool same =
          a.ranges[k] == b.ranges[k] || (std::isnan(a.ranges[k]) && std::isnan(b.ranges[k]));
      different += same ? 0 : 1;
    }
  }
  EXPECT_EQ(different, 0);
}

}  // namespace
}  // namespace majak::sensor
