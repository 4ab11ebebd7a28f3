// SPDX-License-Identifier: Apache-2.0
#include "majak/sensor/cola_emulator.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "majak/core/error.hpp"

namespace majak::sensor {
namespace {

constexpr Duration kProcessing = 2'000'000;  // ns from the last beam to the first byte

enum Refusal : unsigned {
  access_denied = 1,
  unknown_method = 2,
  unknown_variable = 3,
  invalid_data = 5,
  unknown_command = 12,
  unknown_event = 15
};

std::int32_t ten_thousandths(double degrees) {
  return static_cast<std::int32_t>(std::lround(degrees * 1e4));
}

std::uint16_t raw_of(double range, double scale) {
  const double raw = std::round(range * 1000 / scale);
  const bool measurable = raw >= kFirstColaDistance && raw <= 65535;  // false for NaN
  return measurable ? static_cast<std::uint16_t>(raw) : std::uint16_t{0};
}

}  // namespace

void describe(OptionFields& fields, ColaEmulatorOptions& o) {
  fields.add("cola.boot_time", o.boot_time, {"s", "silence after power-up", 0, 600});
  fields.add("cola.spin_up_time", o.spin_up_time, {"s", "from the order to the first turn", 0, 60});
  fields.add("cola.mirror_rate", o.mirror_rate, {"Hz", "turns of the mirror", 1, 100});
  fields.add("cola.start_angle", o.start_angle, {"deg", "bearing of the first beam", -180, 180});
  fields.add("cola.angle_step", o.angle_step, {"deg", "between beams", 0.04, 6});
  fields.add("cola.beams", o.beams, {"1", "beams of a scan", 1, 9000});
  fields.add("cola.scale", o.scale, {"mm", "of a digit", 0.1, 10});
  fields.add("cola.intensities", o.intensities, {"", "sends the strength of the echoes"});
}

ColaEmulator::ColaEmulator(const ColaEmulatorOptions& options, Ranges ranges, Time power_up)
    : options_(options), ranges_(std::move(ranges)), dialect_(options.dialect) {
  reset(power_up);
}

void ColaEmulator::reset(Time now) {
  power_up_ = now;
  ready_ = now + from_seconds(options_.boot_time);
  telegrams_ = 0;
  authorized_ = ordered_ = false;
  first_turn_.reset();
  if (options_.measures_at_once) start_measuring(ready_);
  connected();
}

void ColaEmulator::connected() {
  framer_.clear();
  subscribed_ = false;
  output_.clear();
}

void ColaEmulator::start_measuring(Time now) {
  first_turn_ = now + from_seconds(options_.spin_up_time);
  next_turn_ = 0;
}

bool ColaEmulator::measures(Time now) const { return first_turn_ && now >= *first_turn_; }

Time ColaEmulator::turn_start(std::int64_t turn) const {
  return first_turn_.value_or(ready_) +
         from_seconds(static_cast<double>(turn) / options_.mirror_rate);
}

Time ColaEmulator::sent_at(std::int64_t turn) const {
  const double sweep = options_.beams * options_.angle_step / 360 / options_.mirror_rate;
  return turn_start(turn) + from_seconds(sweep) + kProcessing;
}

// So many turns of the mirror have been measured and processed.
std::int64_t ColaEmulator::turns_through(Time now) const {
  if (!first_turn_ || now < sent_at(0)) return 0;
  auto turns = static_cast<std::int64_t>(to_seconds(now - sent_at(0)) * options_.mirror_rate);
  while (sent_at(turns) <= now) ++turns;
  return turns;
}

std::uint32_t ColaEmulator::clock(Time time) const {
  return options_.clock_start + static_cast<std::uint32_t>((time - power_up_) / 1000);
}

Time ColaEmulator::wake_at() const { return first_turn_ ? sent_at(next_turn_) : INT64_MAX; }

std::vector<std::uint8_t> ColaEmulator::take_output() { return std::exchange(output_, {}); }

void ColaEmulator::advance(Time now) {
  const std::int64_t through = turns_through(now);
  if (!subscribed_) next_turn_ = std::max(next_turn_, through);
  for (; next_turn_ < through; ++next_turn_) {
    ++telegrams_;
    if (output_.size() > kMostOutput) continue;
    const auto bytes = cola_frame(dialect_, encode_scan(measure(next_turn_), dialect_));
    output_.insert(output_.end(), bytes.begin(), bytes.end());
    ++scans_sent_;
  }
}

ColaScan ColaEmulator::measure(std::int64_t turn) {
  ColaScan scan;
  scan.serial = options_.serial;
  scan.telegram_counter = telegrams_;
  scan.scan_counter = static_cast<std::uint16_t>(turn);
  scan.first_shot = clock(turn_start(turn));
  scan.transmission = clock(sent_at(turn));
  scan.mirror_rate = static_cast<std::uint32_t>(std::lround(options_.mirror_rate * 100));
  const double shots = options_.mirror_rate * 360 / options_.angle_step;  // Hz
  scan.measuring_rate = static_cast<std::uint32_t>(std::lround(shots / 100));
  if (!options_.name.empty() && sends_name_) scan.name = options_.name;

  ColaChannel distance;
  distance.name = "DIST1";
  distance.scale = static_cast<float>(options_.scale);
  distance.start_angle = ten_thousandths(options_.start_angle + 90);
  distance.angle_step = static_cast<std::uint16_t>(ten_thousandths(options_.angle_step));
  std::vector<double> ranges = ranges_(turn_start(turn));
  ranges.resize(static_cast<std::size_t>(options_.beams), kNoReturn);
  for (const double range : ranges) distance.raw.push_back(raw_of(range, options_.scale));
  if (options_.intensities) {
    ColaChannel strength = distance;
    strength.name = "RSSI1";
    strength.scale = 1;
    for (std::uint16_t& raw : strength.raw) raw = raw == 0 ? 0 : 254;
    (wide_intensities_ ? scan.channels16 : scan.channels8).push_back(strength);
  }
  scan.channels16.insert(scan.channels16.begin(), distance);
  return scan;
}

// ---- commands -------------------------------------------------------------------------------

void ColaEmulator::receive(std::span<const std::uint8_t> bytes, Time now) {
  if (now < ready_) return;
  framer_.push(bytes, now);
  while (const auto command = framer_.next()) {
    if (command->dialect != dialect_) continue;  // it does not understand the other one
    try {
      obey(*command, now);
    } catch (const Error&) {
      refuse(invalid_data);
    }
  }
}

void ColaEmulator::say(const ColaWriter& telegram) {
  const auto bytes = telegram.frame();
  output_.insert(output_.end(), bytes.begin(), bytes.end());
}

// In B the code follows without a blank.
void ColaEmulator::refuse(unsigned code) {
  if (dialect_ == ColaDialect::a)
    return say(ColaWriter(dialect_, "sFA").u16(static_cast<std::uint16_t>(code)));
  const char bytes[] = {'s', 'F', 'A', static_cast<char>(code >> 8), static_cast<char>(code)};
  const auto framed = cola_frame(dialect_, {bytes, sizeof bytes});
  output_.insert(output_.end(), framed.begin(), framed.end());
}

void ColaEmulator::obey(const ColaTelegram& command, Time now) {
  if (command.kind() == "sMN") return call(command, now);
  if (command.kind() == "sRN") return read(command, now);
  if (command.kind() == "sWN") return write(command);
  if (command.kind() == "sEN") return event(command, now);
  refuse(unknown_command);
}

void ColaEmulator::call(const ColaTelegram& command, Time now) {
  ColaCursor in(command);
  if (command.name() == "SetAccessMode") {
    const bool client = in.u8("the level") == 3;
    authorized_ = in.u32("the password") == options_.password && client;
    return say(ColaWriter(dialect_, "sAN SetAccessMode").u8(authorized_ ? 1 : 0));
  }
  if (command.name() == "LMCstartmeas" || command.name() == "LMCstopmeas") {
    if (!authorized_) return refuse(access_denied);
    ordered_ = command.name() == "LMCstartmeas";
    if (!ordered_) first_turn_.reset();
    return say(ColaWriter(dialect_, "sAN " + std::string(command.name())).u8(0));
  }
  if (command.name() == "Run") {
    authorized_ = false;
    if (ordered_ && !first_turn_) start_measuring(now);
    return say(ColaWriter(dialect_, "sAN Run").u8(1));
  }
  refuse(unknown_method);
}

void ColaEmulator::read(const ColaTelegram& command, Time now) {
  if (command.name() == "SCdevicestate")
    return say(ColaWriter(dialect_, "sRA SCdevicestate").u8(measures(now) ? 1 : 0));
  if (command.name() == "DeviceIdent" && !options_.identity.name.empty())
    return say(tell_identity(options_.identity, dialect_));
  if (command.name() == "STlms" && options_.knows_stlms) {
    // State, temperature, then time and date as texts of known length, and three lamps.
    const std::uint16_t state = measures(now) ? 7 : first_turn_ ? 5 : 3;
    ColaWriter out(dialect_, "sRA STlms");
    return say(out.u16(state).u16(0).text("00:00:00").text("01.01.06").u16(0).u16(0).u16(0));
  }
  const std::int64_t through = turns_through(now);
  if (command.name() == "LMDscandata" && through > 0) {
    ++telegrams_;
    ColaScan last = measure(through - 1);
    last.asked = true;
    const auto bytes = cola_frame(dialect_, encode_scan(last, dialect_));
    output_.insert(output_.end(), bytes.begin(), bytes.end());
    return;
  }
  refuse(unknown_variable);
}

void ColaEmulator::write(const ColaTelegram& command) {
  ColaCursor in(command);
  if (command.name() == "EIHstCola") {
    const ColaDialect wanted = in.u8("the dialect") == 0 ? ColaDialect::a : ColaDialect::b;
    say(ColaWriter(dialect_, "sWA EIHstCola"));
    dialect_ = wanted;
    return;
  }
  if (command.name() != "LMDscandatacfg") return refuse(unknown_variable);
  if (!authorized_) return refuse(access_denied);
  in.u8("the channel");
  in.u8("the channel");
  options_.intensities = in.u8("RSSI") != 0;
  wide_intensities_ = in.u8("its width") != 0;
  for (int i = 0; i < 4; ++i) in.u8("unit, encoder and position");
  sends_name_ = in.u8("the name") != 0;
  say(ColaWriter(dialect_, "sWA LMDscandatacfg"));
}

void ColaEmulator::event(const ColaTelegram& command, Time now) {
  if (command.name() != "LMDscandata") return refuse(unknown_event);
  ColaCursor in(command);
  advance(now);  // turns that were through before the command are not sent for it
  subscribed_ = in.u8("on or off") != 0;
  say(ColaWriter(dialect_, "sEA LMDscandata").u8(subscribed_ ? 1 : 0));
}

}  // namespace majak::sensor
