// SPDX-License-Identifier: Apache-2.0
// RosSource: a ROS recording as a Source: sensor_msgs/LaserScan, nav_msgs/Odometry (or what tf says
// of the odometry frame; where there is neither, ackermann_msgs/AckermannDriveStamped),
// sensor_msgs/NavSatFix, and the laser's mounting from tf.
//
// It reads the beginning twice: once to see which topics and frames there are, then for the events.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "majak/beacon/local_frame.hpp"
#include "majak/io/ros_log.hpp"
#include "majak/io/ros_scan.hpp"
#include "majak/io/ros_survey.hpp"
#include "majak/io/source.hpp"
#include "majak/io/stamp_order.hpp"

namespace majak::io {

class RosSource final : public Source {
 public:
  /// Throws Error, without the file's name, when the recording has no laser and no odometry, or
  /// when the choice of the laser's topic is left to the user.
  RosSource(const OpenMessages& open, std::string format, const SourceOptions& options);

  std::optional<Event> next() override;
  const Report& report() const override { return report_; }
  const std::string& format() const override { return format_; }

 private:
  bool read_message();
  void add_scan(const Message& message);
  void add_odometry(const Message& message);
  void add_fix(const Message& message);
  void place_on_earth();
  void add_drive(const Message& message);
  void add_truth(const Message& message);
  void follow_frames(const Message& message);
  void add_stamped(Event event, Time recorded);
  Mounting mounting(const std::string& laser_frame);
  void watch_stamp(const Event& event);
  void finish();

  std::string format_;
  RosSurvey survey_;
  RosScanOptions scan_options_;
  std::optional<Pose2> T_robot_laser_;  ///< as the user says
  std::unique_ptr<MessageLog> log_;
  FrameTree frames_;
  beacon::FirstFixFrame frame_of_fixes_;
  StampOrder order_;
  std::int64_t records_ = 0;
  std::optional<Time> last_stamp_[4];  ///< scans, odometry or drive, fixes, truth
  bool finished_ = false;
  Report report_;
};

/// A ROS 1 bag, an MCAP file or an SQLite bag by its first bytes, or a folder of ROS 2; nothing
/// when it is none. Throws Error with the path when it is one that cannot be read.
std::unique_ptr<Source> open_ros(const std::filesystem::path& path, std::string_view head,
                                 const SourceOptions& options);

}  // namespace majak::io
