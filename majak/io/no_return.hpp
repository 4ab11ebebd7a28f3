// SPDX-License-Identifier: Apache-2.0
// SaturationFinder: which value does this laser write when a beam comes back with nothing? Old logs
// do not say, and it may be any number (81.83, 50.00, 8.19 ...). The finder looks for a value that
//   - stands at the upper end: hardly any longer range occurs,
//   - is a lone spike: the centimetres below it, and anything from 80 % of it on, are rare beside
//   it,
//   - stays the same while the robot drives: the scans that count are 0.2 m apart, or, without
//     odometry, differ in many beams. A wall does not follow the robot.
// It gives up when many beams are at or above the known limit: a laser has one such code.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "majak/core/event.hpp"

namespace majak::io {

/// Where the no-return codes of a SICK begin whose longest range is stated as one of them: 79.9 m
/// for 80 to 82, 8 m for 8 to 8.2. Any other range stays as it is.
float sick_limit(float range);

class SaturationFinder {
 public:
  /// Looks at one scan of one laser; ranges at or above scan.max_range count as known no-returns.
  void add(const Scan& scan);
  /// The code in metres, once the evidence suffices.
  std::optional<float> code() const { return code_; }

 private:
  bool is_news(const Scan& scan);
  void count_known(const Scan& scan);
  void decide();

  std::vector<std::uint32_t> beams_;     ///< how often each centimetre was measured
  std::vector<std::uint32_t> in_scans_;  ///< in how many scans that counted
  std::vector<std::uint32_t> seen_in_;   ///< the last such scan
  std::vector<float> last_ranges_;
  std::optional<Pose2> T_odom_last_;
  int scans_ = 0;                                    ///< that counted
  std::uint32_t known_beams_ = 0, known_scans_ = 0;  ///< at or above max_range
  bool has_odometry_ = false;
  bool done_ = false;
  std::optional<float> code_;
};

}  // namespace majak::io
