// SPDX-License-Identifier: Apache-2.0
// What a beacon sends, how fast that travels, how far it reaches and how well it measures.
#pragma once

#include <array>
#include <cmath>
#include <optional>

#include "majak/beacon/trilateration.hpp"

namespace majak::beacon {

inline constexpr double kSpeedOfLight = 299792458.0;  // m/s
inline constexpr double kRoomTemperature = 20;        // degrees Celsius

/// m/s in dry air: that of an ideal gas goes with the root of the absolute temperature, 331.3 m/s
/// at 0 degrees Celsius (Kuttruff, Acoustics, 2007). A degree is 0.17 % of every range.
inline double speed_of_sound(double celsius) { return 331.3 * std::sqrt(1 + celsius / 273.15); }

/// Typical figures; a device's own sheet knows better.
struct BeaconKind {
  const char* name;
  bool by_sound;        ///< else at the speed of light
  double max_range;     ///< m
  double range_sigma;   ///< m
  double outlier_rate;  ///< share of signals that came by way of a wall
};
inline constexpr std::array<BeaconKind, 4> kBeaconKinds{{{"sound", true, 50, 0.05, 0.10},
                                                         {"ultrasound", true, 10, 0.01, 0.05},
                                                         {"light", false, 30, 0.02, 0.02},
                                                         {"radio", false, 100, 0.10, 0.10}}};

/// m/s.
inline double speed_of(const BeaconKind& kind, double celsius = kRoomTemperature) {
  return kind.by_sound ? speed_of_sound(celsius) : kSpeedOfLight;
}

/// The range that a delay (s) means; nothing where it is negative, no number, or farther than such
/// a beacon reaches.
inline std::optional<RangeTo> range_by_delay(const BeaconKind& kind, const Vec2& p_map,
                                             double delay, double celsius = kRoomTemperature) {
  const double range = delay * speed_of(kind, celsius);
  if (!(range >= 0 && range <= kind.max_range)) return std::nullopt;
  return RangeTo{p_map, range, kind.range_sigma};
}

}  // namespace majak::beacon
