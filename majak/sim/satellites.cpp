// SPDX-License-Identifier: Apache-2.0
#include "majak/sim/satellites.hpp"

#include <algorithm>
#include <cmath>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/sim/streams.hpp"

namespace majak::sim {

namespace {

double exponential(double mean, RandomStream& random) {
  return -mean * std::log(1 - random.uniform());
}

}  // namespace

void describe(OptionFields& fields, SatelliteOptions& o) {
  fields.add("satellites.on", o.on, {"", "a receiver on the robot"});
  fields.add("satellites.rate", o.rate, {"Hz", "fixes within a burst", 0.1, 50});
  fields.add("satellites.antenna_x", o.antenna_x, {"m", "ahead of the robot's point", -10, 10});
  fields.add("satellites.antenna_y", o.antenna_y, {"m", "to the left of it", -10, 10});
  fields.add("satellites.sigma", o.sigma, {"m", "each axis, from fix to fix", 0, 100});
  fields.add("satellites.bias_sigma", o.bias_sigma, {"m", "each axis, anew each burst", 0, 100});
  fields.add("satellites.burst", o.burst, {"s", "mean length of a burst", 0.1, 1e6});
  fields.add("satellites.outage", o.outage, {"s", "mean length of an outage", 0, 1e6});
  fields.add("satellites.jump", o.jump, {"m", "fault: fixes that far off", 0, 1e4});
  fields.add("satellites.jump_begin", o.jump_begin, {"s", "or with the next burst", 0, 1e6});
  fields.add("satellites.jump_duration", o.jump_duration, {"s", "how long", 0, 1e6});
  fields.add("satellites.missing_until", o.missing_until, {"s", "fault: no fix before", 0, 1e6});
}

Satellites::Satellites(const SatelliteOptions& options, Duration run, std::uint64_t seed)
    : options_(options), seed_(seed) {
  if (!options.on) return;
  const auto& o = options_;
  if (!(o.rate >= 0.1 && o.rate <= 50)) throw Error("satellites: rate must be 0.1 ... 50 Hz");
  if (!(o.burst >= 0.1 && o.outage >= 0))
    throw Error("satellites: burst must be 0.1 s or more, outage 0 or more");
  if (!(o.sigma >= 0 && o.bias_sigma >= 0)) throw Error("satellites: sigmas must not be negative");
  RandomStream lengths(seed, kBurst), direction(seed, kFixJump);
  const auto draw = [&](double mean) { return from_seconds(exponential(mean, lengths)); };
  // The last burst ends with the run, however long it is.
  const Duration last = std::max<Duration>(0, run - draw(o.burst));
  for (Duration at = 0; at < last;) {
    const Duration end = at + draw(o.burst);
    bursts_.push_back({at, end});
    at = end + draw(o.outage);
  }
  if (bursts_.empty() || bursts_.back().end < last) bursts_.push_back({last, run});
  bursts_.back().end = run;
  for (std::size_t i = 0; i < bursts_.size(); ++i) {
    RandomStream r(seed, kBurst, i + 1);
    bursts_[i].bias.x() = o.bias_sigma * r.normal();
    bursts_[i].bias.y() = o.bias_sigma * r.normal();
  }
  const double angle = direction.uniform(-kPi, kPi);
  jump_ = o.jump * Vec2(std::cos(angle), std::sin(angle));
  jump_at_ = from_seconds(std::max(o.jump_begin, o.missing_until));
  const auto next = std::find_if(bursts_.begin(), bursts_.end(),
                                 [&](const Burst& b) { return b.end >= jump_at_; });
  if (next != bursts_.end()) jump_at_ = std::max(jump_at_, next->begin);
}

Duration Satellites::time(std::int64_t number) const {
  return from_seconds(static_cast<double>(number) / options_.rate);
}

std::optional<GpsFix> Satellites::fix(std::int64_t number, const Pose2& T_world_robot) const {
  const Duration now = time(number);
  if (now < from_seconds(options_.missing_until)) return std::nullopt;
  const auto burst = std::find_if(bursts_.begin(), bursts_.end(),
                                  [&](const Burst& b) { return b.begin <= now && now <= b.end; });
  if (burst == bursts_.end()) return std::nullopt;
  RandomStream r(seed_, kFix, static_cast<std::uint64_t>(number));
  const double east = r.normal();
  // (MATH 13.1)
  Vec2 p = T_world_robot * Vec2(options_.antenna_x, options_.antenna_y) + burst->bias +
           options_.sigma * Vec2(east, r.normal());
  if (now >= jump_at_ && now < jump_at_ + from_seconds(options_.jump_duration)) p += jump_;
  return GpsFix{.time = now, .east = p.x(), .north = p.y()};
}

}  // namespace majak::sim
