// SPDX-License-Identifier: Apache-2.0
// `majak compare [LOG]` without a map: all methods that make one, side by side.
#pragma once

#include <string>
#include <vector>

#include "majak/io/source.hpp"

namespace majak::app {

struct MappingCompareCommand {
  std::string log;  ///< empty: simulated places
  std::string output, truth, relations, options_file, methods = "all";
  std::vector<std::string> only, set;
  bool no_times = false;
  int seeds = 0, threads = 0;  ///< 0: the default, all
  io::SourceOptions source;
};

/// Names and what they are in the thesis, for the help.
std::string mapping_methods_help();

void run_compare_mapping(MappingCompareCommand& command);

}  // namespace majak::app
