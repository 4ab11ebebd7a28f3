// SPDX-License-Identifier: Apache-2.0
// A sensor_msgs/LaserScan as a Scan, and a Scan as a sensor_msgs/LaserScan.
#pragma once

#include <optional>
#include <string>

#include "majak/core/event.hpp"
#include "majak/core/report.hpp"
#include "majak/io/ros_messages.hpp"
#include "majak/io/ros_transforms.hpp"

namespace majak::io {

struct RosScanOptions {
  std::optional<double> angle_step;  ///< rad, instead of what the message states
  std::optional<float> code;         ///< m, what this laser writes when nothing comes back
};

/// Ranges below range_min and zeros become kInvalidRange, as do not-a-numbers; from range_max on
/// and infinite, kNoReturn. Beams of a laser that turns clockwise or hangs upside down are put in
/// counter-clockwise order. What is odd about the message is counted in the report. Nothing when
/// the message has no beams or no usable angles.
std::optional<Scan> scan_of(const ros::LaserScan& message, const Mounting& mounting,
                            const RosScanOptions& options, std::int64_t record, Report& report);

/// What scan_of() turns into the same scan again: to the bit where its angles are whole
/// ten-thousandths of a degree, else rounded to 32 bits. The mounting goes into a transform, and
/// the odometry into a message of its own.
ros::LaserScan message_of(const Scan& scan, std::string frame);

}  // namespace majak::io
