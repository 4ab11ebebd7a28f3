// SPDX-License-Identifier: Apache-2.0
#include "majak/sensor/lms_uart.hpp"

#include <algorithm>
#include <utility>

namespace majak::sensor {

Time LmsUart::next_start() const {
  const Time start = std::max(waiting_.front().ready, free_);
  if (in_turn_ < pace_.bytes_per_turn) return start;
  return std::max(start, turn_ + pace_.turn);
}

std::optional<Time> LmsUart::next() const {
  if (waiting_.empty()) return {};
  if (sent_ == waiting_.front().bytes.size()) return std::max(free_, waiting_.front().ready);
  return next_start() + byte_time_;
}

std::optional<LmsUart::Done> LmsUart::advance(Time until) {
  while (!waiting_.empty()) {
    Output& output = waiting_.front();
    if (sent_ == output.bytes.size()) {
      const Done done{std::max(free_, output.ready), output.after, output.baud};
      if (done.at > until) return {};
      waiting_.pop_front();
      sent_ = 0;
      if (done.after != After::nothing) return done;
      continue;
    }
    const Time start = next_start();
    if (start + byte_time_ > until) return {};
    if (start >= turn_ + pace_.turn || start < turn_) {
      const Duration since = start - pace_.begin;
      turn_ = start - (since % pace_.turn + pace_.turn) % pace_.turn;
      in_turn_ = 0;
    }
    ++in_turn_;
    free_ = start + byte_time_;
    leave(output.bytes[sent_++], start);
  }
  return {};
}

std::vector<LmsUart::Done> LmsUart::cut(Time now) {
  std::vector<Done> done;
  std::deque<Output> kept;
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    Output& output = waiting_[i];
    if (i == 0 && !output.handshake) {
      // The byte that is just leaving does.
      const bool leaving = sent_ < output.bytes.size() && next_start() < now;
      output.bytes.resize(std::min(output.bytes.size(), sent_ + (leaving ? 1 : 0)));
    } else if (!output.handshake) {
      output.bytes.clear();
    }
    if (output.after != After::nothing) done.push_back({now, output.after, output.baud});
    output.after = After::nothing;
    if (output.bytes.size() > (i == 0 ? sent_ : 0)) {
      kept.push_back(std::move(output));
    } else if (i == 0) {
      sent_ = 0;
    }
  }
  waiting_ = std::move(kept);
  return done;
}

std::vector<Chunk> LmsUart::take() { return std::exchange(out_, {}); }

void LmsUart::leave(std::uint8_t byte, Time start) {
  if (faults_.drop > 0 && random_.uniform() < faults_.drop) return;
  if (faults_.flip > 0 && random_.uniform() < faults_.flip) {
    byte ^= static_cast<std::uint8_t>(1u << random_.below(8));
  }
  put(byte, start);
  if (faults_.duplicate > 0 && random_.uniform() < faults_.duplicate) put(byte, start);
}

void LmsUart::put(std::uint8_t byte, Time start) {
  const bool goes_on =
      !out_.empty() && out_.back().end() == start && out_.back().byte_time == byte_time_;
  if (!goes_on) out_.push_back({start, byte_time_, {}});
  out_.back().bytes.push_back(byte);
}

}  // namespace majak::sensor
