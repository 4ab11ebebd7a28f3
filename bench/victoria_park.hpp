// SPDX-License-Identifier: Apache-2.0
// The Victoria Park set as its benchmarks read it, with its fixes as reference.
#pragma once

#include <fmt/core.h>

#include <algorithm>
#include <cstdio>
#include <set>
#include <string>
#include <vector>

#include "majak/core/event.hpp"
#include "majak/eval/held_out_fixes.hpp"
#include "majak/io/source.hpp"

namespace majak::bench {

inline constexpr double kWheelbase = 2.83;  // m

struct ParkData {
  std::vector<Event> events;
  std::vector<GpsFix> fixes;
  std::vector<int> burst;   ///< of each fix
  std::vector<bool> sound;  ///< each fix, by data alone
  int bursts = 0;

  explicit ParkData(const std::string& folder);
  /// Bursts that are held out: every other one, the first and the last one never; fold 0 or 1.
  std::set<int> held_out(int fold) const {
    std::set<int> held;
    for (int b = 1; b + 1 < bursts; ++b)
      if (b % 2 != fold) held.insert(b);  // the second burst is the first to be held out
    return held;
  }
};

inline ParkData::ParkData(const std::string& folder) {
  const auto source = io::open_log(folder);
  while (auto event = source->next()) {
    if (const auto* fix = std::get_if<GpsFix>(&*event)) fixes.push_back(*fix);
    events.push_back(std::move(*event));
  }
  const eval::ReferenceFixes reference = eval::reference_fixes(events, kWheelbase);
  for (const eval::ReferenceFix& fix : reference.fixes) {
    burst.push_back(static_cast<int>(fix.burst));
    sound.push_back(fix.sound);
  }
  bursts = static_cast<int>(reference.bursts);
}

inline void tell_errors(const std::string& name, const char* which, std::vector<double> errors) {
  if (errors.empty()) return;
  std::sort(errors.begin(), errors.end());
  double mean = 0;
  for (double e : errors) mean += e;
  mean /= static_cast<double>(errors.size());
  fmt::print("{:8} {:5} fixes {:4}  mean {:.3f}  median {:.3f}  max {:.2f}\n", name, which,
             errors.size(), mean, errors[errors.size() / 2], errors.back());
}

}  // namespace majak::bench
