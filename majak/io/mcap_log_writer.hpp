// SPDX-License-Identifier: Apache-2.0
// McapLogWriter: events as the messages of ROS 2 in an MCAP file. /scan (/scan2 ... for further
// lasers), /odom (the odometry's own records, or what the scans state where there are none), /drive
// (speed and steering), /fix, /ground_truth, and on /tf_static the lasers' mounting and where on
// the Earth the fixes' frame lies. What ROS has no message for here (sightings) is left out and
// counted.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "majak/core/event.hpp"
#include "majak/core/report.hpp"
#include "majak/io/mcap_writer.hpp"
#include "majak/io/ros_messages.hpp"

namespace majak::io {

class McapLogWriter {
 public:
  /// An empty file in the place of whatever was there. Throws Error (path, cause).
  explicit McapLogWriter(const std::string& path);

  void write(const Event& event);
  void close();
  const Report& report() const { return report_; }

 private:
  void settle();
  void put(const Event& event);
  void write_scan(const Scan& scan);
  void write_pose(const std::string& topic, Time time, const Pose2& pose, double speed,
                  double turn_rate);
  void write_drive(const WheelMotion& wheels);
  void write_fix(const GpsFix& fix);
  void write_static(Time time, const std::string& parent, const std::string& child,
                    const ros::Transform& transform);
  std::uint16_t channel(const std::string& topic, const std::string& type,
                        const std::string& definition);

  GrowingFile file_;
  McapWriter writer_;
  std::map<std::string, std::uint16_t> channels_;
  std::map<int, Pose2> mountings_;  ///< told so far
  bool placed_on_earth_ = false;
  std::optional<bool> scans_have_odom_;  ///< the odometry is in the scans' records, not in its own
  std::vector<Event> waiting_;           ///< until that is known
  Report report_;
};

}  // namespace majak::io
