// SPDX-License-Identifier: Apache-2.0
#include "majak/io/no_return.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace majak::io {

namespace {

constexpr std::size_t kBins = 10001;       // 0 ... 100 m in centimetres
constexpr double kApart = 0.2;             // m between scans that count
constexpr std::uint32_t kLeastBeams = 40;  // a spike of fewer proves nothing
constexpr std::uint32_t kLeastScans = 10;
constexpr int kDecideEvery = 5;  // at first; later ten times rarer

/// A tenth of the beams moved by more than 5 cm.
bool looks_different(const std::vector<float>& a, const std::vector<float>& b) {
  if (a.size() != b.size()) return true;
  std::size_t moved = 0;
  for (std::size_t i = 0; i < a.size(); ++i) moved += std::abs(a[i] - b[i]) > 0.05f ? 1 : 0;
  return moved * 10 > a.size();
}

}  // namespace

float sick_limit(float range) {
  // Devices answer with codes at the top of their 13 bits instead of a range: 81.83 ... 81.91 at a
  // centimetre, 8.183 ... 8.191 at a millimetre; 80 and 8 m are the longest ranges.
  constexpr float kLimitCm = 79.9f, kTopCm = 82.0f, kLimitMm = 8.0f, kTopMm = 8.2f;
  if (range >= kLimitCm && range <= kTopCm) return kLimitCm;
  if (range >= kLimitMm && range <= kTopMm) return kLimitMm;
  return range;
}

bool SaturationFinder::is_news(const Scan& scan) {
  if (scan.T_odom_robot) {
    if (!T_odom_last_) T_odom_last_ = scan.T_odom_robot;
    const Vec2 moved = scan.T_odom_robot->translation() - T_odom_last_->translation();
    if (moved.norm() >= kApart) {
      T_odom_last_ = scan.T_odom_robot;
      has_odometry_ = true;
      return true;
    }
    if (has_odometry_) return false;  // else it may be all zeros, and say nothing
  }
  if (!last_ranges_.empty() && !looks_different(scan.ranges, last_ranges_)) return false;
  last_ranges_ = scan.ranges;
  return true;
}

void SaturationFinder::add(const Scan& scan) {
  if (done_ || !is_news(scan)) return;
  count_known(scan);
  if (beams_.empty()) {
    beams_.assign(kBins, 0);
    in_scans_.assign(kBins, 0);
    seen_in_.assign(kBins, 0);
  }
  ++scans_;
  const auto number = static_cast<std::uint32_t>(scans_);
  for (const float range : scan.ranges) {
    if (!(range > 0.0f && range < 100.0f && range < scan.max_range)) continue;
    const auto bin = static_cast<std::size_t>(range * 100.0f + 0.5f);
    ++beams_[bin];
    if (seen_in_[bin] != number) {
      seen_in_[bin] = number;
      ++in_scans_[bin];
    }
  }
  if (scans_ % (scans_ <= 20 * kDecideEvery ? kDecideEvery : 10 * kDecideEvery) == 0) decide();
}

void SaturationFinder::count_known(const Scan& scan) {
  const auto known = std::count_if(scan.ranges.begin(), scan.ranges.end(),
                                   [&](float range) { return range >= scan.max_range; });
  known_beams_ += static_cast<std::uint32_t>(known);
  known_scans_ += known > 0 ? 1 : 0;
  done_ = known_beams_ >= 5 * kLeastBeams && known_scans_ >= 5 * kLeastScans;
}

/// From the top down: the first centimetre with enough beams is the code or there is none.
void SaturationFinder::decide() {
  std::uint32_t above = 0;
  const std::uint32_t least_scans = has_odometry_ ? kLeastScans : 5 * kLeastScans;
  for (std::size_t bin = kBins - 1; bin > 10; --bin) {
    const std::uint32_t count = beams_[bin];
    if (count < kLeastBeams) {
      above += count;
      if (above > kLeastBeams) return;
      continue;
    }
    if (in_scans_[bin] < least_scans || above * 50 > count) return;
    const auto at = beams_.begin() + static_cast<std::ptrdiff_t>(bin);
    const auto beside = *std::max_element(at - 5, at);
    const auto below =
        *std::max_element(beams_.begin() + static_cast<std::ptrdiff_t>(bin * 4 / 5), at);
    if (beside * 20 <= count && below * 5 <= count) {
      code_ = static_cast<float>(bin) / 100.0f;
      done_ = true;
    }
    return;
  }
}

}  // namespace majak::io
