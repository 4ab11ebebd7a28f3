// SPDX-License-Identifier: Apache-2.0
#include "majak/sensor/telegram_framer.hpp"

#include <algorithm>
#include <limits>

namespace majak::sensor {

namespace {

constexpr std::size_t kHeader = 5;                    // STX ... code
constexpr Duration kBetweenTelegrams = kSecond / 50;  // longer than any gap inside of one
constexpr Time kBeforeAll = std::numeric_limits<Time>::min();

}  // namespace

TelegramFramer::TelegramFramer(Direction direction, Duration timeout)
    : direction_(direction), timeout_(timeout), before_(kBeforeAll) {}

void TelegramFramer::push(std::span<const std::uint8_t> bytes, Time now) {
  if (bytes.empty()) return;
  if (head_ > size()) {  // each byte is moved less than once on average
    bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(head_));
    head_ = 0;
  }
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  ranges_.push_back({consumed_ + size(), now, byte_time_});
}

Time TelegramFramer::began(std::uint64_t index) const {
  Time before = before_;
  for (const Range& range : ranges_) {
    if (index < range.end) {
      const auto behind = static_cast<Duration>(range.end - index);
      return std::max(before, range.last - behind * range.byte_time);
    }
    before = range.last;
  }
  return before;
}

// As far as the header at i has arrived.
bool TelegramFramer::plausible_header(std::size_t i) const {
  const std::size_t n = size() - i;
  const bool to_host = direction_ == Direction::device_to_host;
  if (at(i) != kStx) return false;
  if (n > 1 && ((at(i + 1) & kDeviceBit) != 0) != to_host) return false;
  if (n > 3) {
    const std::size_t length = at(i + 2) | at(i + 3) << 8;
    if (length < (to_host ? 2 : 1) || length > kLongestTelegramLength) return false;
  }
  return n <= 4 || ((at(i + 4) & kDeviceBit) != 0) == to_host;
}

TelegramFramer::Verdict TelegramFramer::judge() const {
  if (!plausible_header(0)) return Verdict::nothing;
  if (size() < kHeader || size() < total()) return Verdict::wait;
  const std::span<const std::uint8_t> frame(&bytes_[head_], total());
  const unsigned crc = frame[frame.size() - 2] | frame[frame.size() - 1] << 8;
  if (telegram_crc(frame.first(frame.size() - 2)) != crc) return Verdict::crc_error;
  return judge_overlap();
}

// A telegram that lost bytes swallows the first ones of the next, and one in 65536 of such has a
// right CRC all the same. The swallowed header gives it away: it begins among the last bytes and
// goes on behind them, with the same address.
TelegramFramer::Verdict TelegramFramer::judge_overlap() const {
  const std::size_t end = total();
  for (std::size_t i = std::max<std::size_t>(1, end - (kHeader - 1)); i < end; ++i) {
    if (!plausible_header(i)) continue;
    if (i + 1 < size() && at(i + 1) != at(1)) continue;
    return size() < i + kHeader ? Verdict::look_behind : Verdict::overlap;
  }
  return Verdict::good;
}

std::optional<Frame> TelegramFramer::handshake() const {
  const std::uint8_t byte = at(0);
  if (direction_ != Direction::device_to_host || (byte != kAck && byte != kNak)) return {};
  const Time began_at = began(consumed_);
  // Behind damaged bytes it is only the value of something, unless the line was quiet before it.
  if (!in_step_ && began_at - before_ < kBetweenTelegrams) return {};
  Frame frame;
  frame.kind = byte == kAck ? Frame::Kind::ack : Frame::Kind::nak;
  frame.first_byte = began_at;
  return frame;
}

std::optional<Frame> TelegramFramer::next() {
  while (size() > 0) {
    if (auto frame = handshake()) {
      consume(1);
      return frame;
    }
    const bool silent = consumed_ < silent_from_;  // nothing more will come
    const Verdict verdict = judge();
    switch (verdict) {
      case Verdict::wait:
      case Verdict::look_behind:
        if (!silent) return {};
        break;
      case Verdict::crc_error:
        ++counts_.crc_errors;
        break;
      case Verdict::overlap:
        ++counts_.overlaps;
        break;
      case Verdict::nothing:
      case Verdict::good:
        break;
    }
    if (verdict == Verdict::good || verdict == Verdict::look_behind) return take();
    if (verdict == Verdict::wait) ++counts_.expired;
    skip();
  }
  return {};
}

Frame TelegramFramer::take() {
  Frame frame;
  frame.first_byte = began(consumed_);
  frame.telegram = *decode(std::span(&bytes_[head_], total()));
  ++counts_.telegrams;
  consume(total());
  return frame;
}

void TelegramFramer::consume(std::size_t n) {
  const std::uint64_t end = consumed_ + n;
  const Range* range = &ranges_.front();
  while (range->end < end) {
    before_ = range->last;
    ranges_.pop_front();
    range = &ranges_.front();
  }
  before_ =
      std::max(before_, range->last - static_cast<Duration>(range->end - end) * range->byte_time);
  if (range->end == end) ranges_.pop_front();
  consumed_ = end;
  head_ += n;
  in_step_ = true;
}

void TelegramFramer::skip() {
  consume(1);
  in_step_ = false;
  ++counts_.skipped_bytes;
}

void TelegramFramer::expire(Time now) {
  const auto due = expires_at();
  if (due && *due <= now) silent_from_ = consumed_ + size();
}

std::optional<Time> TelegramFramer::expires_at() const {
  if (size() == 0) return {};
  return ranges_.back().last + timeout_;
}

void TelegramFramer::clear() {
  if (size() > 0) consume(size());
  bytes_.clear();
  head_ = 0;
}

}  // namespace majak::sensor
