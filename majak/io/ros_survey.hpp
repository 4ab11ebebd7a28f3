// SPDX-License-Identifier: Apache-2.0
// RosSurvey: what a ROS recording holds, found out before the first event is given: the topics, the
// frames of robot and odometry, the laser's habits.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "majak/io/ros_log.hpp"
#include "majak/io/ros_transforms.hpp"

namespace majak::io {

struct RosSurvey {
  std::string scan_topic, odometry_topic, fix_topic;  ///< empty: there is none
  std::string drive_topic;  ///< speed and steering, where there is no odometry
  std::string truth_topic;  ///< nav_msgs/Odometry whose name says "ground_truth"
  bool odometry_from_tf = false;
  std::string robot_frame;                 ///< empty: the recording does not say
  std::string odometry_frame;              ///< of tf
  FrameTree frames;                        ///< the first word about each frame
  std::optional<float> code;               ///< m, what the laser writes when nothing comes back
  bool velocity_missing = false;           ///< odometry states no speed while the robot drives
  bool use_recording_times = false;        ///< laser and odometry have different clocks
  std::vector<std::string> more_odometry;  ///< topics that were not chosen
};

/// Throws Error, one line without the file's name, when there is nothing to use or a choice to
/// make.
RosSurvey survey_recording(const OpenMessages& open, const std::string& scan_topic);

/// A frame that dead reckoning is told in, by its name.
bool is_odometry_frame(const std::string& frame);

}  // namespace majak::io
