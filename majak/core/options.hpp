// SPDX-License-Identifier: Apache-2.0
// Options are plain structs. Each describes itself once, and that one description serves reading
// and writing of options.toml, --set and the documentation:
//
//   inline void describe(OptionFields& fields, MatchOptions& o) {
//     fields.add("match.max_range", o.max_range, {"m", "longer beams are not matched", 1, 100});
//   }
#pragma once

#include <limits>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace majak {

struct OptionInfo {
  const char* unit = "";  ///< "m", "rad", "s", "1" ...
  const char* help = "";
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
};

/// One option: a dotted name ("table.key") and where its value lives.
struct OptionField {
  std::string name;
  std::variant<bool*, int*, double*> value;
  OptionInfo info;
};

struct OptionFields {
  std::vector<OptionField> list;

  template <class T>
  void add(std::string name, T& value, OptionInfo info) {
    list.push_back({std::move(name), &value, info});
  }
};

}  // namespace majak
