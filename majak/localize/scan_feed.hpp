// SPDX-License-Identifier: Apache-2.0
// ScanFeed: hands out the scans of a log, each with how the robot moved since the one before: by
// wheels where there are any (their lag and scale are learnt on the way), else by habit. What
// every method on a known map is fed with.
//
//   feed.add(event);
//   while (auto scan = feed.next()) { ... feed.observe(motion as found, trusted); }
#pragma once

#include <deque>
#include <optional>

#include "majak/core/event.hpp"
#include "majak/motion/habit.hpp"
#include "majak/motion/odometry_model.hpp"

namespace majak::localize {

/// A scan, and the motion from the scan before it.
struct FedScan {
  Scan scan;
  Pose2 T_previous_robot;
  Mat3 covariance = Mat3::Zero();  ///< of log(T_previous_robot^-1 * truth); zero for the first
  bool by_wheels = false;
};

class ScanFeed {
 public:
  explicit ScanFeed(const motion::OdometryModelOptions& options = {}) : odometry_(options) {}

  /// The next event; those that are neither scan of the first laser nor odometry are passed over.
  void add(const Event& event);
  /// The log has ended: what waits for odometry waits no longer.
  void end() { ended_ = true; }
  /// The next scan whose motion is known.
  std::optional<FedScan> next();
  /// How the robot moved up to the scan handed out last; `trusted` if that is sure.
  void observe(const Pose2& T_previous_robot, bool trusted);

 private:
  motion::OdometryModel odometry_;
  motion::Habit habit_;
  std::deque<Scan> waiting_;
  std::size_t handed_out_ = 0;
  Time last_time_ = 0, before_last_ = 0;
  bool ended_ = false;
};

}  // namespace majak::localize
