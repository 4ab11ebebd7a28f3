// SPDX-License-Identifier: Apache-2.0
// What a live source needs of the world outside: the library has no clock of its own.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "majak/core/time.hpp"

namespace majak::io {

/// How far a live source is.
struct LiveStatus {
  std::string activity;      ///< what it is busy with, for people
  std::int64_t scans = 0;    ///< that it has given
  std::int64_t skipped = 0;  ///< that the device measured and that did not arrive
};

struct LiveHooks {
  std::function<Time()> clock;                    ///< now, in ns since 1970, never backwards
  std::function<bool()> stopped;                  ///< true ends the source
  std::function<void(const LiveStatus&)> status;  ///< told some ten times a second, or more often
  /// Each telegram with measured values, whole, and when its first byte came; before its scan.
  std::function<void(std::span<const std::uint8_t>, Time)> telegram;
};

/// Between two looks at stopped().
inline constexpr Duration kLivePatience = kSecond / 10;
/// Between two tries to open a port or a connection again.
inline constexpr Duration kReopenEvery = kSecond / 2;

}  // namespace majak::io
