// SPDX-License-Identifier: Apache-2.0
// What happens when.
#include "majak/sensor/lms_emulator.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace majak::sensor {

namespace {

constexpr Time kNever = std::numeric_limits<Time>::max();

}  // namespace

void describe(OptionFields& fields, LmsFaults& f) {
  const auto share = [](const char* help) { return OptionInfo{"1", help, 0, 1}; };
  fields.add("fault.drop", f.drop, share("bytes that are lost"));
  fields.add("fault.duplicate", f.duplicate, share("bytes that come twice"));
  fields.add("fault.flip", f.flip, share("bytes with a flipped bit"));
  fields.add("fault.truncate", f.truncate, share("scans that are cut off"));
  fields.add("fault.noise", f.noise, share("scans with noise and false headers before them"));
  fields.add("fault.handshakes", f.handshakes, share("scans with bytes 06 and 15 before them"));
  fields.add("fault.wrong_length", f.wrong_length, share("scans that say to be longer"));
  fields.add("fault.odd_count", f.odd_count, share("scans with a value too few and a right CRC"));
  fields.add("fault.dazzle", f.dazzle, share("scans of which a part is dazzled"));
  fields.add("fault.swallow_every", f.swallow_every, {"", "every k-th command is not heard", 0});
  fields.add("fault.nak_first", f.nak_first, {"", "so many commands are answered by NAK", 0});
  fields.add("fault.pollution", f.pollution, {"", "the front window is dirty"});
  fields.add("fault.implausible", f.implausible, {"", "values cannot be trusted"});
  fields.add("fault.fatal", f.fatal, {"", "the device is out of order"});
  fields.add("fault.reset_at", f.reset_at, {"s", "a restart; negative: never"});
  fields.add("fault.hang_at", f.hang_at, {"s", "neither hears nor speaks; negative: never"});
  fields.add("fault.hang_for", f.hang_for, {"s", "so long", 0});
  fields.add("fault.unplug_at", f.unplug_at, {"s", "the cable is out; negative: never"});
  fields.add("fault.unplug_for", f.unplug_for, {"s", "so long", 0});
}

LmsEmulatorOptions lms291_s05() {
  LmsEmulatorOptions o;
  o.status.firmware = "V02.19 ";
  o.status.boot_firmware = "V02.02 ";
  o.status.serial = "00291001";
  o.status.pollution.fill(200);
  o.status.pollution_calibration.fill(200);
  return o;
}

LmsEmulatorOptions lms200_recorded() {
  LmsEmulatorOptions o = lms291_s05();
  o.identity = "LMS200;S18063;V02.19 ";
  o.status.serial = "05270497";
  o.configuration.raw[2] = 0x70;
  o.configuration.set_measuring_mode(4);
  o.configuration.set_unit(Unit::millimetre);
  using Severity = LmsErrorEntry::Severity;
  o.errors = {{Severity::fatal, false, 0x16}, {Severity::info, true, 0x31}};
  return o;
}

LmsEmulator::LmsEmulator(const LmsEmulatorOptions& options, Source source, Time start)
    : options_(options),
      source_(std::move(source)),
      start_(start),
      random_(options.seed, 1),
      ear_(TelegramFramer::Direction::host_to_device, options.gap),
      mouth_({start, options.mirror_turn, options.bytes_per_turn}, RandomStream(options.seed, 2)),
      baud_(options.baud),
      variant_(options.variant),
      configuration_2_(84) {
  mouth_.set_baud(baud_);
  boot_end_ = start + options.boot;
  if (!options.booted) return;
  power_ = Power::ready;
  mode_ = options.mode;
  if (mode_ != Mode::on_request) start_stream(ask_mode(mode_));
}

void LmsEmulator::set_faults(const LmsFaults& faults) {
  faults_ = faults;
  mouth_.set_faults({faults.drop, faults.duplicate, faults.flip});
  naks_left_ = faults.nak_first;
  reset_done_ = hang_done_ = false;
}

void LmsEmulator::receive(std::span<const std::uint8_t> bytes, int host_baud, Time now) {
  advance(now);
  if (bytes.empty() || power_ != Power::ready || hung(now) || unplugged(now)) return;
  ear_.expire(now);
  while (ear_.next()) {
  }
  std::vector<std::uint8_t> heard(bytes.begin(), bytes.end());
  if (host_baud != baud_) {
    for (std::uint8_t& b : heard) b = static_cast<std::uint8_t>(0x80 | random_.below(128));
  }
  ear_.push(heard, now);
  hear(now);
}

void LmsEmulator::advance(Time now) {
  for (;;) {
    const Time next = next_change();
    if (const auto done = mouth_.advance(std::min(now, next))) {
      finish(*done);
      continue;
    }
    if (next > now) return;
    change(next);
  }
}

std::vector<Chunk> LmsEmulator::transmit(Time now, int host_baud) {
  advance(now);
  std::vector<Chunk> chunks = mouth_.take();
  if (unplugged(now)) return {};
  for (Chunk& chunk : chunks) {
    if (chunk.byte_time == LmsUart::byte_time_of(host_baud)) continue;
    for (std::uint8_t& b : chunk.bytes) {
      // Start bits are seen where none are. No telegram has two bytes like this in its header.
      b = static_cast<std::uint8_t>(0x80 | random_.below(128));
    }
  }
  return chunks;
}

Time LmsEmulator::next_event() const {
  return std::min(next_change(), mouth_.next().value_or(kNever));
}

// ---- What comes by itself: the end of a turn or of the boot, and the faults with a time. --------

bool LmsEmulator::hung(Time now) const {
  const Time at = start_ + from_seconds(faults_.hang_at);
  return faults_.hang_at >= 0 && now >= at && now < at + from_seconds(faults_.hang_for);
}

bool LmsEmulator::unplugged(Time now) const {
  const Time at = start_ + from_seconds(faults_.unplug_at);
  return faults_.unplug_at >= 0 && now >= at && now < at + from_seconds(faults_.unplug_for);
}

Time LmsEmulator::next_change() const {
  Time next = turn_begin(turn_ + 1);
  if (power_ == Power::booting) next = std::min(next, boot_end_);
  const auto fault = [&](double at, bool done) {
    if (at >= 0 && !done) next = std::min(next, start_ + from_seconds(at));
  };
  fault(faults_.reset_at, reset_done_);
  fault(faults_.hang_at, hang_done_);
  return next;
}

void LmsEmulator::change(Time now) {
  const auto due = [&](double at, bool& done) {
    if (at < 0 || done || start_ + from_seconds(at) > now) return false;
    return done = true;
  };
  if (due(faults_.hang_at, hang_done_)) mouth_.silence();
  if (due(faults_.reset_at, reset_done_)) reset(now);
  if (power_ == Power::booting && boot_end_ <= now) end_boot(now);
  if (turn_begin(turn_ + 1) <= now) end_turn(now);
}

void LmsEmulator::finish(const LmsUart::Done& done) {
  if (done.after == LmsUart::After::reset) begin_boot(done.at);
  if (done.after == LmsUart::After::set_baud) {
    baud_ = done.baud;
    mouth_.set_baud(baud_);
    ear_.clear();
  }
}

void LmsEmulator::reset(Time now) { begin_boot(now); }

void LmsEmulator::begin_boot(Time now) {
  ++counts_.restarts;
  mouth_.silence();
  ear_.clear();
  stream_.reset();
  once_.reset();
  options_.errors.clear();
  power_ = Power::booting;
  boot_end_ = now + options_.boot;
}

void LmsEmulator::end_boot(Time now) {
  power_ = Power::ready;
  mode_ = Mode::on_request;
  variant_ = options_.variant;
  if (!options_.permanent_baud) baud_ = 9600;
  mouth_.set_baud(baud_);
  telegrams_ = 0;
  ready_turn_ = turn_ + 1;
  const Telegram identity = tell_identity(identity_of(options_.identity), sender(), true);
  mouth_.send({encode(identity), now});
}

// A scan that ends now is sent if the line is free, and lost if not.
void LmsEmulator::end_turn(Time now) {
  ++turn_;
  if (power_ != Power::ready || hung(now) || !mouth_.idle()) return;
  if (once_ && begins_with(*once_, turn_)) {
    streaming_ = false;
    send_scan(*std::exchange(once_, std::nullopt), now);
  } else if (stream_ && begins_with(*stream_, turn_)) {
    streaming_ = true;
    send_scan(*stream_, now);
  }
}

}  // namespace majak::sensor
