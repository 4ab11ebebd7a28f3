// SPDX-License-Identifier: Apache-2.0
// One description of an options struct serves reading, writing, --set and the documentation.
// A struct describes itself by a free function found by its argument:
//
//   template <class Visitor>
//   void describe(Visitor& visit, MatchOptions& o) {
//     visit("max_range", o.max_range, {"m", "longer beams are not matched", 1, 100});
//   }
#pragma once

#include <limits>

namespace majak {

struct OptionInfo {
  const char* unit = "";
  const char* help = "";
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
};

}  // namespace majak
