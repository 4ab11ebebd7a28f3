// SPDX-License-Identifier: Apache-2.0
#include "majak/match/beams.hpp"

#include <algorithm>
#include <cmath>

namespace majak::match {

Beams beams(const Scan& scan, const BeamsOptions& options) {
  Beams kept;
  kept.laser = scan.T_robot_laser.translation();
  kept.max_range = std::min<double>(scan.max_range, options.max_range);
  std::vector<std::size_t> valid;
  for (std::size_t i = 0; i < scan.ranges.size(); ++i)
    if (!std::isnan(scan.ranges[i]) && !(scan.ranges[i] <= options.min_range)) valid.push_back(i);
  const std::size_t n = options.most > 0
                            ? std::min(valid.size(), static_cast<std::size_t>(options.most))
                            : valid.size();
  const auto beam = [&](std::size_t k) { return valid[(2 * k + 1) * valid.size() / (2 * n)]; };
  const auto returned = [&](std::size_t i) { return scan.ranges[i] < kept.max_range; };
  for (const bool wanted : {true, false}) {
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t i = beam(k);
      if (returned(i) != wanted) continue;
      const double angle = scan.angle(i) + scan.T_robot_laser.theta;
      kept.cos.push_back(static_cast<float>(std::cos(angle)));
      kept.sin.push_back(static_cast<float>(std::sin(angle)));
      kept.range.push_back(wanted ? scan.ranges[i] : kNoReturn);
      if (!wanted) continue;
      kept.x.push_back(static_cast<float>(kept.laser.x()) + kept.range.back() * kept.cos.back());
      kept.y.push_back(static_cast<float>(kept.laser.y()) + kept.range.back() * kept.sin.back());
    }
    if (wanted) kept.returns = kept.range.size();
  }
  return kept;
}

}  // namespace majak::match
