// SPDX-License-Identifier: Apache-2.0
// Numbers and words out of a line of text, without allocation and without the locale. A line that
// is handed in must be followed by one readable byte that belongs to no number (the readers of this
// folder keep the line end there; a std::string keeps its NUL), so no loop has to ask for the end.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "majak/core/time.hpp"

namespace majak::io {

inline bool is_digit(char c) { return static_cast<unsigned char>(c - '0') < 10; }
/// Blanks, control characters and the byte after the line: everything that ends a word.
inline bool is_blank(char c) { return static_cast<unsigned char>(c) <= ' '; }

namespace detail {

inline constexpr double kPowersOfTen[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                          1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                          1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

/// The general case: exponents, many digits, "nan", "inf".
const char* parse_decimal_slowly(const char* p, const char* end, double& value);

}  // namespace detail

/// The number at p; returns the first byte behind it, or nullptr when there is none (also when it
/// does not fit a double). Correctly rounded: at most 18 digits whose integer fits 53 bits, divided
/// once by an exact power of ten (Clinger 1990); everything else goes through std::from_chars.
inline const char* parse_decimal(const char* p, const char* end, double& value) {
  const char* const begin = p;
  const bool negative = *p == '-';
  p += negative || *p == '+';
  std::uint64_t mantissa = 0;
  const char* const integer = p;
  for (; is_digit(*p); ++p) mantissa = mantissa * 10 + static_cast<std::uint64_t>(*p - '0');
  std::ptrdiff_t digits = p - integer;
  std::ptrdiff_t decimals = 0;
  if (*p == '.') {
    const char* const fraction = ++p;
    for (; is_digit(*p); ++p) mantissa = mantissa * 10 + static_cast<std::uint64_t>(*p - '0');
    decimals = p - fraction;
    digits += decimals;
  }
  constexpr std::uint64_t kExact = std::uint64_t{1} << 53;
  if (digits == 0 || digits > 18 || mantissa > kExact || (*p | 0x20) == 'e') {
    return detail::parse_decimal_slowly(begin, end, value);
  }
  const double magnitude = static_cast<double>(mantissa) / detail::kPowersOfTen[decimals];
  value = negative ? -magnitude : magnitude;
  return p;
}

/// Seconds at p as exact nanoseconds, from the decimal digits themselves; a tenth decimal rounds.
/// Returns nullptr when there is no number or it is more than 146 years away from zero; the
/// difference of two times so read fits a Duration.
const char* parse_time(const char* p, const char* end, Time& time);

/// A line, word by word.
class Fields {
 public:
  explicit Fields(std::string_view line) : p_(line.data()), end_(line.data() + line.size()) {}

  /// True when nothing but blanks is left.
  bool at_end() {
    skip_blanks();
    return p_ == end_;
  }
  /// Upper bound for the number of words left.
  std::size_t words_at_most() const { return static_cast<std::size_t>(end_ - p_) / 2 + 1; }

  /// The next word, empty at the end.
  std::string_view word() {
    skip_blanks();
    const char* const begin = p_;
    while (p_ != end_ && !is_blank(*p_)) ++p_;
    return {begin, static_cast<std::size_t>(p_ - begin)};
  }

  /// The next word as a number; always moves on. False when it is none.
  bool number(double& value) {
    skip_blanks();
    if (p_ == end_) return false;
    const char* const stop = parse_decimal(p_, end_, value);
    return take(stop);
  }
  bool time(Time& value) {
    skip_blanks();
    if (p_ == end_) return false;
    return take(parse_time(p_, end_, value));
  }
  /// A count: a non-negative integer that can be true for the rest of the line.
  bool count(std::size_t& value) {
    double n = 0;
    if (!number(n) || !(n >= 0) || n > static_cast<double>(words_at_most())) return false;
    value = static_cast<std::size_t>(n);
    return static_cast<double>(value) == n;
  }

 private:
  void skip_blanks() {
    while (p_ != end_ && is_blank(*p_)) ++p_;
  }
  bool take(const char* stop) {
    if (stop != nullptr && (stop == end_ || is_blank(*stop))) {
      p_ = stop;
      return true;
    }
    while (p_ != end_ && !is_blank(*p_)) ++p_;
    return false;
  }

  const char* p_;
  const char* end_;
};

}  // namespace majak::io
