// SPDX-License-Identifier: Apache-2.0
#include "majak/sensor/cola.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <limits>

#include "majak/core/error.hpp"

namespace majak::sensor {
namespace {

constexpr std::uint8_t kStart = 0x02, kEnd = 0x03;
constexpr std::size_t kHeaderB = 8;  // 02 02 02 02 and the length
constexpr std::size_t kKindLength = 3;

// s, then Read Write Method Answer Event Scan Failure, then Name Answer Index.
bool may_be_kind(std::span<const std::uint8_t> bytes) {
  static constexpr std::string_view kLetters[] = {"s", "RWMAESF", "NAI"};
  for (std::size_t i = 0; i < std::min(bytes.size(), kKindLength); ++i) {
    if (kLetters[i].find(static_cast<char>(bytes[i])) == std::string_view::npos) return false;
  }
  return true;
}

std::uint8_t checksum(std::string_view payload) {
  std::uint8_t sum = 0;
  for (const char c : payload) sum ^= static_cast<std::uint8_t>(c);
  return sum;
}

std::string_view without_blanks(std::string_view text) {
  const std::size_t first = text.find_first_not_of(' ');
  return first == std::string_view::npos ? std::string_view{} : text.substr(first);
}

std::uint32_t big_endian(std::string_view bytes) {
  std::uint32_t value = 0;
  for (const char c : bytes) value = value << 8 | static_cast<std::uint8_t>(c);
  return value;
}

// As far as the bytes go: 02 02 02 02, a possible length, a kind.
bool may_begin_b(std::span<const std::uint8_t> bytes) {
  const auto stated = bytes.first(std::min<std::size_t>(bytes.size(), 4));
  if (std::any_of(stated.begin(), stated.end(), [](auto byte) { return byte != kStart; }))
    return false;
  if (bytes.size() < kHeaderB) return true;
  const std::size_t size = big_endian({reinterpret_cast<const char*>(bytes.data()) + 4, 4});
  return size >= kKindLength && size <= ColaFramer::kLongestPayload &&
         may_be_kind(bytes.subspan(kHeaderB));
}

// The whole word as a number; nothing if it is none.
std::optional<std::int64_t> parse(std::string_view word, int base) {
  std::int64_t value = 0;
  const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value, base);
  if (error != std::errc{} || stop != word.data() + word.size()) return {};
  return value;
}

}  // namespace

const char* words(ColaDialect dialect) { return dialect == ColaDialect::a ? "CoLa A" : "CoLa B"; }

std::string_view ColaTelegram::kind() const {
  return std::string_view(payload).substr(0, kKindLength);
}

std::string_view ColaTelegram::name() const {
  if (kind() == "sFA" || payload.size() <= kKindLength || payload[kKindLength] != ' ') return {};
  const std::string_view rest = std::string_view(payload).substr(kKindLength + 1);
  return rest.substr(0, rest.find(' '));
}

bool ColaTelegram::is(std::string_view kind_and_name) const {
  return kind_and_name.substr(0, kKindLength) == kind() &&
         kind_and_name.substr(std::min(kind_and_name.size(), kKindLength + 1)) == name();
}

std::optional<unsigned> cola_refusal(const ColaTelegram& telegram) {
  if (telegram.kind() != "sFA") return {};
  std::string_view rest = std::string_view(telegram.payload).substr(kKindLength);
  if (telegram.dialect == ColaDialect::a) {
    const auto code = parse(without_blanks(rest), 16);
    return code && *code >= 0 && *code <= 0xffff ? static_cast<unsigned>(*code) : 0U;
  }
  if (rest.size() > 2 && rest[0] == ' ') rest.remove_prefix(1);
  return big_endian(rest.substr(0, 2));
}

const char* cola_refusal_words(unsigned code) {
  static constexpr std::array kWords = {"no reason given",
                                        "access denied",
                                        "unknown method",
                                        "unknown variable",
                                        "not in this condition",
                                        "invalid data",
                                        "unknown error",
                                        "more data than it takes",
                                        "less data than it needs",
                                        "unknown type",
                                        "not to be written",
                                        "unknown command",
                                        "unknown CoLa command",
                                        "busy with another command",
                                        "index out of bounds",
                                        "unknown event",
                                        "value too large",
                                        "invalid character",
                                        "no message in the device",
                                        "no answer in the device",
                                        "internal error"};
  return code < kWords.size() ? kWords[code] : "a reason that has no name";
}

std::vector<std::uint8_t> cola_frame(ColaDialect dialect, std::string_view payload) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(payload.size() + kHeaderB + 1);
  if (dialect == ColaDialect::a) {
    bytes.push_back(kStart);
  } else {
    bytes.assign(4, kStart);
    for (int shift = 24; shift >= 0; shift -= 8)
      bytes.push_back(static_cast<std::uint8_t>(payload.size() >> shift));
  }
  bytes.insert(bytes.end(), payload.begin(), payload.end());
  bytes.push_back(dialect == ColaDialect::a ? kEnd : checksum(payload));
  return bytes;
}

// ---- writing --------------------------------------------------------------------------------

ColaWriter::ColaWriter(ColaDialect dialect, std::string_view head)
    : dialect_(dialect), payload_(head) {}

ColaWriter& ColaWriter::u8(std::uint8_t value, int digits) { return number(value, 1, digits); }
ColaWriter& ColaWriter::u16(std::uint16_t value) { return number(value, 2, 1); }
ColaWriter& ColaWriter::u32(std::uint32_t value) { return number(value, 4, 1); }
ColaWriter& ColaWriter::i32(std::int32_t value) {
  return number(static_cast<std::uint32_t>(value), 4, 1);
}
ColaWriter& ColaWriter::f32(float value) {
  return number(std::bit_cast<std::uint32_t>(value), 4, 8);
}

ColaWriter& ColaWriter::text(std::string_view value, int length_bytes) {
  value = value.substr(0, std::numeric_limits<std::uint8_t>::max());
  number(static_cast<std::uint32_t>(value.size()), length_bytes, 1);
  if (dialect_ == ColaDialect::a) payload_ += ' ';
  payload_ += value;
  return *this;
}

ColaWriter& ColaWriter::label(std::string_view value) {
  if (first_ || dialect_ == ColaDialect::a) payload_ += ' ';
  first_ = false;
  payload_ += value;
  return *this;
}

ColaWriter& ColaWriter::number(std::uint32_t value, int bytes, int digits) {
  if (first_ || dialect_ == ColaDialect::a) payload_ += ' ';
  first_ = false;
  if (dialect_ == ColaDialect::b) {
    for (int i = bytes - 1; i >= 0; --i) payload_ += static_cast<char>(value >> (8 * i));
    return *this;
  }
  int used = 8;
  while (used > digits && (value >> (4 * (used - 1))) == 0) --used;
  for (int i = used - 1; i >= 0; --i) payload_ += "0123456789ABCDEF"[(value >> (4 * i)) & 15];
  return *this;
}

// ---- reading --------------------------------------------------------------------------------

ColaCursor::ColaCursor(const ColaTelegram& telegram) : telegram_(&telegram) {
  const std::string_view name = telegram.name();
  at_ = name.empty()
            ? std::min(kKindLength, telegram.payload.size())
            : static_cast<std::size_t>(name.data() - telegram.payload.data()) + name.size();
  // In B one blank ends the name; what follows is numbers, and a number may look like a blank.
  if (telegram.dialect == ColaDialect::b && at_ < telegram.payload.size()) ++at_;
}

std::uint8_t ColaCursor::u8(const char* what) {
  return static_cast<std::uint8_t>(number(1, false, what));
}
std::uint16_t ColaCursor::u16(const char* what) {
  return static_cast<std::uint16_t>(number(2, false, what));
}
std::uint32_t ColaCursor::u32(const char* what) {
  return static_cast<std::uint32_t>(number(4, false, what));
}
std::int32_t ColaCursor::i32(const char* what) {
  return static_cast<std::int32_t>(number(4, true, what));
}
float ColaCursor::f32(const char* what) { return std::bit_cast<float>(u32(what)); }

std::string ColaCursor::text(const char* what, int length_bytes) {
  const auto length = static_cast<std::size_t>(number(length_bytes, false, what));
  if (telegram_->dialect == ColaDialect::a) take(1, what);
  return std::string(take(length, what));
}

std::string ColaCursor::label(std::size_t width, const char* what) {
  const std::string_view value =
      telegram_->dialect == ColaDialect::a ? word(what) : take(width, what);
  const auto is_letter = [](char c) { return c > ' ' && c < 0x7f; };
  if (value.size() != width || !std::all_of(value.begin(), value.end(), is_letter))
    fail(std::string("where ") + what + " should be there is something else");
  return std::string(value);
}

bool ColaCursor::at_end() const {
  const std::string_view rest = std::string_view(telegram_->payload).substr(at_);
  return telegram_->dialect == ColaDialect::a ? without_blanks(rest).empty() : rest.empty();
}

std::size_t ColaCursor::fields_at_most(std::size_t bytes) const {
  const std::size_t least = telegram_->dialect == ColaDialect::a ? 2 : bytes;  // " 0"
  return (telegram_->payload.size() - at_) / least;
}

void ColaCursor::fail(const std::string& why) const {
  throw Error(std::string(telegram_->name()) + " in " + words(telegram_->dialect) + ", byte " +
              std::to_string(at_) + ": " + why);
}

std::int64_t ColaCursor::number(int bytes, bool is_signed, const char* what) {
  const std::int64_t limit = std::int64_t{1} << (8 * bytes);
  if (telegram_->dialect == ColaDialect::b) {
    const std::int64_t value = big_endian(take(static_cast<std::size_t>(bytes), what));
    return is_signed && value >= limit / 2 ? value - limit : value;
  }
  std::string_view digits = word(what);
  const bool decimal = digits[0] == '+' || digits[0] == '-';
  if (digits[0] == '+') digits.remove_prefix(1);
  const auto value = parse(digits, decimal ? 10 : 16);
  const bool fits = value && *value < limit &&
                    *value >= (is_signed && decimal ? -limit / 2 : std::int64_t{0}) &&
                    !(is_signed && decimal && *value >= limit / 2);
  if (!fits)
    fail("'" + std::string(digits.substr(0, 20)) + "' is no number of " +
         std::to_string(8 * bytes) + " bits, as " + what + " is");
  return is_signed && *value >= limit / 2 ? *value - limit : *value;
}

std::string_view ColaCursor::word(const char* what) {
  const std::string_view payload = telegram_->payload;
  const std::size_t begin = payload.find_first_not_of(' ', at_);
  if (begin == std::string_view::npos) {
    at_ = payload.size();
    take(1, what);
  }
  const std::size_t end = std::min(payload.find(' ', begin), payload.size());
  at_ = end;
  return payload.substr(begin, end - begin);
}

std::string_view ColaCursor::take(std::size_t bytes, const char* what) {
  const std::string_view rest = std::string_view(telegram_->payload).substr(at_);
  if (rest.size() < bytes)
    fail(std::string("ends before ") + what + "; the telegram was cut short");
  at_ += bytes;
  return rest.substr(0, bytes);
}

// ---- framing --------------------------------------------------------------------------------

void ColaFramer::push(std::span<const std::uint8_t> bytes, Time now) {
  if (bytes.empty()) return;
  if (begin_ > buffer_.size() / 2) {
    buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(begin_));
    begin_ = 0;
  }
  if (arrivals_.empty() || arrivals_.back().time != now)
    arrivals_.push_back({consumed_ + (buffer_.size() - begin_), now});
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

std::optional<ColaTelegram> ColaFramer::next() {
  while (begin_ < buffer_.size()) {
    while (arrivals_.size() > 1 && arrivals_[1].at <= consumed_) arrivals_.pop_front();
    const auto rest = buffer_.begin() + static_cast<std::ptrdiff_t>(begin_);
    const auto garbage = std::find(rest, buffer_.end(), kStart) - rest;
    if (garbage > 0) {
      report_.add("CoLa: bytes that belong to no telegram", {garbage, 0});
      consume(static_cast<std::size_t>(garbage));
      continue;
    }
    ColaTelegram found;
    found.time = arrivals_.front().time;
    std::size_t length = 0;
    const Look seen = look(found, length);
    if (seen == Look::wait) return {};
    if (seen == Look::none) {
      report_.count("CoLa: bytes that belong to no telegram");
      length = 1;
    }
    consume(length);
    if (seen == Look::whole) return found;
  }
  return {};
}

void ColaFramer::clear() {
  consume(buffer_.size() - begin_);
  arrivals_.clear();
}

ColaFramer::Look ColaFramer::look(ColaTelegram& found, std::size_t& length) {
  const std::span bytes = std::span(buffer_).subspan(begin_);
  if (bytes.size() < 2) return Look::wait;
  return bytes[1] == kStart ? look_b(found, length) : look_a(found, length);
}

// Text without control characters up to its end.
ColaFramer::Look ColaFramer::look_a(ColaTelegram& found, std::size_t& length) {
  const std::span bytes = std::span(buffer_).subspan(begin_);
  if (!may_be_kind(bytes.subspan(1))) return Look::none;
  const std::size_t limit = std::min(bytes.size(), 1 + kLongestPayload + 1);
  std::size_t i = std::max<std::size_t>(scanned_, 1);
  while (i < limit && bytes[i] >= ' ') ++i;
  scanned_ = i;
  if (i == limit) return limit == bytes.size() ? Look::wait : Look::none;
  if (bytes[i] != kEnd) {
    report_.count("CoLa: telegram cut short by the next one or by garbage");
    return Look::none;
  }
  found.dialect = ColaDialect::a;
  found.payload.assign(bytes.begin() + 1, bytes.begin() + static_cast<std::ptrdiff_t>(i));
  length = i + 1;
  return Look::whole;
}

ColaFramer::Look ColaFramer::look_b(ColaTelegram& found, std::size_t& length) {
  const std::span bytes = std::span(buffer_).subspan(begin_);
  if (!may_begin_b(bytes)) return Look::none;
  if (bytes.size() < kHeaderB) return Look::wait;
  const auto* text = reinterpret_cast<const char*>(bytes.data());
  const std::size_t size = big_endian({text + 4, 4});
  // The sum is weak, and a wrong length would have us wait: another beginning inside tells more.
  const std::size_t end = std::min(bytes.size(), kHeaderB + size);
  for (std::size_t& i = scanned_; i + kHeaderB + kKindLength <= end; ++i) {
    if (i < kHeaderB || bytes[i] != kStart || !may_begin_b(bytes.subspan(i))) continue;
    report_.count("CoLa: telegram cut short by the next one or by garbage");
    return Look::none;
  }
  if (bytes.size() < kHeaderB + size + 1) return Look::wait;
  const std::string_view payload(text + kHeaderB, size);
  if (checksum(payload) != bytes[kHeaderB + size]) {
    report_.count("CoLa: telegram whose checksum is wrong");
    return Look::none;
  }
  found.dialect = ColaDialect::b;
  found.payload = payload;
  length = kHeaderB + size + 1;
  return Look::whole;
}

void ColaFramer::consume(std::size_t bytes) {
  begin_ += bytes;
  consumed_ += bytes;
  scanned_ = 0;
}

}  // namespace majak::sensor
