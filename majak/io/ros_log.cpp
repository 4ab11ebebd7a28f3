// SPDX-License-Identifier: Apache-2.0
#include "majak/io/ros_log.hpp"

#include <algorithm>

namespace majak::io {

MessageLog::~MessageLog() = default;

std::size_t MessageLog::topic_index(std::string_view name, std::string_view type,
                                    std::optional<ros::Encoding> encoding) {
  Topic topic{std::string(name), std::string(type), encoding};
  // ROS 2 puts the kind of interface in the middle: sensor_msgs/msg/LaserScan.
  if (const auto middle = topic.type.find("/msg/"); middle != std::string::npos)
    topic.type.erase(middle, 4);
  const auto known = std::find(topics_.begin(), topics_.end(), topic);
  if (known != topics_.end()) return static_cast<std::size_t>(known - topics_.begin());
  topics_.push_back(std::move(topic));
  return topics_.size() - 1;
}

}  // namespace majak::io
