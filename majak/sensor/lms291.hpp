// SPDX-License-Identifier: Apache-2.0
// The SICK LMS-291: its sheet, when each beam of a scan is fired, and how its ranges err.
// Sources: SICK "Technical Description LMS2xx" (2003), "Telegram listing LMS2xx" (2006).
#pragma once

#include <array>
#include <cstddef>

#include "majak/core/angle.hpp"
#include "majak/core/options.hpp"
#include "majak/core/random.hpp"
#include "majak/core/time.hpp"

namespace majak::sensor {

/// What the maker promises, as far as a log or a simulation needs it.
struct SensorSheet {
  double mirror_rate;          ///< Hz, turns of the mirror
  double resolution;           ///< m, of a range
  double systematic_error;     ///< m, at most, 1 ... 20 m
  double statistical_error;    ///< m, one sigma, 1 ... 20 m, reflectivity 10 % or more
  double range_cm_mode;        ///< m, ranges in centimetres
  double range_mm_mode;        ///< m, ranges in millimetres
  double range_at_10_percent;  ///< m, reach on a target that reflects 10 %
  double spot_at_window;       ///< m, diameter of the beam where it leaves
  double divergence;           ///< rad, growth of that diameter with range
  double wavelength;           ///< m
  double supply;               ///< V
  double supply_tolerance;     ///< share of it
  double power;                ///< W
  double mass;                 ///< kg
  std::array<double, 3> size;  ///< m: width, depth, height
};
inline constexpr SensorSheet kLms291{75.0, 0.010, 0.035, 0.010,  80.0,
                                     8.0,  30.0,  0.016, 0.0119, 905e-9,
                                     24.0, 0.15,  20,    4.5,    {0.155, 0.156, 0.210}};

/// One turn of the mirror.
inline constexpr Duration kMirrorTurn = 13'333'333;  // ns, 1/75 s

/// Field of view and angular resolution that the device can be set to.
struct Variant {
  int field_of_view;  ///< degrees: 100 or 180
  int resolution;     ///< hundredths of a degree: 100, 50 or 25

  constexpr int beams() const { return field_of_view * 100 / resolution + 1; }
  constexpr double start_angle() const { return radians(-field_of_view / 2.0); }
  constexpr double angle_step() const { return radians(resolution / 100.0); }
  /// Turns of the mirror whose beams are interleaved into one scan: the laser fires every degree,
  /// so half a degree needs two turns and a quarter needs four.
  constexpr int turns() const { return 100 / resolution; }
  bool operator==(const Variant&) const = default;
};
inline constexpr std::array<Variant, 5> kVariants{
    {{180, 100}, {180, 50}, {100, 100}, {100, 50}, {100, 25}}};

/// The variant that delivers this many beams (181, 361, 101, 201, 401); throws Error for others.
Variant variant_of_beams(int beams);

/// Scans a second that reach the host: a new telegram begins with the first scan that is ready when
/// the line is free (telegram listing, table 10-17).
double delivered_rate(const Variant& variant, int baud);

/// When a beam was fired, after beam 0 of the same scan. Beam k belongs to turn k mod turns(),
/// and within its turn the mirror takes 1/75 s for 360 degrees.
Duration beam_time(const Variant& variant, int beam);

/// From the first beam of a scan to its last one (not the same as the last index).
Duration scan_duration(const Variant& variant);

struct RangeNoiseOptions {
  double max_range = 80.0;           ///< m; 8 in the millimetre mode
  double systematic_error = 0.035;   ///< m; the error of a run is drawn within +- this, 0 for none
  double statistical_error = 0.010;  ///< m, one sigma of each beam
  double quantum = 0.010;            ///< m, step of the ranges, 0 for none
  double no_return = 0.005;          ///< share of beams lost for no visible reason
  double range_at_10_percent = 30;   ///< m, reach on a target that reflects 10 % of the light
  double beam_width = 1.0;           ///< 1 = the real beam, 0 = a line: no mixed pixels
};
void describe(OptionFields& fields, RangeNoiseOptions& options);

/// Every error switched off: the range is the true distance, whatever the target.
RangeNoiseOptions perfect_range();

/// One patch that the beam's spot falls on.
struct Echo {
  double range = 0;
  double incidence = 0;
  double reflectivity = 0.5;  ///< 0.1 black card ... 0.8 white paper ... 20 a reflector
};

/// How far the laser sees a target: the echo weakens with the square of the range, so the reach
/// grows with the root of what the target sends back. Incidence 0 is head-on.
double reach(const RangeNoiseOptions& options, double reflectivity, double incidence);

/// The echo of a target that fills the spot, 1 where it is just seen: what it sends back weakens
/// with the square of the range, and grows with reflectivity and head-on incidence.
double echo_strength(const RangeNoiseOptions& options, const Echo& echo);

/// Half the angle under which the beam's spot is seen from the laser, at this range.
double half_beam_angle(double range);

/// The errors of one device in one run.
class RangeNoise {
 public:
  /// The systematic error is drawn here, from `run`.
  RangeNoise(const RangeNoiseOptions& options, RandomStream run);

  /// The range that the device reports, or kNoReturn. `beam` is the stream of this one beam.
  float simulate_range(double true_range, double incidence, double reflectivity,
                       RandomStream& beam) const;

  /// The same for a spot that falls on several patches: within one length of the light pulse
  /// their echoes run together into a value between; farther apart, one of the two is reported.
  float simulate_range(const Echo* echoes, std::size_t count, RandomStream& beam) const;

  /// The part of the error that is the same in the whole run; slowly varying with range.
  double systematic_error(double range) const;

 private:
  RangeNoiseOptions options_;
  double constant_ = 0, swing_ = 0, phase_ = 0;
};

}  // namespace majak::sensor
