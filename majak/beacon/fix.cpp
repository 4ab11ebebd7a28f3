// SPDX-License-Identifier: Apache-2.0
#include "majak/beacon/fix.hpp"

namespace majak::beacon {

const char* describe(FixProblem problem) {
  switch (problem) {
    case FixProblem::none:
      return "sound";
    case FixProblem::too_few:
      return "too few beacons for a fix";
    case FixProblem::bad_value:
      return "a measurement that is no number";
    case FixProblem::identical:
      return "beacons that stand in one place";
    case FixProblem::ambiguous:
      return "two places explain the measurements alike";
    case FixProblem::ill_conditioned:
      return "near the danger circle, or too far off";
    case FixProblem::inconsistent:
      return "no place explains the measurements";
  }
  return "";
}

}  // namespace majak::beacon
