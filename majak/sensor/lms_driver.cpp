// SPDX-License-Identifier: Apache-2.0
#include "majak/sensor/lms_driver.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace majak::sensor {
namespace {

constexpr Duration kMillisecond = kSecond / 1000;
// Times of the telegram listing, with room for a USB adapter.
constexpr Duration kAckWithin = 200 * kMillisecond;     // 60 ms, and the way there and back
constexpr Duration kAfterNak = 40 * kMillisecond;       // at least 30 ms
constexpr Duration kModeWithin = 3300 * kMillisecond;   // a change of mode: 3 s
constexpr Duration kWriteWithin = 8 * kSecond;          // the EEPROM: 7 s
constexpr Duration kReplyWithin = 1500 * kMillisecond;  // 160 bytes at 9600 Bd are 170 ms
constexpr Duration kAfterBaud = 300 * kMillisecond;     // after the port's rate has changed
constexpr Duration kSettle = 20 * kMillisecond;
constexpr int kTries = 4, kSearchTries = 2;
constexpr Duration kSearchWithin = 350 * kMillisecond;  // for a word; 70 ms as a rule
constexpr std::array<int, 5> kSearchOrder{0, 38400, 500000, 9600, 19200};  // 0: the last good one

bool is_scan(const Telegram& t) {
  for (const Reply r : {Reply::scan, Reply::mean_scan, Reply::subrange_scan, Reply::fields_scan,
                        Reply::mean_subrange_scan, Reply::reflectivity_scan, Reply::s14_scan})
    if (t.is(r)) return true;
  return false;
}

Duration transmission(std::size_t bytes, int baud) {
  return static_cast<Duration>(bytes) * 10 * kSecond / baud;
}

}  // namespace

LmsDriver::LmsDriver(const LmsDriverOptions& options, Time now) : options_(options) { search(now); }

// ---- What is missing ------------------------------------------------------------------------

std::optional<LmsConfiguration> LmsDriver::wanted_configuration() const {
  if (!device_.configuration) return std::nullopt;
  LmsConfiguration wanted = *device_.configuration;
  if (options_.unit) wanted.set_unit(*options_.unit);
  if (options_.measuring_mode) wanted.set_measuring_mode(*options_.measuring_mode);
  if (options_.real_time_indices) wanted.set_real_time_indices(*options_.real_time_indices);
  if (wanted == *device_.configuration) return std::nullopt;
  return wanted;
}

int LmsDriver::wanted_baud() const { return options_.baud.value_or(std::max(baud_, 38400)); }

LmsDriver::Request LmsDriver::what_next() const {
  if (!stopped_) return {ask_mode(Mode::on_request), Reply::mode, kModeWithin, kTries};
  if (!asked_identity_) return {ask(Command::type), Reply::identity, kReplyWithin, kTries};
  if (!asked_status_) return {ask(Command::status), Reply::status, kReplyWithin, kTries};
  if (!asked_configuration_)
    return {ask(Command::configuration), Reply::configuration, kReplyWithin, kTries};
  if (!baud_refused_ && wanted_baud() != baud_)
    return {ask_baud(wanted_baud()), Reply::mode, kModeWithin, kTries};
  if (const auto wanted = wanted_configuration(); wanted && !configuration_refused_) {
    if (!installed_) return {ask_installation(options_.password), Reply::mode, kModeWithin, kTries};
    return {ask_write_configuration(*wanted), Reply::configuration_written, kWriteWithin, 1};
  }
  if (installed_) return {ask_mode(Mode::on_request), Reply::mode, kModeWithin, kTries};
  if (!variant_refused_ && options_.variant && *options_.variant != device_.variant)
    return {ask_variant(*options_.variant), Reply::variant, kModeWithin, kTries};
  return {ask_mode(options_.interlaced ? Mode::interlaced : Mode::continuous), Reply::mode,
          kModeWithin, kTries};
}

void LmsDriver::understand(const Telegram& reply, Time now) {
  const Telegram command = std::exchange(request_, std::nullopt)->command;
  const auto mode = decode_mode(command);
  const auto done = decode_mode_result(reply);
  if (const auto baud = decode_baud(command)) {
    if (done != ModeResult::done) {
      baud_refused_ = true;
      report_.count("the device refuses the baud rate; it stays as it is");
      return ask_next(now);
    }
    baud_ = good_baud_ = *baud;  // the answer still came at the old one
    framer_.clear();
    framer_.set_byte_time(transmission(1, baud_));
    asked_status_ = false;  // is it really there? ask
    return ask_next(now, kAfterBaud);
  }
  if (mode == Mode::installation) {
    installed_ = done == ModeResult::done;
    if (!installed_) {
      configuration_refused_ = true;
      report_.count("the device does not take the password; its configuration stays as it is");
    }
  } else if (mode == Mode::on_request) {
    stopped_ = true;
    installed_ = false;
  } else if (mode && done == ModeResult::done) {
    state_ = State::streaming;
    const int turns = options_.interlaced ? 1 : device_.variant.turns();
    period_ = turns * kMirrorTurn;
    clock_ = ScanClock({.period = period_});
    last_scan_ = now;
    return;
  } else if (mode) {
    report_.count("the device does not begin to send; asked again");
    return ask_next(now, kSecond);
  }
  if (const auto identity = decode_identity(reply)) device_.identity = *identity;
  if (const auto status = decode_status(reply)) {
    device_.status = *status;
    device_.variant = status->variant;
  }
  if (const auto configuration = decode_configuration(reply))
    device_.configuration = *configuration;
  if (const auto variant = decode_variant_result(reply)) {
    device_.variant = variant->variant;
    if (!variant->accepted) {
      variant_refused_ = true;
      report_.count("the device does not have this field of view and resolution; it keeps its own");
    }
  }
  if (const auto written = decode_configuration_result(reply)) {
    device_.configuration = written->configuration;
    if (!written->accepted || wanted_configuration()) {
      configuration_refused_ = true;
      report_.count("the device refuses the configuration; it stays as it is");
    }
  }
  asked_identity_ = asked_identity_ || command.is(Command::type);
  asked_status_ = asked_status_ || command.is(Command::status);
  asked_configuration_ = asked_configuration_ || command.is(Command::configuration);
  ask_next(now);
}

// 92: an old firmware does not know all commands. What it cannot tell is done without.
void LmsDriver::refused(Time now) {
  const Telegram command = std::exchange(request_, std::nullopt)->command;
  report_.count("the device refuses a command");
  asked_identity_ = asked_identity_ || command.is(Command::type);
  asked_status_ = asked_status_ || command.is(Command::status);
  asked_configuration_ = asked_configuration_ || command.is(Command::configuration);
  variant_refused_ = variant_refused_ || command.is(Command::variant);
  configuration_refused_ = configuration_refused_ || command.is(Command::write_configuration);
  baud_refused_ = baud_refused_ || decode_baud(command).has_value();
  const auto mode = decode_mode(command);
  configuration_refused_ = configuration_refused_ || mode == Mode::installation;
  ask_next(now, mode && *mode != Mode::installation ? kSecond : 0);
}

// ---- Requests -------------------------------------------------------------------------------

void LmsDriver::ask_next(Time now, Duration pause) {
  request_ = what_next();
  tries_ = state_ == State::searching && !heard_ ? kSearchTries : request_->tries;
  again(now, pause);
}

void LmsDriver::again(Time now, Duration pause) {
  sent_ = false;
  deadline_ = send_at_ = now + pause;
}

void LmsDriver::send(Time now) {
  const auto bytes = encode(request_->command);
  output_.insert(output_.end(), bytes.begin(), bytes.end());
  sent_ = true;
  acknowledged_ = false;
  --tries_;
  const Duration way = transmission(bytes.size(), baud_) + byte_pause() * 20;
  // A command that meets a busy device is lost without a word; one that is understood may take its
  // time.
  deadline_ = now + way + (state_ == State::searching ? kSearchWithin : kAckWithin);
}

// All tries are used up, or the answer to something that must not be said twice is missing.
void LmsDriver::give_up(Time now) {
  const bool wrote = request_ && request_->command.is(Command::write_configuration);
  if (state_ == State::searching && !heard_) return search(now);
  if (wrote) {
    asked_configuration_ = false;  // was it written? look before it is written again
    return ask_next(now);
  }
  report_.count("the device did not answer; looked for anew");
  forget();
  search(now);
}

void LmsDriver::advance(Time now) {
  framer_.expire(now);
  take_frames(now);
  if (now < wake_at()) return;
  if (state_ == State::streaming) {
    if (now - last_scan_ < silence()) return;
    report_.count("no more scans; the device was looked for anew");
    forget();
    return search(now);
  }
  if (now < deadline_ || !request_) return;
  if (!sent_) return send(now);
  if (tries_ > 0) return again(now, 0);
  give_up(now);
}

Time LmsDriver::wake_at() const {
  const Time mine = state_ == State::streaming ? last_scan_ + silence() : deadline_;
  const auto framers = framer_.expires_at();
  return framers ? std::min(mine, *framers) : mine;
}

// Four times what a telegram takes, and no less than a second.
Duration LmsDriver::silence() const {
  return std::max(kSecond, 4 * std::max(transmission(820, baud_), period_));
}

std::vector<std::uint8_t> LmsDriver::take_output() { return std::exchange(output_, {}); }

// ---- What comes in --------------------------------------------------------------------------

void LmsDriver::receive(std::span<const std::uint8_t> bytes, Time now) {
  framer_.push(bytes, now);
  take_frames(now);
}

void LmsDriver::take_frames(Time now) {
  while (auto frame = framer_.next()) take(*frame, now);
}

void LmsDriver::take(const Frame& frame, Time now) {
  if (frame.kind == Frame::Kind::ack) {
    if (request_ && sent_ && !acknowledged_) {
      acknowledged_ = true;
      deadline_ = now + request_->patience;
    }
    return;
  }
  if (frame.kind == Frame::Kind::nak) {
    if (!request_ || !sent_ || acknowledged_) return;
    report_.count("a command arrived damaged");
    tries_ = std::max(tries_, 1);
    return again(now, kAfterNak);
  }
  const Telegram& telegram = frame.telegram;
  if (device_.address != 0 && telegram.address != device_.address) return;
  found(telegram);
  if (telegram.is(Reply::power_on_identity)) return restarted(now);
  if (is_scan(telegram)) {
    if (state_ == State::streaming) deliver(frame, now);
    return;
  }
  if (!request_ || !sent_) return;
  if (telegram.is(Reply::refused)) return refused(now);
  if (telegram.is(request_->reply)) understand(telegram, now);
}

// Whatever has a right CRC: this is the rate.
void LmsDriver::found(const Telegram& telegram) {
  device_.address = telegram.address;
  good_baud_ = baud_;
  if (state_ != State::searching) return;
  if (!heard_) tries_ = std::max(tries_, kTries);
  heard_ = true;
  if (stopped_ || (sent_ && telegram.is(Reply::mode))) state_ = State::asking;
}

void LmsDriver::deliver(const Frame& frame, Time now) {
  const auto scan = decode_scan(frame.telegram);
  if (!scan || !fits(*scan, device_.variant))
    return report_.count("a telegram of measured values that contradicts itself; left out");
  const int turns = options_.interlaced ? 1 : device_.variant.turns();
  LmsDelivery d;
  d.scan = *scan;
  d.telegram = frame.telegram;
  d.first_byte = std::min(frame.first_byte, now);
  d.stamp = clock_.stamp(d.first_byte, scan->scan_index, turns);
  d.skipped = clock_.last_step() - 1;
  last_scan_ = now;
  deliveries_.push_back(std::move(d));
}

std::optional<LmsDelivery> LmsDriver::next() {
  if (deliveries_.empty()) return std::nullopt;
  LmsDelivery d = std::move(deliveries_.front());
  deliveries_.pop_front();
  return d;
}

// ---- Finding the device ---------------------------------------------------------------------

void LmsDriver::search(Time now) {
  state_ = State::searching;
  heard_ = false;
  if (candidate_ >= kSearchOrder.size()) candidate_ = 0;
  const int baud = kSearchOrder[candidate_++];
  if (baud == good_baud_ && candidate_ > 1) return search(now);  // it had its turn
  try_baud(baud == 0 ? good_baud_ : baud, now);
}

void LmsDriver::try_baud(int baud, Time now) {
  baud_ = baud;
  framer_.clear();
  framer_.set_byte_time(transmission(1, baud_));
  output_.clear();
  ask_next(now, kSettle);
}

// All that is gone with a restart: mode and variant are not kept, the baud may be.
void LmsDriver::forget() {
  device_ = {};
  stopped_ = asked_identity_ = asked_status_ = asked_configuration_ = installed_ = false;
  baud_refused_ = variant_refused_ = configuration_refused_ = false;
  request_.reset();
  candidate_ = 0;
}

void LmsDriver::restarted(Time now) {
  if (period_ > 0) report_.count("the device has restarted");  // else it only starts
  forget();
  state_ = State::asking;
  ask_next(now, kSettle);
}

void LmsDriver::reopened(Time now) {
  forget();
  search(now);
}

std::string LmsDriver::activity() const {
  switch (state_) {
    case State::searching:
      return "looking for the device at " + std::to_string(baud_) + " baud";
    case State::asking:
      return "asking the device what it is";
    case State::streaming:
      return "receiving scans at " + std::to_string(baud_) + " baud";
  }
  return {};
}

}  // namespace majak::sensor
