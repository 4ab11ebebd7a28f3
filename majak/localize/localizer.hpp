// SPDX-License-Identifier: Apache-2.0
// Localizer: what every method of localization looks like from outside. Whoever runs one hands it
// events in the log's order and asks for the whole path at the end; methods/ makes them by name.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "majak/core/estimate.hpp"
#include "majak/core/event.hpp"
#include "majak/core/report.hpp"

namespace majak::localize {

/// What an absolute measurement said against what was expected of it.
struct Innovation {
  Time time = 0;
  const char* sensor = "";  ///< "gps", "beacon", "scan match" ...
  double nis = 0;           ///< normalized innovation squared; chi-square with `dof` if honest
  int dof = 0;
  bool used = true;  ///< false: beyond the gate
};

/// A number that the run has found out beside the path: a scale, an offset, a place on the robot.
struct LearntValue {
  std::string name;  ///< for people: "antenna ahead of the axle"
  std::string unit;
  double value = 0;
  double sigma = 0;
};

/// One of several places where the robot may be.
struct Hypothesis {
  Pose2 T_map_robot;
  Mat3 covariance = Mat3::Zero();  ///< map axes
  double probability = 0;
};

/// What a method that keeps several knew at a time, the likeliest first.
struct HypothesesAt {
  Time time = 0;
  std::vector<Hypothesis> hypotheses;
};

/// How long a part of the work took, where a clock was given.
struct PhaseTime {
  const char* name = "";
  double seconds = 0;
};

/// What a finished run leaves: its best estimates, by time.
struct Localization {
  std::vector<Estimate> estimates;
  std::vector<Innovation> innovations;
  std::vector<LearntValue> learnt;
  std::vector<HypothesesAt> hypotheses;
  std::vector<PhaseTime> phases;
  /// Memory of the belief after each estimate; empty: it is the estimate and the hypotheses.
  std::vector<std::size_t> belief_bytes;
  std::int64_t updates = 0;  ///< scans that were weighed; 0: all of them
  Report report;
};

struct Localizer {
  /// The next event, in the log's order; the newest estimate where it made one.
  std::function<std::optional<Estimate>(const Event&)> add;
  /// After the last event. May know more than add() did at the time (smoothing).
  std::function<Localization()> finish;
};

}  // namespace majak::localize
