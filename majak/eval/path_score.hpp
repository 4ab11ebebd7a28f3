// SPDX-License-Identifier: Apache-2.0
// How wrong a path is at the places where somebody else knows better: by fixes that it was not fed
// with, or by truth.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "majak/core/estimate.hpp"
#include "majak/eval/statistics.hpp"

namespace majak::eval {

enum class Against : std::uint8_t {
  aligned,     ///< all of the reference, after one alignment of the whole path
  first_pose,  ///< all of it, the first pose alone made equal
  held_out,    ///< what was withheld, nothing aligned
  fed          ///< the fixes it was fed with, as the thesis did: no independent witness
};
const char* name_of(Against against);

/// One place of a path against the reference at that time.
struct PlaceError {
  Time time = 0;
  Vec2 off = Vec2::Zero();    ///< m, path less reference, in the reference's axes
  int group = 0;              ///< what errs together: a burst of fixes, a minute of truth
  bool sound = true;          ///< the reference is, by data alone
  std::optional<double> nis;  ///< by the covariances of path and fix, 2 degrees of freedom;
                              ///< of truth that of the whole pose, 3
  double error() const { return off.norm(); }
};

struct PathScore {
  Against against = Against::aligned;
  Pose2 T_reference_map;
  std::vector<PlaceError> errors;
};

/// A point of the robot where it truly was, by fixes or by truth.
struct Witness {
  Time time;
  Vec2 p;
  int group;
  bool sound;
  std::optional<Pose2> truth;  ///< of the whole robot
};

struct Reference {
  std::vector<Witness> witnesses;
  Vec2 point = Vec2::Zero();  ///< m, on the robot, where the witnesses are
  double variance = 0;        ///< m^2, each axis, of a witness
  double heading = 0;         ///< rad, at first
};

/// `chosen`: by witness, which ones count; empty: all of them. Where no estimate is near in time a
/// witness is left out.
PathScore score(const std::vector<Estimate>& estimates, const Reference& reference,
                const std::vector<bool>& chosen, Against against);

/// What is said of errors; how well their mean is known, by groups.
struct Headline {
  ErrorStats stats;
  MeanWithConfidence mean;
  std::size_t groups = 0;
  double scatter = 0;         ///< m, each axis, rms about the mean of the group
  std::optional<double> nis;  ///< mean, where it is known
};
Headline headline(const std::vector<PlaceError>& errors, bool sound_only = true);

}  // namespace majak::eval
