// SPDX-License-Identifier: Apache-2.0
// What the emulated device does when it is told something.
#include "majak/sensor/lms_emulator.hpp"

#include <algorithm>

namespace majak::sensor {

namespace {

constexpr Duration kBeforeReset = 10'000'000;  // ns from the answer to the restart

bool is_s14(const LmsEmulatorOptions& options) {
  return identity_of(options.identity).type == "S14";
}

constexpr int kMostFields = 100, kMostReflectivities = 200;  // beams in one telegram

/// The beams must exist in the scan that is measured, and have room.
bool possible(Reply code, const ScanRequest& request, int beams) {
  int sum = 0;
  for (const Subrange& b : request.beams) {
    if (b.last > beams) return false;
    sum += b.size();
  }
  if (code == Reply::fields_scan) return sum <= kMostFields;
  return code != Reply::reflectivity_scan || sum <= kMostReflectivities;
}

/// What streams look like.
std::optional<Reply> reply_of(Mode mode) {
  switch (mode) {
    case Mode::continuous:
    case Mode::interlaced:
      return Reply::scan;
    case Mode::continuous_mean:
      return Reply::mean_scan;
    case Mode::continuous_subrange:
      return Reply::subrange_scan;
    case Mode::continuous_mean_subrange:
      return Reply::mean_subrange_scan;
    case Mode::continuous_fields:
      return Reply::fields_scan;
    case Mode::continuous_reflectivity:
      return Reply::reflectivity_scan;
    default:
      return {};
  }
}

}  // namespace

Sender LmsEmulator::sender() const {
  unsigned status = kStatusFine;
  if (faults_.fatal) status |= static_cast<unsigned>(LmsHealth::Severity::fatal);
  if (faults_.pollution) status |= 0x80u | (faults_.fatal ? 0u : 2u);
  if (faults_.implausible) status |= 0x40u;
  return {static_cast<std::uint8_t>(kDeviceBit | options_.address),
          static_cast<std::uint8_t>(status)};
}

LmsStatus LmsEmulator::status() const {
  LmsStatus s = options_.status;
  s.mode = static_cast<std::uint8_t>(mode_);
  s.defect = faults_.fatal;
  s.motor = static_cast<int>(options_.mirror_turn / 90'000);
  s.measuring_mode = static_cast<std::uint8_t>(options_.configuration.measuring_mode());
  s.variant = variant_;
  s.baud = baud_;
  s.permanent_baud = options_.permanent_baud;
  s.address = options_.address;
  s.unit = options_.configuration.unit();
  return s;
}

void LmsEmulator::hear(Time now) {
  const std::int64_t damaged = ear_.counts().crc_errors;
  bool heard = false;
  while (const auto frame = ear_.next()) {
    heard = true;
    const Telegram& command = frame->telegram;
    if (command.address != 0 && command.address != options_.address) continue;
    ++commands_;
    if (faults_.swallow_every > 0 && commands_ % faults_.swallow_every == 0) continue;
    if (naks_left_ > 0) {
      --naks_left_;
      handshake(kNak, now);
      continue;
    }
    obey(command, now);
  }
  if (!heard && ear_.counts().crc_errors > damaged) handshake(kNak, now);
}

void LmsEmulator::handshake(std::uint8_t byte, Time now) {
  if (byte == kNak) ++counts_.naks;
  answered_ = now + options_.ack_delay;
  mouth_.send({{byte}, answered_, true});
}

// The host's word interrupts whatever is leaving.
void LmsEmulator::obey(const Telegram& command, Time now) {
  ++counts_.commands;
  if (!mouth_.idle() && streaming_) ++counts_.cut_off;
  for (const LmsUart::Done& done : mouth_.cut(now)) finish(done);
  once_.reset();
  if (power_ != Power::ready) return;  // what was cut off was the answer to a reset
  handshake(kAck, now);
  const Duration delay = options_.reply_delay;
  const Sender from = sender();
  switch (static_cast<Command>(command.code)) {
    case Command::mode:
      return change_mode(command);
    case Command::variant:
      return set_variant(command);
    case Command::write_configuration:
      return write_configuration(command);
    case Command::scan:
    case Command::mean_scan:
    case Command::subrange_scan:
    case Command::fields_scan:
    case Command::mean_subrange_scan:
    case Command::reflectivity_scan:
    case Command::s14_scan:
      return one_scan(command);
    case Command::reset:
      return answer(tell(Reply::reset, from), delay, LmsUart::After::reset);
    case Command::status:
      return answer(tell_status(status(), from), delay);
    case Command::errors:
      return answer(tell_errors(options_.errors, from), delay);
    case Command::counters:
      return answer(tell_counters(options_.counters, from), delay);
    case Command::type:
      return answer(tell_identity(identity_of(options_.identity), from), delay);
    case Command::outputs:
      return answer(tell_raw(Reply::outputs, std::vector<std::uint8_t>{1, 1, 1}, from), delay);
    case Command::configuration:
      return answer(tell_configuration(options_.configuration, from), delay);
    case Command::configuration_2:
      return answer(tell_raw(Reply::configuration_2, configuration_2_, from), delay);
    case Command::write_configuration_2: {
      if (mode_ != Mode::installation || command.data.size() != configuration_2_.size()) break;
      configuration_2_ = command.data;
      ++counts_.writes;
      std::vector<std::uint8_t> data{1};
      data.insert(data.end(), command.data.begin(), command.data.end());
      return answer(tell_raw(Reply::configuration_2_written, data, from), options_.write_delay);
    }
    case Command::power_on:
      if (mode_ != Mode::installation || command.data.size() != 1 || command.data[0] > 2) break;
      if (command.data[0] < 2) options_.permanent_baud = command.data[0] == 1;
      ++counts_.writes;
      return answer(tell_power_on_result({true, command.data[0]}, from), options_.write_delay);
    default:
      break;
  }
  refuse();
}

void LmsEmulator::answer(const Telegram& reply, Duration delay, LmsUart::After after, int baud) {
  streaming_ = false;
  mouth_.send({encode(reply), answered_ + delay, false, LmsUart::After::nothing, 0});
  if (after == LmsUart::After::nothing) return;
  // An output of no bytes: what is to be done when the answer has left.
  const Duration wait = after == LmsUart::After::reset ? kBeforeReset : 0;
  mouth_.send({{}, answered_ + delay + wait, false, after, baud});
}

void LmsEmulator::refuse() {
  ++counts_.refused;
  answer(tell(Reply::refused, sender()), options_.reply_delay);
}

void LmsEmulator::change_mode(const Telegram& command) {
  const Duration delay = options_.mode_delay;
  const auto done = [&](ModeResult result) { return tell_mode_result(result, sender()); };
  const auto mode = decode_mode(command);
  if (!mode) return refuse();
  if (const auto baud = decode_baud(command)) {
    return answer(done(ModeResult::done), delay, LmsUart::After::set_baud, *baud);
  }
  switch (*mode) {
    case Mode::installation:
    case Mode::test_password: {
      const auto password = decode_password(command);
      if (!password) return refuse();
      if (*password != options_.password) return answer(done(ModeResult::wrong_password), delay);
      if (*mode == Mode::test_password) return answer(done(ModeResult::done), delay);
      break;
    }
    case Mode::diagnosis:
    case Mode::on_request:
      if (command.data.size() != 1) return refuse();
      break;
    default:
      if (!start_stream(command)) return refuse();
      mode_ = *mode;
      return answer(done(ModeResult::done), delay);
  }
  stream_.reset();
  mode_ = *mode;
  answer(done(ModeResult::done), delay);
}

void LmsEmulator::set_variant(const Telegram& command) {
  const auto wanted = decode_variant(command);
  if (!wanted || is_s14(options_)) return refuse();
  const bool known = std::find(kVariants.begin(), kVariants.end(), *wanted) != kVariants.end();
  if (known) {
    variant_ = *wanted;
    ready_turn_ = turn_ + 1;
    if (stream_ && !possible(stream_->code, stream_->request, variant_.beams())) {
      stream_.reset();
      mode_ = Mode::on_request;
    }
  }
  answer(tell_variant_result({known, variant_}, sender()), options_.mode_delay);
}

void LmsEmulator::write_configuration(const Telegram& command) {
  if (mode_ != Mode::installation) return refuse();
  const auto wanted = decode_write_configuration(command);
  const bool fits = wanted && wanted->raw.size() == options_.configuration.raw.size() &&
                    metres(wanted->unit()) > 0;
  if (fits) {
    ++counts_.writes;
    options_.configuration = *wanted;
  }
  const ConfigurationResult result{fits, options_.configuration};
  answer(tell_configuration_result(result, sender()), options_.write_delay);
}

bool LmsEmulator::start_stream(const Telegram& command) {
  const Mode mode = *decode_mode(command);
  const auto code = reply_of(mode);
  if (!code) return false;
  Wish wish;
  wish.code = *code;
  wish.one_turn = mode == Mode::interlaced;
  wish.stream = true;
  wish.turn = turn_ + 1;
  if (*code == Reply::scan) {
    if (command.data.size() != 1) return false;
  } else {
    const auto request = decode_scan_request(command);
    if (!request || !possible(wish.code, *request, variant_.beams())) return false;
    wish.request = *request;
  }
  stream_ = wish;
  return true;
}

void LmsEmulator::one_scan(const Telegram& command) {
  Wish wish;
  wish.code = static_cast<Reply>(command.code | kDeviceBit);
  wish.turn = turn_ + 1;
  if (command.is(Command::scan)) {
    if (command.data.size() != 1) return refuse();
    const auto kind = static_cast<ScanKind>(command.data[0]);
    if (kind != ScanKind::whole && kind != ScanKind::partial) return refuse();
    wish.one_turn = kind == ScanKind::partial;
  } else {
    const auto request = decode_scan_request(command);
    if (!request || !possible(wish.code, *request, variant_.beams())) return refuse();
    if (command.is(Command::s14_scan) && !is_s14(options_)) return refuse();
    wish.request = *request;
    // A mean is that of scans to come.
    wish.turn += static_cast<std::int64_t>(request->mean_of - 1) * variant_.turns();
  }
  streaming_ = false;
  once_ = wish;
}

}  // namespace majak::sensor
