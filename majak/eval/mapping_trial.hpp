// SPDX-License-Identifier: Apache-2.0
// One method of mapping on one log: how right it is, how honest, what it costs.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "majak/core/event.hpp"
#include "majak/eval/relations.hpp"
#include "majak/eval/trajectory.hpp"
#include "majak/methods/mappers.hpp"

namespace majak::eval {

/// A log, and what is known of where the robot was.
struct TrialLog {
  std::vector<Event> events;
  Trajectory truth;                 ///< any frame; empty: nobody knows
  std::vector<Relation> relations;  ///< may be empty
};

struct MappingScore {
  bool ran = false;
  bool no_loop = false;            ///< it looks for loops, and says that it found none
  std::string said;                ///< why it did not
  double rms = 0, worst = 0;       ///< m off the truth, after one alignment of the whole path
  std::optional<double> relation;  ///< m, mean
  /// m, mean way of a return from the walls that the true poses make of the same scans; at most 1.
  double map_error = 0;
  std::optional<double> nees;  ///< mean over the run; 3 if honest; of methods with posterior
  /// Share of the places that were seen again whose poses lie on each other within 0.2 m.
  std::optional<double> recognised;
  bool online = false;  ///< gave poses on the way
  double way = 0;       ///< m, of the truth
  std::size_t scans = 0;
  double cpu = 0, cpu_finish = 0;           ///< s in all; of that after the last event
  double cpu_first = 0, cpu_last = 0;       ///< s a scan, in the first and in the last fifth
  std::size_t bytes = 0;                    ///< that it keeps beside the scans
  std::size_t landmarks = 0;                ///< of methods that map these
  std::size_t corrections = 0, undone = 0;  ///< loops closed on the way; taken back
};

/// `clock`: s of this thread's work; none: no times.
MappingScore try_mapping(const TrialLog& log, const methods::MappingMethod& method,
                         const methods::MappingOptions& options, Threads threads,
                         const std::function<double()>& clock);

}  // namespace majak::eval
