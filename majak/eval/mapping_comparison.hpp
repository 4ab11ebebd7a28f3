// SPDX-License-Identifier: Apache-2.0
// All methods of mapping side by side, on many variations of a log: other errors, worse wheels, no
// wheels, rings, crowds, parts of it. What Table 2 of the thesis is measured from.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "majak/eval/mapping_trial.hpp"
#include "majak/eval/maps_at_poses.hpp"

namespace majak::eval {

enum class Surroundings : std::uint8_t {
  usual,     ///< the log itself; rooms and corridors where it is simulated
  straight,  ///< there and no way back but the same
  ring,
  nested,  ///< rings within rings
  large    ///< many rooms
};

/// One variation.
struct TrialSetting {
  std::string group;  ///< what it is for: "seeds", "wheels" ...
  Surroundings where = Surroundings::usual;
  int seed = 1;
  double wheels = 1;  ///< times their usual errors; 0: there are none
  double part = 1;    ///< share of the log
  double stray = 0;   ///< share of returns that end before what they met
  int people = 0;     ///< who walk about
};

struct MappingPlan {
  int seeds = 20;  ///< of the same drive
  int rings = 10;
  int few = 5;  ///< seeds of everything else
};
/// In the order of their groups; `only`: those of some groups. Throws Error for a group that is
/// none.
std::vector<TrialSetting> plan_trials(const MappingPlan& plan,
                                      const std::vector<std::string>& only = {});

struct MappingComparison {
  std::string what;  ///< log or worlds, for people
  std::vector<std::string> methods;
  std::vector<TrialSetting> settings;
  /// [method][setting]; nothing: no such variation can be had of this log.
  std::vector<std::vector<std::optional<MappingScore>>> scores;
  /// [map of given_maps()][setting][PosesFrom]; nothing: not asked for, or no truth.
  std::vector<std::vector<std::optional<std::array<GivenScore, 3>>>> given;
};

struct MappingComparisonInput {
  std::string what;
  std::vector<std::string> methods;
  std::vector<std::string> maps{};  ///< of given_maps()
  std::vector<TrialSetting> settings;
  /// The log of a setting; nothing: it cannot be had. Called from several threads.
  std::function<std::optional<TrialLog>(const TrialSetting&)> log_of;
  methods::MappingOptions options;
  Threads threads;
  std::function<double()> clock;                ///< s of the calling thread's work; none: no times
  std::function<void(std::size_t)> progress{};  ///< runs finished so far, from any thread
};

/// All but times depend on the input alone. Throws Error where a method is none.
MappingComparison compare_mappings(const MappingComparisonInput& input);

/// The log itself as `usual` and `large`, made worse as a setting says; nothing for what it cannot
/// be. `log` must outlive the function.
std::function<std::optional<TrialLog>(const TrialSetting&)> variations_of(const TrialLog& log);

}  // namespace majak::eval
