// SPDX-License-Identifier: Apache-2.0
// Satellite fixes as a reference for a path that was not fed with them. Fixes come in bursts, which
// err alike within, so whole bursts are held out; and some fixes jump, which the wheels tell: the
// way between two fixes is as long as the way driven, wherever the robot is.
#pragma once

#include <cstddef>
#include <vector>

#include "majak/core/event.hpp"

namespace majak::eval {

struct ReferenceFix {
  Time time = 0;
  Vec2 p = Vec2::Zero();  ///< m, east and north, of the antenna
  std::size_t burst = 0;  ///< of fixes less than 5 s apart
  bool sound = false;     ///< of five fixes and more that step as the wheels do, not the last one
                          ///< before an outage
};

struct ReferenceFixes {
  std::vector<ReferenceFix> fixes;  ///< all of the log, in its order
  std::size_t bursts = 0;
};

/// `wheelbase` in m, of the car whose WheelMotion is in the log.
ReferenceFixes reference_fixes(const std::vector<Event>& events, double wheelbase);

/// Which fixes fold 0 or fold 1 holds out: those of every other burst, never the first nor the
/// last.
std::vector<bool> hold_out_fold(const ReferenceFixes& reference, std::size_t fold);
/// Those of one burst.
std::vector<bool> hold_out_burst(const ReferenceFixes& reference, std::size_t burst);
/// Those between two times.
std::vector<bool> hold_out_between(const ReferenceFixes& reference, Time from, Time to);

}  // namespace majak::eval
