// SPDX-License-Identifier: Apache-2.0
// What a program costs: it is run, and the system is asked.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace majak::bench {

struct Cost {
  double cpu_s = 0;  ///< user and system, all threads
  double wall_s = 0;
  double peak_mb = 0;  ///< resident, 10^6 bytes
  int exit_code = 0;   ///< 128 + signal when it was killed
};

/// Runs the command; what it prints goes to the file `output`. Throws std::runtime_error when it
/// cannot be started. The peak is never below what the caller itself holds, so measure before you
/// load.
Cost measure(const std::vector<std::string>& command, const std::filesystem::path& output);

}  // namespace majak::bench
