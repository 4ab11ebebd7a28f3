// SPDX-License-Identifier: Apache-2.0
#include "majak/sensor/lms291.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "majak/core/error.hpp"
#include "majak/core/event.hpp"

namespace majak::sensor {

namespace {

constexpr double kPulseLength = 1.0;        // m; closer echoes run together
constexpr double kSwingWavelength = 16.0;   // m; the systematic error changes over metres
constexpr double kEnoughForeground = 0.25;  // share of the spot that a near target needs

}  // namespace

Variant variant_of_beams(int beams) {
  for (const Variant& v : kVariants) {
    if (v.beams() == beams) return v;
  }
  throw Error("an LMS-291 has no scan of " + std::to_string(beams) +
              " beams: choose 181, 361, 101, 201 or 401");
}

double delivered_rate(const Variant& variant, int baud) {
  constexpr int kEnvelope = 10;  // bytes of a telegram beside its values
  const double bytes = 2.0 * variant.beams() + kEnvelope;
  const double period = variant.turns() / kLms291.mirror_rate;
  return 1.0 / (std::ceil(10.0 * bytes / baud / period) * period);
}

Duration beam_time(const Variant& variant, int beam) {
  const Duration turn = beam % variant.turns();
  // Hundredths of a degree from beam 0, exact in integers.
  const Duration hundredths = static_cast<Duration>(beam) * variant.resolution;
  return turn * kMirrorTurn + hundredths * kMirrorTurn / 36000;
}

Duration scan_duration(const Variant& variant) {
  Duration last = 0;
  for (int i = std::max(0, variant.beams() - variant.turns()); i < variant.beams(); ++i) {
    last = std::max(last, beam_time(variant, i));
  }
  return last;
}

void describe(OptionFields& fields, RangeNoiseOptions& o) {
  fields.add("laser.max_range", o.max_range, {"m", "farther targets give no return", 1, 80});
  fields.add("laser.systematic_error", o.systematic_error,
             {"m", "the error of a run is drawn within +- this", 0, 1});
  fields.add("laser.statistical_error", o.statistical_error, {"m", "sigma of each beam", 0, 1});
  fields.add("laser.quantum", o.quantum, {"m", "step of the ranges, 0 for none", 0, 1});
  fields.add("laser.no_return", o.no_return, {"1", "share of beams lost without a reason", 0, 1});
  fields.add("laser.range_at_10_percent", o.range_at_10_percent,
             {"m", "reach on a target that reflects 10 % of the light", 1, 1000});
  fields.add("laser.beam_width", o.beam_width, {"1", "1 the real beam, 0 a line", 0, 4});
}

RangeNoiseOptions perfect_range() {
  RangeNoiseOptions o;
  o.systematic_error = o.statistical_error = o.quantum = o.no_return = o.beam_width = 0;
  o.range_at_10_percent = 1e9;
  return o;
}

double reach(const RangeNoiseOptions& options, double reflectivity, double incidence) {
  const double sent_back = std::max(0.0, reflectivity * std::cos(incidence));
  return std::min(options.max_range, options.range_at_10_percent * std::sqrt(sent_back / 0.10));
}

double echo_strength(const RangeNoiseOptions& options, const Echo& echo) {
  const double sent_back = std::max(0.0, echo.reflectivity * std::cos(echo.incidence)) / 0.10;
  const double near = options.range_at_10_percent / echo.range;
  return sent_back * near * near;
}

double half_beam_angle(double range) {
  const double diameter = kLms291.spot_at_window + kLms291.divergence * range;
  return std::atan2(diameter / 2, range);
}

RangeNoise::RangeNoise(const RangeNoiseOptions& options, RandomStream run) : options_(options) {
  // Constant part and swing share the bound between them, so that it holds at every range.
  constant_ = 0.6 * options.systematic_error * run.uniform(-1, 1);
  swing_ = 0.4 * options.systematic_error * run.uniform(-1, 1);
  phase_ = run.uniform(0, 2 * kPi);
}

double RangeNoise::systematic_error(double range) const {
  return constant_ + swing_ * std::sin(2 * kPi * range / kSwingWavelength + phase_);
}

float RangeNoise::simulate_range(double true_range, double incidence, double reflectivity,
                                 RandomStream& beam) const {
  const bool lost = beam.uniform() < options_.no_return;
  if (lost || !(true_range < reach(options_, reflectivity, incidence))) return kNoReturn;
  double range = true_range + systematic_error(true_range);
  if (options_.statistical_error > 0) range += options_.statistical_error * beam.normal();
  if (options_.quantum > 0) {
    // Zero means "nothing measured" in many logs: the shortest range is one step.
    range = std::max(1.0, std::round(range / options_.quantum)) * options_.quantum;
  }
  range = std::max(range, 0.0);
  return range < options_.max_range ? static_cast<float>(range) : kNoReturn;
}

float RangeNoise::simulate_range(const Echo* echoes, std::size_t count, RandomStream& beam) const {
  if (count == 0) return kNoReturn;
  const auto nearer = [](const Echo& a, const Echo& b) { return a.range < b.range; };
  const Echo near = *std::min_element(echoes, echoes + count, nearer);
  std::size_t in_front = 0;
  double sum = 0;
  const Echo* behind = nullptr;
  for (const Echo* e = echoes; e != echoes + count; ++e) {
    if (e->range < near.range + kPulseLength) {
      ++in_front;
      sum += e->range;
    } else if (behind == nullptr || e->range < behind->range) {
      behind = e;
    }
  }
  const double share = static_cast<double>(in_front) / static_cast<double>(count);
  if (behind != nullptr && share < kEnoughForeground) {
    return simulate_range(behind->range, behind->incidence, behind->reflectivity, beam);
  }
  const double between = sum / static_cast<double>(in_front);
  return simulate_range(between, near.incidence, near.reflectivity, beam);
}

}  // namespace majak::sensor
