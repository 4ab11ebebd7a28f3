// SPDX-License-Identifier: Apache-2.0
// EKF-SLAM as a method of mapping (the thesis's "Kalman filter", p. 35): key scans show corners,
// trunks and poles; landmarks are the map, and the scans hang on the path as the filter knew it at
// each time.
#pragma once

#include <optional>
#include <vector>

#include "majak/core/event.hpp"
#include "majak/core/options.hpp"
#include "majak/slam/ekf_slam.hpp"
#include "majak/slam/mapper.hpp"
#include "majak/slam/scan_chain.hpp"

namespace majak::slam {

/// Options of EkfSlam for a robot that maps rooms, seen from key scan to key scan.
EkfSlamOptions ekf_for_rooms();

class EkfMapper {
 public:
  EkfMapper(const ScanChainOptions& chain, const EkfSlamOptions& options, Threads threads);

  std::optional<Estimate> add(Event event);
  Mapping finish();

  /// What is known so far.
  const ScanChain& chain() const { return chain_; }

 private:
  std::optional<Estimate> take_scans();

  Threads threads_;
  ScanChain chain_;
  EkfSlam slam_;
  Pose2 T_odom_robot_;             ///< as the wheels were mended at the time
  std::vector<Mat3> covariances_;  ///< of the key scans, as known then
};

}  // namespace majak::slam
