// SPDX-License-Identifier: Apache-2.0
// Time: signed 64-bit nanoseconds since the log's own epoch. Exact, so that a stamp leaves the
// program with the same digits it came in with.
#pragma once

#include <cmath>
#include <cstdint>

namespace majak {

using Time = std::int64_t;      ///< nanoseconds since the log's epoch
using Duration = std::int64_t;  ///< nanoseconds

inline constexpr Duration kSecond = 1'000'000'000;

/// Seconds to nanoseconds, rounded to the nearest.
inline Duration from_seconds(double seconds) { return std::llround(seconds * 1e9); }

/// Nanoseconds to seconds.
inline double to_seconds(Duration ns) { return static_cast<double>(ns) * 1e-9; }

}  // namespace majak
