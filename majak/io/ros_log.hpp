// SPDX-License-Identifier: Apache-2.0
// MessageLog: a ROS recording as one message after the other, whatever file holds it: a ROS 1 bag,
// an MCAP file, an SQLite bag or a folder of these. Memory is bounded by one chunk of the file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "majak/core/report.hpp"
#include "majak/core/time.hpp"
#include "majak/io/ros_messages.hpp"

namespace majak::io {

struct Topic {
  std::string name;
  std::string type;                       ///< as ROS 1 writes it: "sensor_msgs/LaserScan"
  std::optional<ros::Encoding> encoding;  ///< absent: one that majak does not read

  bool operator==(const Topic&) const = default;
};

struct Message {
  std::size_t topic = 0;  ///< index into topics()
  Time time = 0;          ///< when it was recorded
  std::string_view data;  ///< valid until the next call of next()
};

class MessageLog {
 public:
  virtual ~MessageLog();
  /// The next message in the order of the file; false at the end.
  virtual bool next(Message& message) = 0;
  /// What is known by now; grows while reading, and never loses or moves one.
  const std::vector<Topic>& topics() const { return topics_; }
  /// What was noticed so far; complete after next() has returned false.
  virtual const Report& report() const { return report_; }

 protected:
  /// The index of this topic; a new one where it is new. `type` may be of the form of ROS 2.
  std::size_t topic_index(std::string_view name, std::string_view type,
                          std::optional<ros::Encoding> encoding);

  std::vector<Topic> topics_;
  Report report_;
};

/// How deep to read.
enum class Depth : std::uint8_t {
  messages,
  topics,  ///< only what stands outside of compressed chunks, for the list of topics
};

/// Opens one and the same recording again and again.
using OpenMessages = std::function<std::unique_ptr<MessageLog>(Depth)>;

}  // namespace majak::io
