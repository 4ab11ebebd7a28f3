// SPDX-License-Identifier: Apache-2.0
// ScanChain: from a log to key scans. Scans wait for their odometry, the front end places them in
// its drifting frame, and what is worth it becomes a key scan. Every method of slam/ is fed by it,
// so that they differ in what they make of key scans and in nothing else.
//
//   chain.add(event);
//   while (const auto step = chain.next()) {
//     if (step->key) ...  // the newest of keys(): move its T_map_robot, and that of others
//     newest = chain.settle();
//   }
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "majak/core/event.hpp"
#include "majak/core/options.hpp"
#include "majak/core/parallel.hpp"
#include "majak/core/site.hpp"
#include "majak/motion/drive_correction.hpp"
#include "majak/motion/odometry_model.hpp"
#include "majak/slam/front_end.hpp"
#include "majak/slam/key_scan.hpp"

namespace majak::slam {

struct ScanChainOptions {
  bool use_odometry = true;  ///< false: the laser alone
  FrontEndOptions front_end;
  motion::OdometryModelOptions odometry;
  motion::DriveCorrection drive;  ///< from a calibration; mends the log before anything else
};

void describe(OptionFields& fields, ScanChainOptions& options);

/// Where a scan is by its key scans' present poses: the front end's ways from the one before
/// (`key`) and to the next disagree by what these have been moved, and the scans between share it.
struct Hung {
  Pose2 T_map_robot;
  std::size_t key = 0;  ///< the nearer of the two
};
Hung hang(const std::vector<PosedScan>& scans, const KeyScans& keys, std::size_t key,
          std::size_t scan);

class ScanChain {
 public:
  explicit ScanChain(const ScanChainOptions& options);

  /// The next event, in the log's order.
  void add(Event event);
  /// The log has ended: what waits for odometry waits no longer.
  void end() { ended_ = true; }

  struct Step {
    std::size_t scan = 0;
    /// Motion since the scan before: by the wheels, or where these say nothing by the front end.
    Pose2 T_previous_robot;
    bool key = false;  ///< it became the newest of keys(), where the correction of the one before
                       ///< puts it
  };
  /// Places the next scan, if it is ready.
  std::optional<Step> next();
  /// The newest scan hangs on its key scan from now on; its estimate.
  const Estimate& settle();

  KeyScans& keys() { return keys_; }
  const KeyScans& keys() const { return keys_; }
  /// All scans so far, and what else goes into the result.
  Site& site() { return site_; }
  const Site& site() const { return site_; }
  /// The first so many have a place; the others wait for odometry.
  std::size_t placed() const { return placed_; }
  /// The key scan (of keys()) that a scan hangs on.
  std::size_t key_of(std::size_t scan) const { return key_of_[scan]; }

  /// Where a scan is by its key scans' present poses.
  Hung hang(std::size_t scan) const;
  /// That for all scans, and how well each fits the map that the key scans make together.
  void hang_all(Threads threads);

  /// The scans' odometry as it reads now that its lag and direction are known; finish() does it
  /// too.
  void mend_odometry();
  /// What was learnt of the odometry is added; the chain is empty then. Throws Error when there was
  /// no scan to work with.
  Site finish();

 private:
  Pose2 in_map(const Pose2& T_front_robot) const;

  ScanChainOptions options_;
  motion::CorrectedDrive drive_;
  motion::OdometryModel odometry_;
  FrontEnd front_end_;
  KeyScans keys_;
  std::vector<std::size_t> key_of_;  ///< key scan that a scan hangs on
  std::size_t placed_ = 0;
  bool ended_ = false;
  Site site_;
};

/// Share of returns on the map below which a scan does not fit its place.
inline constexpr double kLostScore = 0.4;

/// Nothing can be made of a log without scans: throws Error.
void require_keys(const KeyScans& keys);

}  // namespace majak::slam
