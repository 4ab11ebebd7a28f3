// SPDX-License-Identifier: Apache-2.0
// Methods of localization side by side: each runs over the same log on the same known map, and once
// more over that log with a stretch cut out, as if the robot had been carried to another place.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "majak/core/site.hpp"
#include "majak/eval/splice.hpp"
#include "majak/eval/trajectory.hpp"
#include "majak/methods/methods.hpp"

namespace majak::eval {

struct CompareOptions {
  double right = 0.5;            ///< m off the truth, within which a pose is right ...
  double right_turn = kPi / 18;  ///< rad, ... and in heading
  double step = 0.2;             ///< m driven from one update to the next ...
  double turn = 0.2;             ///< rad, ... or turned
  double apart = 3;              ///< m, that a robot is carried at least
};

struct CompareInput {
  const std::vector<Event>& events;
  /// T_map_robot by time, in the map's frame; empty: nobody knows.
  Trajectory truth;
  methods::LocalizeOptions options;  ///< with the place; `start` for methods that are told
  CompareOptions how;
  std::function<double()> clock;                            ///< s of CPU; none: no times
  std::function<void(const char*, std::int64_t)> progress;  ///< method, events so far; or none
};

/// What was said after the robot had been carried away, in updates from the first scan there on.
struct Recovery {
  bool knew = false;               ///< where it was, just before; else the rest says nothing
  std::optional<int> told_lost;    ///< nothing: never
  std::optional<int> right_again;  ///< and not lost; without truth: not lost any more
};

struct Spread {
  double median = 0, p95 = 0;
};

struct MethodResult {
  std::string method;
  bool told = false;  ///< where it starts
  std::vector<Estimate> estimates;
  /// Off the truth, where it did not say that it is lost; m, rad. Nothing without truth.
  std::optional<Spread> translation, rotation;
  std::optional<double> right;  ///< share of the estimates that are right and not said to be lost
  std::optional<double> wrong;  ///< share of those said to be ok that are not right
  std::int64_t health[3] = {};  ///< ok, degraded, lost
  double cpu_mean = 0, cpu_most = 0;               ///< s a scan
  std::int64_t updates = 0;                        ///< scans that the method weighed
  std::size_t belief_median = 0, belief_most = 0;  ///< bytes, see belief_bytes()
  std::optional<int> found;          ///< updates until right; until sure, without truth
  std::optional<Recovery> recovery;  ///< nothing: the log goes nowhere else
};

struct Comparison {
  std::vector<MethodResult> methods;
  std::vector<std::string> left_out;  ///< methods that found nothing they can use, and why
  std::optional<Splice> splice;       ///< without its events
  std::size_t scans = 0;
  int updates = 0;  ///< scans after CompareOptions::step or turn; the unit of found and recovery
};

/// Runs them in that order. Throws Error where a name is none, or none of the methods finds
/// anything it can use in the log.
Comparison compare(const CompareInput& input, const std::vector<std::string>& methods);

/// Bytes after each estimate: pose and covariance, and the hypotheses beside it; or what the method
/// says (particles with their weights, tiles of a grid). The map's own tables are not counted.
std::vector<std::size_t> belief_bytes(const localize::Localization& result);

/// The run's own poses, if it is one of this log: scans of the same times with the same ranges.
std::optional<Trajectory> path_of_same_log(const Site& site, const std::vector<Event>& events);

/// Share of returns, of some scans along the log, within 0.3 m of the map's surfaces if the robot
/// was where `truth` says: whether that is told in the map's frame.
double share_on_map(const localize::Place& place, const std::vector<Event>& events,
                    const Trajectory& truth);

/// One row a method; columns that are not known are empty.
std::string comparison_csv(const Comparison& comparison);

}  // namespace majak::eval
