// SPDX-License-Identifier: Apache-2.0
// Recordings made by hand, and what a message log gives.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "log_fixtures.hpp"
#include "majak/io/ros_log.hpp"
#include "majak/io/ros_messages.hpp"
#include "majak/io/unpack.hpp"

namespace majak::io::testing {

inline std::string le(std::uint64_t value, std::size_t size) {
  std::string bytes;
  for (std::size_t i = 0; i < size; ++i)
    bytes.push_back(static_cast<char>(static_cast<unsigned char>(value >> (8 * i))));
  return bytes;
}
inline std::string sized(std::string_view bytes) {
  return le(bytes.size(), 4) + std::string(bytes);
}
inline std::string field(std::string_view name, std::string_view value) {
  return sized(std::string(name) + "=" + std::string(value));
}
inline std::string op(int code) { return field("op", le(static_cast<std::uint64_t>(code), 1)); }

/// A ROS 1 bag, record by record.
class BagBuilder {
 public:
  std::string bytes = "#ROSBAG V2.0\n" +
                      sized(op(3) + field("index_pos", le(0, 8)) + field("conn_count", le(0, 4)) +
                            field("chunk_count", le(0, 4))) +
                      sized(std::string(60, ' '));

  static std::string record(std::string_view header, std::string_view data) {
    return sized(header) + sized(data);
  }
  static std::string connection(std::uint32_t id, std::string_view topic, std::string_view type) {
    return record(op(7) + field("conn", le(id, 4)) + field("topic", topic),
                  field("topic", topic) + field("type", type) + field("md5sum", "*") +
                      field("message_definition", "a=b\n"));
  }
  static std::string message(std::uint32_t connection, Time time, std::string_view data) {
    const auto t = static_cast<std::uint64_t>(time);
    return record(op(2) + field("conn", le(connection, 4)) +
                      field("time", le(t / kSecond, 4) + le(t % kSecond, 4)),
                  data);
  }
  static std::string chunk(std::string_view packing, std::string_view records) {
    std::string packed(records);
    if (packing == "bz2") packed = bzip2(packed);
    if (packing == "lz4") packed = pack(ChunkPacking::lz4, records);
    return record(op(5) + field("compression", packing) + field("size", le(records.size(), 4)),
                  packed);
  }
  static std::string index(std::uint32_t connection, std::uint32_t count, std::string_view data) {
    return record(op(4) + field("ver", le(1, 4)) + field("conn", le(connection, 4)) +
                      field("count", le(count, 4)),
                  data);
  }
};

/// Topic, time of recording and bytes.
using Told = std::tuple<std::string, Time, std::string>;

struct Heard {
  std::vector<Told> messages;
  std::vector<Topic> topics;
  Report report;

  std::int64_t noticed(std::string_view words) const {
    std::int64_t sum = 0;
    for (const auto& [what, entry] : report.entries())
      sum += what.find(words) != std::string::npos ? entry.count : 0;
    return sum;
  }
};

inline Heard hear(MessageLog& log) {
  Heard heard;
  Message message;
  while (log.next(message))
    heard.messages.emplace_back(log.topics().at(message.topic).name, message.time, message.data);
  heard.topics = log.topics();
  heard.report = log.report();
  return heard;
}

/// The first ones of the others, and nothing else.
inline bool is_prefix(const std::vector<Told>& a, const std::vector<Told>& b) {
  return a.size() <= b.size() && std::equal(a.begin(), a.end(), b.begin());
}

}  // namespace majak::io::testing
