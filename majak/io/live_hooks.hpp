// SPDX-License-Identifier: Apache-2.0
// What a live source needs of the world outside: the library has no clock of its own.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "majak/core/time.hpp"

namespace majak::io {

struct LiveHooks {
  std::function<Time()> clock;                       ///< now, in ns since 1970, never backwards
  std::function<bool()> stopped;                     ///< true ends the source
  std::function<void(const std::string&)> activity;  ///< what it is busy with, where that changes
  /// Each telegram with measured values, whole, and when its first byte came; before its scan.
  std::function<void(std::span<const std::uint8_t>, Time)> telegram;
};

/// Between two looks at stopped().
inline constexpr Duration kLivePatience = kSecond / 10;
/// Between two tries to open a port or a connection again.
inline constexpr Duration kReopenEvery = kSecond / 2;

}  // namespace majak::io
