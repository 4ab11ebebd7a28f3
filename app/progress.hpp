// SPDX-License-Identifier: Apache-2.0
// One line on a terminal that says how far the work is, nothing where output goes to a file; and
// what the work costs.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

#include "majak/io/live_hooks.hpp"

namespace majak::app {

/// s of all threads of this program.
double cpu_seconds();
/// MB of memory that this program holds now; 0 where the system does not say.
double resident_megabytes();
/// Threads to work with: `wanted`, or one a core for 0.
int thread_count(int wanted);

class Progress {
 public:
  Progress();
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Shows "stage: count", at most ten times a second and not within the first second.
  void show(const char* stage, std::int64_t count);
  /// "stage: done of all".
  void show(const char* stage, std::size_t done, std::size_t all);
  /// The same of a device.
  void show(const io::LiveStatus& status);
  /// Wipes the line.
  void clear();

 private:
  bool due();
  void print(const std::string& what);

  std::chrono::steady_clock::time_point started_, shown_;
  bool terminal_ = false, dirty_ = false;
};

}  // namespace majak::app
