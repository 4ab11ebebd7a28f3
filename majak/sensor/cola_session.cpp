// SPDX-License-Identifier: Apache-2.0
#include "majak/sensor/cola_session.hpp"

#include <algorithm>
#include <utility>

#include "majak/core/error.hpp"

namespace majak::sensor {
namespace {

constexpr int kCommandTries = 3;               // of a command, before everything is asked anew
constexpr Duration kPollPause = kSecond / 2;   // between two questions for the state
constexpr Duration kBusyPause = kSecond;       // after a refusal that may pass
constexpr std::size_t kMostDeliveries = 1000;  // 20 s at 50 Hz

constexpr unsigned kLmsMeasures = 7, kDeviceReady = 1;

}  // namespace

ColaSession::ColaSession(const ColaSessionOptions& options)
    : options_(options), candidate_(options.dialect.value_or(ColaDialect::b)) {}

void ColaSession::start(Time now) {
  if (state_ == State::off || state_ == State::failed) alive_ = now;
  problem_.clear();
  output_.clear();
  wants_connection_ = false;
  heard_ = now;
  search(now);
}

void ColaSession::stop() {
  if (known_.dialect && state_ != State::off)
    output_ = ColaWriter(*known_.dialect, "sEN LMDscandata").u8(0).frame();
  state_ = State::off;
  step_ = Step::none;
  framer_.clear();
}

std::vector<std::uint8_t> ColaSession::take_output() { return std::exchange(output_, {}); }

std::optional<ColaDelivery> ColaSession::next() {
  if (deliveries_.empty()) return {};
  ColaDelivery first = std::move(deliveries_.front());
  deliveries_.pop_front();
  return first;
}

Report ColaSession::report() const {
  Report all = report_;
  for (const auto& [what, entry] : framer_.report().entries()) all.add(what, entry);
  return all;
}

// ---- what to ask ----------------------------------------------------------------------------

void ColaSession::ask_next(Time now, Duration pause) {
  const Step step = what_next();
  if (step != step_) tries_ = 0;
  step_ = step;
  sent_ = false;
  name_state();
  if (step == Step::none) return;
  send_at_ = now + pause;
  if (pause == 0) send(now);
}

void ColaSession::send(Time now) {
  const auto bytes = command(step_).frame();
  output_.insert(output_.end(), bytes.begin(), bytes.end());
  sent_ = true;
  ++tries_;
  deadline_ = now + reply_time(step_);
  if (step_ == Step::log_in) ++counts_.logins;
  if (step_ == Step::start) started_at_ = now;
}

// ---- time -----------------------------------------------------------------------------------

void ColaSession::advance(Time now) {
  if (state_ == State::off || state_ == State::failed) return;
  if (options_.patience > 0 && now >= alive_ + from_seconds(options_.patience)) {
    give_up();
  } else if (step_ == Step::none) {
    if (now < scan_at_ + from_seconds(options_.silence)) return;
    ++counts_.pauses;
    search(now);
  } else if (sent_ && now >= deadline_) {
    no_answer(now);
  } else if (!sent_ && now >= send_at_) {
    send(now);
  }
}

Time ColaSession::wake_at() const {
  if (state_ == State::off || state_ == State::failed) return kNever;
  Time time = sent_ ? deadline_ : send_at_;
  if (step_ == Step::none) time = scan_at_ + from_seconds(options_.silence);
  if (options_.patience > 0) time = std::min(time, alive_ + from_seconds(options_.patience));
  return time;
}

void ColaSession::no_answer(Time now) {
  if (step_ == Step::probe) {
    if (now >= heard_ + from_seconds(options_.reconnect_time)) wants_connection_ = true;
    if (!options_.dialect)
      candidate_ = candidate_ == ColaDialect::a ? ColaDialect::b : ColaDialect::a;
    ask_next(now);
  } else if (step_ == Step::identify) {
    done(step_);
    ask_next(now);
  } else if (tries_ < kCommandTries) {
    send(now);
  } else {
    report_.count("CoLa: commands without an answer");
    search(now);
  }
}

// Everything is asked anew; the dialect that was spoken last is tried first.
void ColaSession::search(Time now) {
  candidate_ = options_.dialect.value_or(known_.dialect.value_or(candidate_));
  known_ = {};
  framer_.clear();
  last_.reset();
  step_ = Step::none;
  ask_next(now);
}

void ColaSession::name_state() {
  switch (step_) {
    case Step::probe:
      state_ = State::searching;
      break;
    case Step::ask_state:
      state_ = State::waiting;
      break;
    case Step::subscribe:
      state_ = State::subscribing;
      break;
    case Step::none:
      state_ = State::streaming;
      break;
    default:
      state_ = State::preparing;
  }
}

// ---- what comes in --------------------------------------------------------------------------

void ColaSession::receive(std::span<const std::uint8_t> bytes, Time now) {
  if (state_ == State::off || state_ == State::failed) return;
  framer_.push(bytes, now);
  while (auto telegram = framer_.next()) take(std::move(*telegram), now);
}

void ColaSession::take(ColaTelegram telegram, Time now) {
  heard_ = now;
  wants_connection_ = false;
  const bool is_news = !known_.dialect;
  if (is_news) known_.dialect = telegram.dialect;
  if (telegram.is("sSN LMDscandata")) {
    deliver(std::move(telegram), now);
    if (is_news && step_ == Step::probe) ask_next(now);
  } else if (is_news) {
    ask_next(now);
  } else {
    answered(telegram, now);
  }
}

void ColaSession::answered(const ColaTelegram& telegram, Time now) {
  if (known_.subscribed && telegram.is(answer(Step::subscribe))) return;  // after the first scan
  if (step_ == Step::none || !sent_) {
    report_.count("CoLa: telegrams that were not asked for");
    return;
  }
  try {
    if (const auto code = cola_refusal(telegram)) {
      refused(*code, now);
    } else if (telegram.is(answer(step_))) {
      understand(telegram, now);
    } else {
      report_.count("CoLa: telegrams that were not asked for");
    }
  } catch (const Error&) {
    report_.count("CoLa: answers that cannot be read");
    if (step_ == Step::identify) done(step_);  // nothing hangs on it
    ask_next(now, kBusyPause);
  }
}

void ColaSession::understand(const ColaTelegram& telegram, Time now) {
  ColaCursor in(telegram);
  if (step_ == Step::ask_state) return state_told(telegram, now);
  if (step_ == Step::identify) known_.identity = decode_identity(telegram);
  if (step_ == Step::log_in && in.u8("whether it lets us in") == 0)
    report_.count("CoLa: the device refused the login");
  if (step_ == Step::start && in.u8("whether it starts") != 0)
    report_.count("CoLa: the device refused to start measuring");
  if (step_ == Step::subscribe) scan_at_ = now;
  done(step_);
  ask_next(now);
}

void ColaSession::state_told(const ColaTelegram& telegram, Time now) {
  ColaCursor in(telegram);
  const unsigned state = known_.no_stlms ? in.u8("the device's state") : in.u16("the state");
  known_.device_state = cola_state_words(known_.no_stlms, state);
  tries_ = 0;
  if (state == (known_.no_stlms ? kDeviceReady : kLmsMeasures)) {
    done(Step::ask_state);
    return ask_next(now);
  }
  if (now < started_at_ + from_seconds(options_.start_time)) return ask_next(now, kPollPause);
  // It was asked to measure long ago: ask once more, then see whether scans come all the same.
  if (known_.asked_again) {
    done(Step::ask_state);
  } else {
    known_.asked_again = true;
    known_.logged_in = known_.started = known_.logged_out = false;
  }
  ask_next(now);
}

void ColaSession::refused(unsigned code, Time now) {
  const std::string what(ColaTelegram{.payload = command(step_).payload()}.name());
  const std::string refusal = "the device refused " + what + ": " + cola_refusal_words(code);
  trouble_ = refusal;
  report_.count("CoLa: " + refusal);
  if (step_ == Step::ask_state && !known_.no_stlms) {
    known_.no_stlms = true;
    tries_ = 0;
  } else if (step_ != Step::subscribe) {
    done(step_);
  } else if (tries_ >= kCommandTries) {
    return search(now);
  } else {
    return ask_next(now, kBusyPause);
  }
  ask_next(now);
}

void ColaSession::done(Step step) {
  switch (step) {
    case Step::identify:
      known_.identified = true;
      break;
    case Step::log_in:
      known_.logged_in = true;
      break;
    case Step::configure:
      known_.configured = true;
      break;
    case Step::start:
      known_.started = true;
      break;
    case Step::log_out:
      known_.logged_out = true;
      break;
    case Step::ask_state:
      known_.measures = true;
      break;
    case Step::subscribe:
      known_.subscribed = true;
      break;
    case Step::probe:
    case Step::none:
      break;
  }
}

void ColaSession::deliver(ColaTelegram telegram, Time now) {
  ColaDelivery delivery;
  try {
    delivery.scan = decode_scan(telegram);
  } catch (const Error& error) {
    ++counts_.unreadable;
    trouble_ = std::string("its scans cannot be read: ") + error.what();
    report_.count("CoLa: scans that cannot be read");
    return;
  }
  alive_ = scan_at_ = now;
  // Scans come to those who asked: before the confirmation, without one that was lost, or again
  // after a pause that only the network made.
  if (!known_.subscribed && (known_.configured || !options_.ask_intensities)) {
    done(Step::subscribe);
    ask_next(now);
  }
  const std::int64_t missed = count_missed(delivery.scan);
  if (missed < 0) return;
  delivery.scans_missed = missed;
  delivery.telegram = std::move(telegram);
  if (deliveries_.size() >= kMostDeliveries) {
    deliveries_.pop_front();
    ++counts_.unfetched;
  }
  deliveries_.push_back(std::move(delivery));
}

// Scans between the last one and this one; -1 if it is the last one again.
std::int64_t ColaSession::count_missed(const ColaScan& scan) {
  ColaScan head;
  head.telegram_counter = scan.telegram_counter;
  head.scan_counter = scan.scan_counter;
  head.first_shot = scan.first_shot;
  const std::optional<ColaScan> before = std::exchange(last_, head);
  if (before == head) {
    ++counts_.doubled;
    return -1;
  }
  ++counts_.scans;
  if (!before) return 0;
  const auto gap = static_cast<std::uint16_t>(scan.telegram_counter - before->telegram_counter - 1);
  if (gap >= 0x8000) {
    report_.count("CoLa: the telegram counter began anew");
    return 0;
  }
  counts_.missed += gap;
  return gap;
}

}  // namespace majak::sensor
