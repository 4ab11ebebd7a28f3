// SPDX-License-Identifier: Apache-2.0
// Table 2 of the thesis (p. 34, after Thrun 2002, "Robotic mapping: a survey", table 1): what each
// family of methods can do, in a word; and beside each word what was measured.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "majak/eval/mapping_comparison.hpp"

namespace majak::eval {

struct Table2Cell {
  std::string word;            ///< the thesis's; empty: it has none
  std::string measured;        ///< empty: could not be measured on this log
  std::optional<bool> agrees;  ///< where a rule can tell
  std::string command;         ///< that measures it again
};

struct Table2Column {
  std::string name;  ///< the registry's
  std::string in_the_thesis;
};

struct Table2Row {
  std::string name;      ///< the thesis's
  std::string question;  ///< what was measured for it
  std::vector<Table2Cell> cells;
};

/// What each method reached, in numbers.
struct Table2Figures {
  std::string method;
  std::size_t runs = 0, usable = 0;
  double rms = 0, worst = 0, map_error = 0;  ///< m, medians
  std::optional<double> relation;            ///< m, mean of all relations
  std::optional<double> nees;
  double ms_a_scan = 0;  ///< CPU, in all
  double bytes = 0;
  std::vector<std::string> said;  ///< why runs did not come to an end; each once
};

struct Table2 {
  std::string what;
  std::vector<Table2Column> columns;
  std::vector<Table2Row> rows;
  std::vector<Table2Figures> figures;
};

/// rms off the truth up to which a map is called usable.
inline constexpr double kUsable = 0.5;  // m

/// `command`: the call that the comparison came from, "majak compare my.log".
Table2 table2_of(const MappingComparison& comparison, const std::string& command);

}  // namespace majak::eval
