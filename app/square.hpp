// SPDX-License-Identifier: Apache-2.0
// majak calibrate --square: the square-path test from a list of measured ends.
#pragma once

#include <string>

namespace majak::app {

struct SquareOptions {
  std::string ends;    ///< file: a line a run, `left|right x y`
  double side = 0;     ///< m
  double track = 0;    ///< m; 0: not known
  std::string output;  ///< options file; empty: none
  bool json = false;
};

/// Throws Error for a line that is none (file and line), or too few runs.
void run_square(const SquareOptions& options);

}  // namespace majak::app
