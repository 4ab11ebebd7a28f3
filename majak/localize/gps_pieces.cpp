// SPDX-License-Identifier: Apache-2.0
#include "majak/localize/gps_pieces.hpp"

#include <algorithm>
#include <cmath>

namespace majak::localize {

bool GpsPieces::outage_between(const Seen& a, const GpsFix& b) const {
  return to_seconds(b.time - a.fix.time) > options_.outage;
}

FixVerdict GpsPieces::add(const GpsFix& fix, double way, double turned) {
  bool begins = seen_.empty() || outage_between(seen_.back(), fix);
  if (!begins) {
    const Seen& last = seen_.back();
    const double step = std::hypot(fix.east - last.fix.east, fix.north - last.fix.north);
    const double allowed =
        std::max(options_.jump, fix.sigma) + options_.lever * std::abs(turned - last.turned);
    begins = std::abs(step - std::abs(way - last.way)) > allowed;
  }
  if (begins) members_.push_back(0);
  ++members_.back();
  seen_.push_back({fix, way, turned, members_.size() - 1});
  return {members_.size() - 1, members_.back() >= options_.least};
}

std::vector<FixVerdict> GpsPieces::verdicts() const {
  std::vector<FixVerdict> verdicts;
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    const bool last = i + 1 < seen_.size() && outage_between(seen_[i], seen_[i + 1].fix);
    verdicts.push_back({seen_[i].piece, members_[seen_[i].piece] >= options_.least && !last});
  }
  return verdicts;
}

}  // namespace majak::localize
