// SPDX-License-Identifier: Apache-2.0
#include "majak/io/number.hpp"

#include <charconv>
#include <cmath>
#include <limits>
#include <system_error>

namespace majak::io {

namespace detail {

const char* parse_decimal_slowly(const char* p, const char* end, double& value) {
  if (p != end && *p == '+') {
    ++p;
    if (p != end && *p == '-') return nullptr;
  }
  double parsed = 0;
  const auto [stop, error] = std::from_chars(p, end, parsed);
  if (error != std::errc{}) return nullptr;
  value = parsed;
  return stop;
}

}  // namespace detail

namespace {

// Half of what fits, so that the difference of any two times fits as well.
constexpr std::int64_t kMostSeconds = std::numeric_limits<Time>::max() / 2 / kSecond - 1;

/// For "1.07e9": no better than a double can hold.
const char* parse_time_roughly(const char* p, const char* end, Time& time) {
  double seconds = 0;
  const char* const stop = detail::parse_decimal_slowly(p, end, seconds);
  if (stop == nullptr || !(std::abs(seconds) < static_cast<double>(kMostSeconds))) return nullptr;
  time = from_seconds(seconds);
  return stop;
}

}  // namespace

const char* parse_time(const char* p, const char* end, Time& time) {
  const char* const begin = p;
  const bool negative = *p == '-';
  p += negative || *p == '+';
  std::int64_t seconds = 0;
  const char* const integer = p;
  for (; is_digit(*p) && seconds <= kMostSeconds; ++p) seconds = seconds * 10 + (*p - '0');
  if (seconds > kMostSeconds) return nullptr;
  bool any = p != integer;
  std::int64_t nanoseconds = 0;
  if (*p == '.') {
    ++p;
    std::int64_t unit = kSecond;
    for (; is_digit(*p); ++p) {
      any = true;
      if (unit > 1) {
        unit /= 10;
        nanoseconds += unit * (*p - '0');
      } else if (unit == 1) {
        nanoseconds += *p >= '5' ? 1 : 0;
        unit = 0;
      }
    }
  }
  if (!any || (*p | 0x20) == 'e') return parse_time_roughly(begin, end, time);
  const Time magnitude = seconds * kSecond + nanoseconds;
  time = negative ? -magnitude : magnitude;
  return p;
}

}  // namespace majak::io
