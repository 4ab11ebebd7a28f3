// SPDX-License-Identifier: Apache-2.0
#include "majak/sensor/cola_session.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <utility>

#include "tests/unit/sensor/cola_wire.hpp"

namespace majak::sensor {
namespace {

using testing::HasSubstr;
using State = ColaSession::State;

// Every scan is one that the device measured: the ranges are those of the moment it states.
void expect_true_scans(const ColaWire& wire, const ColaEmulatorOptions& options) {
  for (const ColaDelivery& d : wire.scans) {
    const Scan scan = to_scan(d.scan);
    const auto turn = std::llround(to_seconds(scan.time - wire.device.turn_start(0)) *  //
                                   options.mirror_rate);
    const Time fired = wire.device.turn_start(turn);
    EXPECT_NEAR(static_cast<double>(scan.time - fired), 0, 350'000)
        << "0.35 ms, transit and clocks";
    const auto truth = moving_room(fired, options.beams);
    ASSERT_EQ(scan.ranges.size(), truth.size());
    for (std::size_t i = 0; i < truth.size(); ++i)
      ASSERT_NEAR(scan.ranges[i], truth[i], 0.00051 * options.scale);
  }
}

TEST(ColaSession, ScansFlowInBothDialectsHoweverTheBytesCome) {
  using C = ColaWire::Chunks;
  for (const ColaDialect dialect : kDialects) {
    for (const C chunks : {C::whole, C::bytes, C::random}) {
      const ColaEmulatorOptions laser{.dialect = dialect};
      ColaWire wire({}, laser);
      wire.chunks = chunks;
      wire.run(6 * kSecond);
      EXPECT_TRUE(wire.streaming()) << wire.session.activity();
      EXPECT_EQ(wire.session.dialect(), dialect);
      EXPECT_GE(wire.scans.size(), 4 * 15U);
      EXPECT_EQ(wire.session.counts().missed, 0);
      EXPECT_EQ(wire.session.counts().logins, 1);
      EXPECT_EQ(wire.connections, 1);
      EXPECT_TRUE(wire.session.report().empty());
      expect_true_scans(wire, laser);
    }
  }
}

TEST(ColaSession, TheDialectThatIsKnownIsSpokenAtOnce) {
  for (const ColaDialect dialect : kDialects) {
    ColaWire wire({.dialect = dialect}, {.dialect = dialect});
    wire.run(kSecond / 10);
    EXPECT_TRUE(wire.streaming()) << wire.session.activity();
  }
}

// What is said, word by word; the device answers each time.
TEST(ColaSession, SaysWhatTheManualSays) {
  ColaSession session({.dialect = ColaDialect::a, .ask_intensities = true});
  const auto heard = [&](const char* answer) {
    const auto bytes = cola_frame(ColaDialect::a, answer);
    session.receive(bytes, 0);
    const auto said = session.take_output();
    return said.size() < 2 ? std::string() : std::string(said.begin() + 1, said.end() - 1);
  };
  session.start(0);
  EXPECT_EQ(session.take_output(), ColaWriter(ColaDialect::a, "sRN SCdevicestate").frame());
  EXPECT_EQ(heard("sRA SCdevicestate 1"), "sRN DeviceIdent");
  EXPECT_EQ(heard("sRA DeviceIdent 6 TiM561 2 V2"), "sMN SetAccessMode 03 F4724744");
  EXPECT_EQ(heard("sAN SetAccessMode 1"), "sWN LMDscandatacfg 01 00 1 1 0 00 00 0 1 0 0 1");
  EXPECT_EQ(heard("sWA LMDscandatacfg"), "sMN LMCstartmeas");
  EXPECT_EQ(heard("sAN LMCstartmeas 0"), "sMN Run");
  EXPECT_EQ(heard("sAN Run 1"), "sRN STlms");
  EXPECT_EQ(heard("sRA STlms 6 0 8 00:00:00 8 01.0 1.06 0 0 0"), "");
  EXPECT_EQ(session.activity(), "waiting until the device measures (it says: ready)");
  session.advance(session.wake_at());
  EXPECT_EQ(session.take_output(), ColaWriter(ColaDialect::a, "sRN STlms").frame());
  EXPECT_EQ(heard("sRA STlms 7 0 8 00:00:00 8 01.0 1.06 0 0 0"), "sEN LMDscandata 1");
  EXPECT_EQ(session.state(), State::subscribing);
  EXPECT_EQ(heard("sEA LMDscandata 1"), "");
  EXPECT_EQ(session.state(), State::streaming);
  session.stop();
  EXPECT_EQ(session.take_output(), ColaWriter(ColaDialect::a, "sEN LMDscandata").u8(0).frame());
}

TEST(ColaSession, EveryDeviceOfTheFamily) {
  const ColaEmulatorOptions tim571{.knows_stlms = false, .angle_step = 1.0 / 3, .beams = 811};
  const ColaEmulatorOptions lms111{.mirror_rate = 50, .angle_step = 0.5, .beams = 541};
  const ColaEmulatorOptions lms511{
      .mirror_rate = 100, .start_angle = -95, .angle_step = 2.0 / 3, .beams = 286, .scale = 2};
  for (const ColaDialect dialect : kDialects) {
    for (ColaEmulatorOptions laser : {tim571, lms111, lms511}) {
      laser.dialect = dialect;
      ColaWire wire({}, laser);
      wire.run(4 * kSecond);
      EXPECT_GE(static_cast<double>(wire.scans.size()), 2.8 * laser.mirror_rate);
      expect_true_scans(wire, laser);
      const Scan scan = to_scan(wire.scans.back().scan);
      EXPECT_NEAR(scan.start_angle, radians(laser.start_angle), 1e-12);
      EXPECT_NEAR(scan.angle_step, radians(laser.angle_step), 1e-12);
      EXPECT_EQ(scan.intensities.size(), scan.ranges.size());
    }
  }
}

TEST(ColaSession, WaitsForADeviceThatBoots) {
  for (const ColaDialect dialect : kDialects) {
    for (const double boot_time : {0.5, 4.0, 30.0}) {
      ColaWire wire({}, {.dialect = dialect, .boot_time = boot_time});
      wire.run(40 * kSecond);
      EXPECT_TRUE(wire.streaming());
      ASSERT_FALSE(wire.scans.empty());
      const Time first = wire.scans[0].scan.time;
      EXPECT_LT(first, from_seconds(boot_time) + 3 * kSecond) << boot_time;
      // Each 5 to 6 s of silence, another connection.
      EXPECT_EQ(wire.connections, boot_time < 5 ? 1 : 6);
    }
  }
}

TEST(ColaSession, StartsAMeasurementThatDoesNotRun) {
  for (const bool knows_stlms : {true, false}) {
    ColaWire wire({}, {.spin_up_time = 4, .measures_at_once = false, .knows_stlms = knows_stlms});
    wire.run(2 * kSecond);
    EXPECT_EQ(wire.session.state(), State::waiting);
    EXPECT_THAT(wire.session.activity(), HasSubstr(knows_stlms ? "in preparation" : "busy"));
    wire.run(8 * kSecond);
    EXPECT_TRUE(wire.streaming());
    EXPECT_EQ(wire.session.counts().logins, 1);
  }
}

TEST(ColaSession, AWrongPasswordDoesNotStopScansThatFlow) {
  ColaWire wire({.password = 1}, {});
  wire.run(4 * kSecond);
  EXPECT_TRUE(wire.streaming());
  const Report report = wire.session.report();
  EXPECT_EQ(report.entries().at("CoLa: the device refused the login").count, 1);
  EXPECT_EQ(report.entries().at("CoLa: the device refused LMCstartmeas: access denied").count, 1);
}

TEST(ColaSession, SaysWhyItGivesUp) {
  ColaWire nobody({}, {.boot_time = 1e6});
  nobody.run(100 * kSecond);
  EXPECT_EQ(nobody.session.state(), State::failed);
  EXPECT_THAT(nobody.session.problem(), HasSubstr("no answer in 60 s, neither in CoLa A nor"));
  EXPECT_THAT(nobody.session.problem(), HasSubstr("2111 or 2112"));
  EXPECT_EQ(nobody.session.wake_at(), ColaSession::kNever);

  ColaWire locked({.password = 1}, {.measures_at_once = false});
  locked.run(100 * kSecond);
  EXPECT_EQ(locked.session.state(), State::failed);
  EXPECT_THAT(locked.session.problem(), HasSubstr("sent no scan for 60 s"));
  EXPECT_THAT(locked.session.problem(),
              HasSubstr("; the device refused LMCstartmeas: access denied"));

  ColaWire patient({.patience = 0}, {.boot_time = 200});
  patient.run(210 * kSecond);
  EXPECT_TRUE(patient.streaming());
  EXPECT_GT(patient.connections, 10);
}

TEST(ColaSession, BeginsAnewAfterItGaveUp) {
  ColaWire wire({}, {.boot_time = 70});
  wire.run(65 * kSecond);
  ASSERT_EQ(wire.session.state(), State::failed);
  wire.session.start(wire.now);
  wire.run(80 * kSecond);
  EXPECT_TRUE(wire.streaming());
  EXPECT_EQ(wire.session.problem(), "");
}

TEST(ColaSession, LogsInAgainAfterAResetOfTheDevice) {
  for (const ColaDialect dialect : kDialects) {
    ColaWire wire({}, {.dialect = dialect, .boot_time = 8});
    wire.run(12 * kSecond);
    ASSERT_TRUE(wire.streaming());
    const std::size_t before = wire.scans.size();
    wire.device.reset(wire.now);
    wire.run(19 * kSecond);
    EXPECT_EQ(wire.scans.size(), before);
    EXPECT_EQ(wire.session.state(), State::searching);
    wire.run(26 * kSecond);
    EXPECT_TRUE(wire.streaming());
    EXPECT_GT(wire.scans.size(), before + 15);
    EXPECT_EQ(wire.session.counts().pauses, 1);
    EXPECT_EQ(wire.session.counts().missed, 0) << "the counters began anew";
  }
}

TEST(ColaSession, APulledCableNeedsAnotherConnection) {
  ColaWire wire({}, {});
  wire.run(4 * kSecond);
  ASSERT_TRUE(wire.streaming());
  wire.change = [](std::vector<std::uint8_t>& said) { said.resize(said.size() / 2); };
  wire.run(wire.now + kSecond / 15);  // half a scan came through
  wire.change = nullptr;
  wire.plugged = false;
  wire.run(30 * kSecond);
  EXPECT_GT(wire.connections, 2);
  EXPECT_NE(wire.session.state(), State::failed);
  wire.plugged = true;
  wire.run(40 * kSecond);
  EXPECT_TRUE(wire.streaming());
  EXPECT_EQ(wire.session.counts().pauses, 1);
  EXPECT_EQ(wire.session.report().entries().count("CoLa: bytes that belong to no telegram"), 0U)
      << "the half is not joined to what comes later";
}

TEST(ColaSession, APauseOfTheNetworkNeedsNoLogin) {
  ColaWire wire({}, {});
  wire.run(4 * kSecond);
  ASSERT_TRUE(wire.streaming());
  std::vector<std::uint8_t> held;
  wire.change = [&](auto& said) {
    held.insert(held.end(), said.begin(), said.end());
    said.clear();
  };
  wire.run(8 * kSecond + kSecond / 2);
  EXPECT_EQ(wire.session.state(), State::searching);
  wire.change = [&](auto& said) {
    said.insert(said.begin(), held.begin(), held.end()), held.clear();
  };
  wire.run(9 * kSecond);
  EXPECT_TRUE(wire.streaming());
  EXPECT_EQ(wire.session.counts().logins, 1);
  EXPECT_EQ(wire.connections, 1);
}

// The device's answers without those that are of this kind.
std::function<void(std::vector<std::uint8_t>&)> without(const std::string& head, int times) {
  return [=](std::vector<std::uint8_t>& said) mutable {
    ColaFramer framer;
    framer.push(said, 0);
    std::vector<std::uint8_t> rest;
    while (const auto t = framer.next()) {
      if (t->is(head) && times-- > 0) continue;
      const auto bytes = cola_frame(t->dialect, t->payload);
      rest.insert(rest.end(), bytes.begin(), bytes.end());
    }
    said = rest;
  };
}

TEST(ColaSession, AnyAnswerMayBeLost) {
  for (const char* head : {"sRA SCdevicestate", "sAN SetAccessMode", "sAN LMCstartmeas", "sAN Run",
                           "sRA STlms", "sEA LMDscandata", "sWA LMDscandatacfg"}) {
    for (const int times : {1, 4}) {
      ColaWire wire({.ask_intensities = true}, {});
      wire.change = without(head, times);
      wire.run(40 * kSecond);
      EXPECT_TRUE(wire.streaming()) << head << " lost " << times << ": " << wire.session.activity();
      EXPECT_FALSE(wire.scans.empty());
      // One is said again; after three in vain everything is.
      const bool is_needed = std::string(head) != "sRA SCdevicestate" && head[1] != 'E';
      EXPECT_EQ(wire.session.report().entries().count("CoLa: commands without an answer"),
                is_needed && times == 4 ? 1U : 0U)
          << head;
    }
  }
}

TEST(ColaSession, AsksTwiceForTheMeasurementThenSeesWhetherScansCome) {
  ColaWire wire({}, {});
  wire.change = [](std::vector<std::uint8_t>& said) {
    ColaFramer framer;
    framer.push(said, 0);
    const auto t = framer.next();
    if (t && t->is("sRA STlms")) said = ColaWriter(t->dialect, "sRA STlms").u16(6).frame();
  };
  wire.run(9 * kSecond);
  EXPECT_EQ(wire.session.activity(), "waiting until the device measures (it says: ready)");
  wire.run(30 * kSecond);
  EXPECT_TRUE(wire.streaming());
  EXPECT_EQ(wire.session.counts().logins, 2);
}

TEST(ColaSession, ScansMayComeBeforeTheConfirmation) {
  ColaWire wire({}, {});
  std::vector<std::uint8_t> held;
  wire.change = [&](std::vector<std::uint8_t>& said) {
    const std::string text(said.begin(), said.end());
    if (text.find("sEA LMDscandata") != std::string::npos) held = std::exchange(said, {});
    if (text.find("sSN LMDscandata") == std::string::npos) return;
    said.insert(said.end(), held.begin(), held.end());
    held.clear();
  };
  wire.run(3 * kSecond);
  EXPECT_TRUE(wire.streaming());
  EXPECT_GT(wire.scans.size(), 20U);
  EXPECT_TRUE(wire.session.report().empty());
}

TEST(ColaSession, LostAndDoubledScansAreCounted) {
  for (const ColaDialect dialect : kDialects) {
    ColaWire wire({}, {.dialect = dialect});
    int n = 0;
    wire.change = [&](std::vector<std::uint8_t>& said) {
      const std::string text(said.begin(), said.end());
      if (text.find("sSN LMDscandata") == std::string::npos) return;
      ++n;
      if (n % 10 == 3 || n % 10 == 4) said.clear();
      if (n % 10 == 7) said.insert(said.end(), text.begin(), text.end());
      if (n % 10 == 9) said[said.size() / 2] = 2;  // damaged
    };
    wire.run(12 * kSecond);
    ASSERT_GT(n, 100);
    const auto& counts = wire.session.counts();
    std::int64_t gaps = 0;
    for (const ColaDelivery& d : wire.scans) gaps += d.scans_missed;
    EXPECT_EQ(gaps, counts.missed);
    EXPECT_NEAR(static_cast<double>(counts.missed), n * 0.3, 3);
    EXPECT_NEAR(static_cast<double>(counts.doubled), n * 0.1, 1);
    EXPECT_EQ(counts.scans, static_cast<std::int64_t>(wire.scans.size()));
    EXPECT_EQ(counts.pauses, 0);
    expect_true_scans(wire, {});
  }
}

TEST(ColaSession, GarbageBetweenTelegramsCostsNoScan) {
  for (const ColaDialect dialect : kDialects) {
    ColaWire wire({}, {.dialect = dialect});
    RandomStream random(8);
    wire.change = [&](std::vector<std::uint8_t>& said) {
      std::vector<std::uint8_t> noise(random.below(30));
      for (std::uint8_t& byte : noise) byte = static_cast<std::uint8_t>(random.below(5));
      said.insert(said.begin(), noise.begin(), noise.end());
    };
    wire.run(8 * kSecond);
    EXPECT_GT(wire.scans.size(), 6 * 15U);
    EXPECT_EQ(wire.session.counts().missed, 0);
    expect_true_scans(wire, {});
  }
}

TEST(ColaSession, ScansThatCannotBeReadAreCountedAndToldInTheEnd) {
  ColaWire wire({}, {});
  wire.change = [](std::vector<std::uint8_t>& said) {
    ColaFramer framer;
    framer.push(said, 0);
    const auto t = framer.next();
    if (t && t->is("sSN LMDscandata")) said = cola_frame(t->dialect, t->payload.substr(0, 100));
  };
  wire.run(100 * kSecond);
  EXPECT_TRUE(wire.scans.empty());
  EXPECT_GT(wire.session.counts().unreadable, 100);
  EXPECT_THAT(wire.session.problem(),
              HasSubstr("; its scans cannot be read: LMDscandata in CoLa B"));
  EXPECT_THAT(wire.session.problem(), HasSubstr("values of DIST1; the telegram was cut short"));
}

TEST(ColaSession, TimesAreRightAcrossTheWrapOfTheDevicesClock) {
  const ColaEmulatorOptions laser{.clock_start = 0xFFFFFFFFU - 4'000'000};
  ColaWire wire({}, laser);
  wire.run(8 * kSecond);
  EXPECT_LT(wire.scans.back().scan.first_shot, wire.scans.front().scan.first_shot);
  expect_true_scans(wire, laser);
}

TEST(ColaSession, AsksForIntensities) {
  for (const ColaDialect dialect : kDialects) {
    ColaWire wire({.ask_intensities = true},
                  {.dialect = dialect, .intensities = false, .name = "hall 3"});
    wire.run(4 * kSecond);
    ASSERT_FALSE(wire.scans.empty());
    EXPECT_EQ(to_scan(wire.scans[0].scan).intensities.size(), 271U);
    EXPECT_EQ(wire.scans[0].scan.channels16.size(), 2U);
    EXPECT_EQ(wire.scans[0].scan.name, "hall 3");
  }
}

TEST(ColaSession, ScansThatCameUnaskedAreNotTakenForThoseThatWereAskedFor) {
  ColaWire wire({.dialect = ColaDialect::a, .ask_intensities = true},
                {.dialect = ColaDialect::a, .boot_time = 2, .intensities = false});
  wire.run(2 * kSecond);
  wire.device.receive(ColaWriter(ColaDialect::a, "sEN LMDscandata").u8(1).frame(), 2 * kSecond);
  wire.change = without("sAN SetAccessMode", 1);
  wire.run(5 * kSecond);
  EXPECT_EQ(to_scan(wire.scans.front().scan).intensities.size(), 0U);
  EXPECT_EQ(to_scan(wire.scans.back().scan).intensities.size(), 271U);
}

TEST(ColaSession, StopAsksForNoMore) {
  ColaWire wire({}, {});
  wire.run(4 * kSecond);
  ASSERT_TRUE(wire.device.streams());
  wire.session.stop();
  EXPECT_EQ(wire.session.state(), State::off);
  wire.exchange();
  EXPECT_FALSE(wire.device.streams());
  EXPECT_EQ(wire.session.wake_at(), ColaSession::kNever);
}

TEST(ColaSession, WhoFetchesNothingLosesTheOldestScans) {
  ColaSession session({.patience = 0});
  ColaEmulator device(
      {.mirror_rate = 100, .beams = 5}, [](Time) { return std::vector{1.0}; }, 0);
  session.start(0);
  for (Time now = 0; now < 15 * kSecond; now += kSecond / 100) {
    session.advance(now);
    device.advance(now);
    const auto asked = session.take_output();
    if (!asked.empty()) device.receive(asked, now);
    const auto said = device.take_output();
    if (!said.empty()) session.receive(said, now);
  }
  std::int64_t left = 0;
  while (session.next()) ++left;
  EXPECT_EQ(left, 1000);
  EXPECT_EQ(session.counts().scans, left + session.counts().unfetched);
}

TEST(ColaSession, EveryStateHasWords) {
  std::set<std::string> all;
  for (int s = 0; s <= static_cast<int>(State::failed); ++s)
    all.insert(words(static_cast<State>(s)));
  EXPECT_EQ(all.size(), 7U);
}

// Any bytes at any time: it ends, and it recovers as soon as there is a device again.
TEST(ColaSession, SurvivesNoise) {
  ColaWire wire({}, {});
  RandomStream random(2);
  wire.change = [&](std::vector<std::uint8_t>& said) {
    for (std::uint8_t& byte : said) {
      if (random.below(20) == 0) byte = static_cast<std::uint8_t>(random.bits());
    }
  };
  wire.run(50 * kSecond);
  wire.change = nullptr;
  wire.run(62 * kSecond);
  EXPECT_TRUE(wire.streaming()) << wire.session.activity();
}

// ---- the device -----------------------------------------------------------------------------

std::string ask(ColaEmulator& device, const ColaWriter& command) {
  device.receive(command.frame(), kSecond);
  ColaFramer framer;
  framer.push(device.take_output(), 0);
  const auto answer = framer.next();
  if (!answer) return "";
  if (const auto code = cola_refusal(*answer)) return "sFA " + std::to_string(*code);
  return answer->payload;
}

TEST(ColaEmulator, RefusesWhatItDoesNotKnow) {
  for (const ColaDialect dialect : kDialects) {
    ColaEmulator device(
        {.dialect = dialect}, [](Time) { return std::vector<double>{}; }, 0);
    const auto say = [&](const char* head) { return ask(device, ColaWriter(dialect, head)); };
    EXPECT_EQ(say("sMN Fly"), "sFA 2");
    EXPECT_EQ(say("sRN Colour"), "sFA 3");
    EXPECT_EQ(say("sWN Colour"), "sFA 3");
    EXPECT_EQ(say("sEN Sunrise"), "sFA 15");
    EXPECT_EQ(say("sAN Run"), "sFA 12");
    EXPECT_EQ(say("sMN SetAccessMode"), "sFA 5");
    EXPECT_EQ(say("sMN LMCstartmeas"), "sFA 1");
  }
}

TEST(ColaEmulator, IsDeafToTheOtherDialectUntilToldToSwitch) {
  ColaEmulator device(
      {.dialect = ColaDialect::a}, [](Time) { return std::vector<double>{}; }, 0);
  EXPECT_EQ(ask(device, ColaWriter(ColaDialect::b, "sRN SCdevicestate")), "");
  EXPECT_EQ(ask(device, ColaWriter(ColaDialect::a, "sRN SCdevicestate")), "sRA SCdevicestate 1");
  EXPECT_EQ(ask(device, ColaWriter(ColaDialect::a, "sRN STlms")),
            "sRA STlms 7 0 8 00:00:00 8 01.01.06 0 0 0");
  EXPECT_EQ(ask(device, ColaWriter(ColaDialect::a, "sWN EIHstCola").u8(1)), "sWA EIHstCola");
  EXPECT_EQ(ask(device, ColaWriter(ColaDialect::a, "sRN SCdevicestate")), "");
  EXPECT_EQ(ask(device, ColaWriter(ColaDialect::b, "sRN SCdevicestate")), "sRA SCdevicestate \x01");
}

TEST(ColaEmulator, AnswersWithOneScan) {
  ColaEmulator device(
      {.dialect = ColaDialect::a}, [](Time) { return std::vector{2.5}; }, 0);
  const std::string payload = ask(device, ColaWriter(ColaDialect::a, "sRN LMDscandata"));
  const ColaScan scan = decode_scan({kSecond, ColaDialect::a, payload});
  EXPECT_TRUE(scan.asked);
  EXPECT_EQ(scan.channels16[0].raw[0], 2500);
  EXPECT_EQ(scan.channels16[0].raw[1], 0) << "no echo where nothing is known";
  EXPECT_FALSE(device.streams());
}

TEST(ColaEmulator, HoldsNoMoreThanItsBuffer) {
  ColaEmulator device(
      {.mirror_rate = 100}, [](Time) { return std::vector{2.5}; }, 0);
  device.receive(ColaWriter(ColaDialect::b, "sEN LMDscandata").u8(1).frame(), 0);
  device.advance(60 * kSecond);
  EXPECT_LT(device.take_output().size(), 1'100'000U);
  EXPECT_LT(device.scans_sent(), 2000);
}

}  // namespace
}  // namespace majak::sensor
