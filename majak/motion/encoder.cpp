// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/encoder.hpp"

#include <cmath>

#include "majak/core/angle.hpp"
#include "majak/core/error.hpp"

namespace majak::motion {

Encoder::Encoder(const EncoderOptions& options) : options_(options) {
  if (!(options.ticks_per_turn > 0) || !(options.radius > 0) || !(options.max_speed > 0))
    throw Error("encoder: ticks a turn, radius and greatest speed must be above 0");
  if (options.bits < 8 || options.bits > 32) throw Error("encoder: a counter has 8 to 32 bits");
  tick_ = 2 * kPi * options.radius / options.ticks_per_turn;  // (MATH 6.8)
  const std::int64_t size = std::int64_t{1} << options.bits;
  low_ = options.is_signed ? -size / 2 : 0;
  high_ = low_ + size - 1;
}

/// Modulo 2^bits, in [-2^(bits-1), 2^(bits-1)).
std::int64_t Encoder::difference(std::int64_t from, std::int64_t to) const {
  const std::int64_t size = high_ - low_ + 1;
  const std::int64_t ahead = (to - from + size) % size;  // both are in range
  return ahead < size / 2 ? ahead : ahead - size;
}

std::optional<double> Encoder::add(Time time, std::int64_t counter, Report& report) {
  const auto skip = [&](const char* why) {
    report.count(why);
    return std::nullopt;
  };
  if (counter < low_ || counter > high_) return skip("encoder: a count beyond the counter's width");
  if (started_ && time == time_) return skip("encoder: a record that came twice");
  if (started_ && time < time_) return skip("encoder: a record older than the one before");
  if (!started_) {
    started_ = true, time_ = time, counter_ = counter;
    return std::nullopt;
  }
  std::int64_t ticks = difference(counter_, counter);
  if (options_.reversed) ticks = -ticks;
  const double way = tick_ * static_cast<double>(ticks);
  const double most = options_.max_speed * to_seconds(time - time_) + tick_;
  time_ = time, counter_ = counter;
  if (most >= 0.5 * tick_ * static_cast<double>(high_ - low_ + 1))
    return skip("encoder: a pause in which the counter may have run over unseen");
  if (std::abs(way) > most) return skip("encoder: a jump beyond the greatest speed");
  total_ += ticks;
  return way;
}

}  // namespace majak::motion
