// SPDX-License-Identifier: Apache-2.0
#include "majak/sensor/lms_telegrams.hpp"

#include <gmock/gmock.h>

#include <functional>
#include <map>

#include "majak/core/error.hpp"
#include "sick_data.hpp"

namespace majak::sensor {
namespace {

using testing::Bytes;
using testing::bytes;
using ::testing::ElementsAre;

Bytes zeros(std::string_view before, std::size_t n, std::string_view after) {
  Bytes out = bytes(before);
  out.resize(out.size() + n);
  for (const std::uint8_t b : bytes(after)) out.push_back(b);
  return out;
}

LmsConfiguration configuration(std::size_t size, int stop, int mode, Unit unit) {
  LmsConfiguration c = LmsConfiguration::factory(size);
  c.raw[2] = static_cast<std::uint8_t>(stop);
  c.set_measuring_mode(mode);
  c.set_unit(unit);
  return c;
}

/// As the manual prints them, or made with the checked CRC.
struct Printed {
  Telegram telegram;
  Bytes frame;
};

std::vector<Printed> printed_commands() {
  const std::vector<Subrange> whole{{1, 401}}, half{{1, 361}};
  return {
      {ask(Command::status), bytes("02 00 01 00 31 15 12")},
      {ask(Command::type), bytes("02 00 01 00 3A 1E 12")},
      {ask(Command::errors), bytes("02 00 01 00 32 16 12")},
      {ask(Command::reset), bytes("02 00 01 00 10 34 12")},
      {ask(Command::counters), bytes("02 00 01 00 35 11 12")},
      {ask(Command::configuration), bytes("02 00 01 00 74 50 12")},
      {ask(Command::configuration_2), bytes("02 00 01 00 7B 5F 12")},
      {ask(Command::outputs), bytes("02 00 01 00 4A 6E 12")},
      {ask_baud(9600), bytes("02 00 02 00 20 42 52 08")},
      {ask_baud(19200), bytes("02 00 02 00 20 41 51 08")},
      {ask_baud(38400), bytes("02 00 02 00 20 40 50 08")},
      {ask_baud(500000), bytes("02 00 02 00 20 48 58 08")},
      {ask_installation(), bytes("02 00 0A 00 20 00 53 49 43 4B 5F 4C 4D 53 BE C5")},
      {ask_test_password("SICK_LMS"), bytes("02 00 0A 00 20 30 53 49 43 4B 5F 4C 4D 53 EE F5")},
      {ask_mode(Mode::continuous), bytes("02 00 02 00 20 24 34 08")},
      {ask_mode(Mode::on_request), bytes("02 00 02 00 20 25 35 08")},
      {ask_mode(Mode::interlaced), bytes("02 00 02 00 20 2A 3A 08")},
      {ask_mean_stream(10), bytes("02 00 03 00 20 26 0A 76 3E")},
      {ask_subrange_stream({27, 299}), bytes("02 00 06 00 20 27 1B 00 2B 01 FF FE")},
      {ask_reflectivity_stream(half), bytes("02 00 08 00 20 2B 01 00 01 00 69 01 16 87")},
      {ask_scan(), bytes("02 00 02 00 30 01 31 18")},
      {ask_scan(ScanKind::partial), bytes("02 00 02 00 30 08 38 18")},
      {ask_mean_scan(2), bytes("02 00 02 00 36 02 3E 1E")},
      {ask_subrange_scan({1, 361}), bytes("02 00 05 00 37 01 00 69 01 EB 75")},
      {ask_mean_subrange_scan(2, {1, 298}), bytes("02 00 06 00 3F 02 01 00 2A 01 9D 4E")},
      {ask_fields_scan({1, 401}), bytes("02 00 05 00 3E 01 00 91 01 8B C4")},
      {ask_reflectivity_scan(whole), bytes("02 00 07 00 75 01 00 01 00 91 01 7D B6")},
      {ask_s14_scan({1, 181}), bytes("02 00 05 00 44 01 00 B5 00 68 37")},
      {ask_cartesian_scan({1, 298}), bytes("02 00 05 00 76 01 00 2A 01 72 BA")},
      {ask_power_on(0), bytes("02 00 02 00 66 00 9C 4E")},
      {ask_power_on(1), bytes("02 00 02 00 66 01 9D 4E")},
      {ask_active_fields(), bytes("02 00 02 00 41 00 D2 69")},
      {ask_variant({100, 100}), bytes("02 00 05 00 3B 64 00 64 00 1D 0F")},
      {ask_variant({100, 50}), bytes("02 00 05 00 3B 64 00 32 00 B1 59")},
      {ask_variant({100, 25}), bytes("02 00 05 00 3B 64 00 19 00 E7 72")},
      {ask_variant({180, 100}), bytes("02 00 05 00 3B B4 00 64 00 97 49")},
      {ask_variant({180, 50}), bytes("02 00 05 00 3B B4 00 32 00 3B 1F")},
      {ask_write_configuration(configuration(32, 0, 0, Unit::millimetre)),
       zeros("02 00 21 00 77 00 00 00 00 00 00 01 00 00 02 02", 21, "FC 7E")},
      {ask_write_configuration(configuration(32, 0, 0, Unit::centimetre)),
       zeros("02 00 21 00 77 00 00 00 00 00 00 00 00 00 02 02", 21, "E8 72")},
      {ask_write_configuration(configuration(34, 0x70, 0, Unit::millimetre)),
       zeros("02 00 23 00 77 00 00 70 00 00 00 01 00 00 02 02", 21, "02 00 11 88")},
      {ask_write_configuration(configuration(34, 0x46, 0, Unit::centimetre)),
       zeros("02 00 23 00 77 00 00 46 00 00 00 00 00 00 02 02", 21, "02 00 9D 57")},
      {ask_write_configuration(configuration(34, 0x46, 6, Unit::millimetre)),
       zeros("02 00 23 00 77 00 00 46 00 00 06 01 00 00 02 02", 21, "02 00 08 A4")},
      {ask_write_configuration_2(Bytes(84)), zeros("02 00 55 00 7C", 84, "0E 9E")},
  };
}

std::vector<Printed> printed_replies() {
  const Sender zero{0x80}, one{0x81};
  const std::string id = "LMS200;301063;V02.10 ";
  return {
      {tell_mode_result(ModeResult::done, zero), bytes("02 80 03 00 A0 00 10 16 0A")},
      {tell_mode_result(ModeResult::done, one), bytes("02 81 03 00 A0 00 10 36 1A")},
      {tell_mode_result(ModeResult::wrong_password, zero), bytes("02 80 03 00 A0 01 10 14 0B")},
      {tell_variant_result({true, {180, 50}}, zero),
       bytes("02 80 07 00 BB 01 B4 00 32 00 10 03 9D")},
      {tell_variant_result({true, {100, 100}}, one),
       bytes("02 81 07 00 BB 01 64 00 64 00 10 4A 3F")},
      {tell_variant_result({false, {180, 50}}, zero),
       bytes("02 80 07 00 BB 00 B4 00 32 00 10 23 8D")},
      {tell(Reply::reset, zero), bytes("02 80 02 00 91 10 79 30")},
      {tell(Reply::refused, zero), bytes("02 80 02 00 92 10 7F 33")},
      {tell_errors({}, zero), bytes("02 80 02 00 B2 10 3F 13")},
      {tell_raw(Reply::outputs, bytes("01 01 01"), zero),
       bytes("02 80 05 00 CA 01 01 01 10 2C B8")},
      {tell_counters({0, 1}, zero), bytes("02 80 06 00 B5 00 00 01 00 10 04 42")},
      {tell_identity(identity_of(id), zero),
       bytes("02 80 17 00 BA 4C 4D 53 32 30 30 3B 33 30 31 30 36 "
             "33 3B 56 30 32 2E 31 30 20 10 22 61")},
      {tell_identity(identity_of(id), zero, true),
       bytes("02 80 17 00 90 4C 4D 53 32 30 30 3B 33 30 31 "
             "30 36 33 3B 56 30 32 2E 31 30 20 10 63 5E")},
      {tell_configuration_result({true, configuration(34, 0x70, 0, Unit::millimetre)}, zero),
       zeros("02 80 25 00 F7 01 00 00 70 00 00 00 01 00 00 02 02", 21, "02 00 10 C5 7A")},
      {tell_configuration_result({true, configuration(34, 0x70, 4, Unit::millimetre)}, zero),
       zeros("02 80 25 00 F7 01 00 00 70 00 00 04 01 00 00 02 02", 21, "02 00 10 CF 7F")},
      {tell_configuration_result({false, configuration(32, 0x46, 0x0D, Unit::centimetre)}, one),
       zeros("02 81 23 00 F7 00 00 00 46 00 00 0D 00 00 00 02 02", 21, "10 D2 F2")},
      {tell_configuration(configuration(34, 0x70, 4, Unit::millimetre), zero),
       zeros("02 80 24 00 F4 00 00 70 00 00 04 01 00 00 02 02", 21, "02 00 10 36 FE")},
  };
}

TEST(LmsTelegrams, AsPrinted) {
  for (const Printed& p : printed_commands()) EXPECT_EQ(encode(p.telegram), p.frame);
  for (const Printed& p : printed_replies()) EXPECT_EQ(encode(p.telegram), p.frame);
}

// Every vector comes out of one of the encoders; a few are written here, the others above.
TEST(LmsTelegrams, EveryVectorOfTheDataFolderIsSaid) {
  MAJAK_NEEDS_SICK_DATA();
  std::vector<Printed> known = printed_commands();
  for (const Printed& p : printed_replies()) known.push_back(p);
  for (const Variant& v : kVariants) {
    for (const Sender& from : {Sender{0x80}, Sender{0x81}}) {
      known.push_back({tell_variant_result({true, v}, from), {}});
    }
  }
  LmsConfiguration fields = configuration(34, 0x46, 0, Unit::millimetre);
  const Bytes contours = bytes("00 0A 0A 50 64 00 0A 0A 50 80 00 0A 0A 50 64");
  fields.raw[11] = 2;
  std::copy(contours.begin(), contours.end(), fields.raw.begin() + 13);
  known.push_back({ask_write_configuration(fields), {}});
  for (const testing::Vector& v : testing::sick_vectors()) {
    if (!v.crc_ok || !v.length_ok) continue;
    const auto says = [&](const Printed& p) { return encode(p.telegram) == v.frame; };
    EXPECT_TRUE(std::any_of(known.begin(), known.end(), says)) << v.name;
  }
}

TEST(LmsTelegrams, CommandsAreUnderstood) {
  EXPECT_EQ(decode_mode(ask_mode(Mode::interlaced)), Mode::interlaced);
  EXPECT_EQ(decode_password(ask_installation("abcd_123")), "abcd_123");
  EXPECT_EQ(decode_password(ask_mode(Mode::continuous)), std::nullopt);
  for (const int baud : kBauds) EXPECT_EQ(decode_baud(ask_baud(baud)), baud);
  EXPECT_EQ(decode_baud(ask_mode(Mode::continuous)), std::nullopt);
  for (const Variant& v : kVariants) EXPECT_EQ(decode_variant(ask_variant(v)), v);
  EXPECT_EQ(decode_variant(ask(Command::status)), std::nullopt);
  const LmsConfiguration c = configuration(32, 7, 3, Unit::millimetre);
  EXPECT_EQ(decode_write_configuration(ask_write_configuration(c)), c);
  EXPECT_EQ(decode_mode(ask(Command::status)), std::nullopt);
}

TEST(LmsTelegrams, RequestsForScansAreUnderstood) {
  const std::vector<Subrange> two{{1, 10}, {20, 20}};
  const Subrange direct{5, 9, true};
  const auto check = [](const Telegram& t, int mean_of, const std::vector<Subrange>& beams) {
    const auto request = decode_scan_request(t);
    ASSERT_TRUE(request.has_value()) << int{t.code};
    EXPECT_EQ(request->mean_of, mean_of);
    EXPECT_EQ(request->beams, beams);
    Telegram shorter = t, longer = t;
    shorter.data.pop_back();
    longer.data.push_back(1);
    EXPECT_FALSE(decode_scan_request(shorter).has_value());
    EXPECT_FALSE(decode_scan_request(longer).has_value());
  };
  check(ask_mean_stream(10), 10, {});
  check(ask_mean_scan(250), 250, {});
  check(ask_subrange_stream(direct), 1, {direct});
  check(ask_subrange_scan(direct), 1, {direct});
  check(ask_fields_stream(direct), 1, {direct});
  check(ask_fields_scan(direct), 1, {direct});
  check(ask_mean_subrange_stream(3, direct), 3, {direct});
  check(ask_mean_subrange_scan(3, direct), 3, {direct});
  check(ask_reflectivity_stream(two), 1, two);
  check(ask_reflectivity_scan(two), 1, two);
  check(ask_s14_scan(direct), 1, {direct});
  EXPECT_FALSE(decode_scan_request(ask_mode(Mode::continuous)).has_value());
  EXPECT_FALSE(decode_scan_request(ask(Command::status)).has_value());
  Telegram t = ask_subrange_scan({3, 8});
  t.data[0] = 0;  // beams count from 1
  EXPECT_FALSE(decode_scan_request(t).has_value());
  t.data[0] = 9;  // first behind last
  EXPECT_FALSE(decode_scan_request(t).has_value());
}

TEST(LmsTelegrams, WhatCannotBeAskedIsAnError) {
  EXPECT_THROW(ask_baud(57600), Error);
  EXPECT_THROW(ask_installation("SICK"), Error);
  EXPECT_THROW(ask_installation("SICK-LMS"), Error);
  EXPECT_THROW(ask_mean_scan(1), Error);
  EXPECT_THROW(ask_mean_stream(251), Error);
  EXPECT_THROW(ask_subrange_scan({0, 5}), Error);
  EXPECT_THROW(ask_subrange_scan({5, 4}), Error);
  EXPECT_THROW(ask_subrange_scan({1, 402}), Error);
  EXPECT_THROW(ask_reflectivity_scan({}), Error);
  EXPECT_THROW(ask_reflectivity_scan(std::vector<Subrange>(6)), Error);
  EXPECT_THROW(ask_write_configuration(LmsConfiguration{Bytes(33)}), Error);
  EXPECT_THROW(ask_write_configuration_2(Bytes(83)), Error);
}

TEST(LmsTelegrams, RepliesAreUnderstood) {
  const Sender from{0x85, 0x11};
  EXPECT_EQ(tell(Reply::reset, from).address, 0x85);
  EXPECT_EQ(tell(Reply::reset, from).status, 0x11);
  EXPECT_EQ(decode_mode_result(tell_mode_result(ModeResult::fault, from)), ModeResult::fault);
  const auto variant = decode_variant_result(tell_variant_result({false, {100, 25}}, from));
  ASSERT_TRUE(variant.has_value());
  EXPECT_FALSE(variant->accepted);
  EXPECT_EQ(variant->variant, (Variant{100, 25}));
  const auto counters = decode_counters(tell_counters({4242, 77}, from));
  EXPECT_EQ(counters->hours, 4242);
  EXPECT_EQ(counters->switch_ons, 77);
  const auto power_on = decode_power_on_result(tell_power_on_result({true, 1}, from));
  EXPECT_TRUE(power_on->accepted);
  EXPECT_EQ(power_on->rule, 1);
  const LmsConfiguration c = configuration(34, 1, 2, Unit::decimetre);
  EXPECT_EQ(decode_configuration(tell_configuration(c, from)), c);
  const auto written = decode_configuration_result(tell_configuration_result({true, c}, from));
  EXPECT_TRUE(written->accepted);
  EXPECT_EQ(written->configuration, c);
  EXPECT_THAT(*decode_raw(Reply::outputs, tell_raw(Reply::outputs, Bytes{1, 2}, from)),
              ElementsAre(1, 2));
}

TEST(LmsTelegrams, OtherTelegramsAndWrongLengthsAreNoReplies) {
  const Sender from;
  for (Telegram t :
       {tell_mode_result(ModeResult::done, from), tell_variant_result({true, {180, 50}}, from),
        tell_counters({}, from), tell_power_on_result({}, from), tell_status({}, from),
        tell_configuration(LmsConfiguration::factory(), from),
        tell_configuration_result({true, LmsConfiguration::factory()}, from)}) {
    const auto understood = [&] {
      return int{decode_mode_result(t).has_value()} + int{decode_variant_result(t).has_value()} +
             int{decode_counters(t).has_value()} + int{decode_power_on_result(t).has_value()} +
             int{decode_status(t).has_value()} + int{decode_configuration(t).has_value()} +
             int{decode_configuration_result(t).has_value()} + int{decode_errors(t).has_value()} +
             int{decode_identity(t).has_value()};
    };
    EXPECT_EQ(understood(), 1) << int{t.code};
    t.data.push_back(0);
    EXPECT_EQ(understood(), 0) << int{t.code};
    t.data.clear();
    EXPECT_EQ(understood(), 0) << int{t.code};
  }
}

TEST(LmsTelegrams, IdentitiesAreTakenApart) {
  const LmsIdentity padded = identity_of("LMS291; S05 ;V02.19  ");
  EXPECT_EQ(padded.model, "LMS291");
  EXPECT_EQ(padded.type, "S05");
  EXPECT_EQ(padded.firmware, "V02.19");
  EXPECT_EQ(identity_of("LMS200").model, "LMS200");
  EXPECT_EQ(identity_of("LMS200").type, "");
  EXPECT_EQ(identity_of("A;B").type, "B");
  EXPECT_EQ(identity_of("").model, "");
}

TEST(LmsTelegrams, ErrorsOfARealDevice) {
  const auto t =
      decode(bytes("02 80 18 00 B2 84 16 84 31 84 31 84 31 84 31 84 31 84 31 84 31 84 31 84 "
                   "16 01 31 11 62 1F"));
  const auto errors = decode_errors(*t);
  ASSERT_EQ(errors->size(), 11u);
  EXPECT_EQ(errors->front(), (LmsErrorEntry{LmsErrorEntry::Severity::fatal, false, 0x16}));
  EXPECT_EQ(errors->back(), (LmsErrorEntry{LmsErrorEntry::Severity::info, true, 0x31}));
  EXPECT_EQ(tell_errors(*errors, {0x80, 0x11}), *t);
}

TEST(LmsTelegrams, StatusGoesToAndFro) {
  LmsStatus s;
  s.firmware = "V02.19 ";
  s.mode = 0x24;
  s.defect = true;
  s.serial = "01234567";
  s.pollution = {1, 2, 3, 4, 5, 6, 7, 65535};
  s.pollution_calibration = {8, 7, 6, 5, 4, 3, 2, 1};
  s.measuring_mode = 6;
  s.variant = {100, 25};
  s.permanent_baud = true;
  s.address = 3;
  s.unit = Unit::millimetre;
  s.laser_on = false;
  s.boot_firmware = "V02.02 ";
  for (const int baud : kBauds) {
    s.baud = baud;
    const auto back = decode_status(tell_status(s, {}));
    ASSERT_TRUE(back.has_value());
    EXPECT_EQ(back->firmware, s.firmware);
    EXPECT_EQ(back->mode, s.mode);
    EXPECT_EQ(back->defect, s.defect);
    EXPECT_EQ(back->serial, s.serial);
    EXPECT_EQ(back->pollution, s.pollution);
    EXPECT_EQ(back->pollution_calibration, s.pollution_calibration);
    EXPECT_EQ(back->motor, 148);
    EXPECT_EQ(back->measuring_mode, s.measuring_mode);
    EXPECT_EQ(back->variant, s.variant);
    EXPECT_EQ(back->baud, baud);
    EXPECT_EQ(back->permanent_baud, s.permanent_baud);
    EXPECT_EQ(back->address, s.address);
    EXPECT_EQ(back->unit, s.unit);
    EXPECT_EQ(back->laser_on, s.laser_on);
    EXPECT_EQ(back->boot_firmware, s.boot_firmware);
  }
}

TEST(LmsTelegrams, RecordedStatusAndConfiguration) {
  MAJAK_NEEDS_SICK_DATA();
  int statuses = 0, configurations = 0, identities = 0;
  for (const Bytes& frame : testing::sick_recorded()) {
    const auto t = decode(frame);
    const Sender from{t->address, *t->status};
    if (const auto s = decode_status(*t)) {
      ++statuses;
      EXPECT_EQ(s->firmware, "V02.19 ");
      EXPECT_EQ(s->serial, "05270497");
      EXPECT_FALSE(s->defect);
      EXPECT_EQ(s->motor, 148);
      EXPECT_EQ(s->measuring_mode, 4);
      EXPECT_EQ(s->variant, (Variant{180, 50}));
      EXPECT_EQ(s->baud, 38400);
      EXPECT_EQ(s->unit, Unit::millimetre);
      EXPECT_TRUE(s->laser_on);
      EXPECT_EQ(s->boot_firmware, "V02.02 ");
      EXPECT_EQ(tell_status(*s, from), *t);
    }
    if (const auto c = decode_configuration(*t)) {
      ++configurations;
      EXPECT_EQ(c->unit(), Unit::millimetre);
      EXPECT_EQ(c->measuring_mode(), 4);
      EXPECT_EQ(c->stop_threshold(), 0x70);
      EXPECT_FALSE(c->real_time_indices());
      EXPECT_EQ(tell_configuration(*c, from), *t);
    }
    if (const auto id = decode_identity(*t)) {
      ++identities;
      EXPECT_EQ(id->type, "S18063");
      EXPECT_EQ(tell_identity(*id, from), *t);
    }
  }
  EXPECT_EQ(statuses, 2);
  EXPECT_EQ(configurations, 2);
  EXPECT_EQ(identities, 2);
}

TEST(LmsConfiguration, OnlyWhatIsSetChanges) {
  LmsConfiguration c{Bytes(34, 0xA5)};
  c.set_real_time_indices(true);
  EXPECT_TRUE(c.real_time_indices());
  c.set_real_time_indices(false);
  EXPECT_FALSE(c.real_time_indices());
  c.set_unit(Unit::millimetre);
  c.set_measuring_mode(6);
  c.set_sensitivity(3);
  EXPECT_EQ(c.blanking(), 0xA5A5);
  EXPECT_EQ(c.sensitivity(), 3);
  EXPECT_EQ(c.measuring_mode(), 6);
  EXPECT_EQ(c.unit(), Unit::millimetre);
  EXPECT_EQ(std::count(c.raw.begin(), c.raw.end(), 0xA5), 31);
}

}  // namespace
}  // namespace majak::sensor
