// SPDX-License-Identifier: Apache-2.0
#include "majak/sim/plan.hpp"
#include "tests/fuzz/fuzz.hpp"

/// Plans as text, and as PNG where the bytes say so.
MAJAK_FUZZ(text) {
  if (text.rfind("\x89PNG", 0) == 0) {
    majak::sim::parse_picture(text, "fuzz");
  } else {
    majak::sim::parse_plan(text, "fuzz");
  }
}
