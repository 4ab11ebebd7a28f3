// SPDX-License-Identifier: Apache-2.0
// The Victoria Park set as its benchmarks read it: bursts of fixes, and which fixes are sound by
// data alone (steps as long as the wheels say for five fixes and more, not the last before an
// outage).
#pragma once

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "majak/core/event.hpp"
#include "majak/io/source.hpp"
#include "majak/localize/gps_pieces.hpp"

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
  localize::GpsPiecesOptions screen;
  screen.least = 5;
  localize::GpsPieces pieces(screen);
  std::optional<WheelMotion> wheels;
  double way = 0, turned = 0;
  while (auto event = source->next()) {
    if (const auto* fix = std::get_if<GpsFix>(&*event)) {
      const bool outage = fixes.empty() || fix->time - fixes.back().time > 5 * kSecond;
      bursts += outage;
      fixes.push_back(*fix);
      burst.push_back(bursts - 1);
      pieces.add(*fix, way, turned);
    }
    if (const auto* now = std::get_if<WheelMotion>(&*event)) {
      const double step = wheels ? wheels->speed * to_seconds(now->time - wheels->time) : 0;
      way += step;
      if (wheels) turned += std::abs(step * std::tan(wheels->steering) / kWheelbase);
      wheels = *now;
    }
    events.push_back(std::move(*event));
  }
  for (const auto& verdict : pieces.verdicts()) sound.push_back(verdict.trusted);
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
