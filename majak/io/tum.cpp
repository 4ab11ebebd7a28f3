// SPDX-License-Identifier: Apache-2.0
#include "majak/io/tum.hpp"

#include <fmt/format.h>

#include <cmath>
#include <iterator>

namespace majak::io {

namespace {

constexpr std::uint64_t kMicrosecond = 1000;
constexpr std::uint64_t kMicrosecondsPerSecond = 1'000'000;

void append_stamp(std::string& text, Time time) {
  const auto bits = static_cast<std::uint64_t>(time);
  const std::uint64_t magnitude =
      time < 0 ? std::uint64_t{0} - bits : bits;  // also of the least int64
  const std::uint64_t us = (magnitude + kMicrosecond / 2) / kMicrosecond;
  const char* sign = time < 0 && us != 0 ? "-" : "";
  fmt::format_to(std::back_inserter(text), "{}{}.{:06}", sign, us / kMicrosecondsPerSecond,
                 us % kMicrosecondsPerSecond);
}

/// A value that would print as -0.000... is zero.
double without_negative_zero(double value, double half_of_last_digit) {
  return std::abs(value) <= half_of_last_digit ? 0.0 : value;
}

void append_line(std::string& text, Time time, const Pose2& pose) {
  const double theta = wrap_angle(pose.theta);
  append_stamp(text, time);
  fmt::format_to(std::back_inserter(text), " {:.6f} {:.6f} 0 0 0 {:.9f} {:.9f}\n",
                 without_negative_zero(pose.x, 0.5e-6), without_negative_zero(pose.y, 0.5e-6),
                 without_negative_zero(std::sin(theta / 2), 0.5e-9),
                 without_negative_zero(std::cos(theta / 2), 0.5e-9));
}

}  // namespace

std::string format_stamp(Time time) {
  std::string text;
  append_stamp(text, time);
  return text;
}

std::string tum_text(const Site& site) {
  std::string text;
  text.reserve(site.scans.size() * 80);
  for (const PosedScan& posed : site.scans)
    append_line(text, posed.scan.time, posed.estimate.T_map_robot);
  return text;
}

std::string estimates_tum(std::span<const Estimate> estimates) {
  std::string text;
  text.reserve(estimates.size() * 80);
  for (const Estimate& e : estimates) append_line(text, e.time, e.T_map_robot);
  return text;
}

std::string covariance_csv(std::span<const Estimate> estimates) {
  std::string text = "time,xx,xy,xt,yy,yt,tt,health\n";
  for (const Estimate& e : estimates) {
    const Mat3& P = e.covariance;
    append_stamp(text, e.time);
    fmt::format_to(std::back_inserter(text), ",{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{}\n",
                   P(0, 0), P(0, 1), P(0, 2), P(1, 1), P(1, 2), P(2, 2), name_of(e.health));
  }
  return text;
}

}  // namespace majak::io
