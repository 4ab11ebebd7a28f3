// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "majak/core/angle.hpp"

namespace majak {

/// s after beam 0 at which a beam was fired; angle_step in rad, mirror_turn in s. A laser fires
/// every degree: a finer scan is put together from several turns of the mirror.
inline double beam_delay(double angle_step, std::size_t beam, double mirror_turn) {
  constexpr double kFired = radians(1.0);
  const auto turns = std::max(1L, std::lround(kFired / std::abs(angle_step)));
  const auto turn = static_cast<double>(beam % static_cast<std::size_t>(turns));
  return mirror_turn * (turn + static_cast<double>(beam) * std::abs(angle_step) / (2 * kPi));
}

}  // namespace majak
