// SPDX-License-Identifier: Apache-2.0
// Records of MCAP as bytes (mcap.dev/spec): what files are made of, and streams that never end.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "majak/io/mcap_format.hpp"

namespace majak::io {

struct McapChannel {
  std::string topic;
  std::string encoding{};         ///< of the messages: "cdr", or one's own
  std::string schema{};           ///< name of the type: "sensor_msgs/msg/LaserScan"; may be empty
  std::string schema_encoding{};  ///< "ros2msg"
  std::string schema_text{};
  std::map<std::string, std::string> metadata{};
};

namespace mcap {

template <class T>
void put_number(std::string& to, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i)
    to.push_back(static_cast<char>(static_cast<unsigned char>(value >> (8 * i))));
}

inline void put_text(std::string& to, std::string_view text) {
  put_number(to, static_cast<std::uint32_t>(text.size()));
  to += text;
}

inline std::string record(Opcode opcode, std::string_view content) {
  std::string bytes(1, static_cast<char>(opcode));
  put_number(bytes, static_cast<std::uint64_t>(content.size()));
  bytes += content;
  return bytes;
}

/// Magic and header: what every file begins with.
inline std::string head(std::string_view profile, std::string_view library) {
  std::string header;
  put_text(header, profile);
  put_text(header, library);
  return std::string(kMagic) + record(kHeader, header);
}

inline std::string schema_record(std::uint16_t id, const McapChannel& channel) {
  std::string content;
  put_number(content, id);
  put_text(content, channel.schema);
  put_text(content, channel.schema_encoding);
  put_text(content, channel.schema_text);
  return record(kSchema, content);
}

/// `schema`: its number, 0 for none.
inline std::string channel_record(std::uint16_t id, std::uint16_t schema,
                                  const McapChannel& channel) {
  std::string content, metadata;
  put_number(content, id);
  put_number(content, schema);
  put_text(content, channel.topic);
  put_text(content, channel.encoding);
  for (const auto& [name, value] : channel.metadata) {
    put_text(metadata, name);
    put_text(metadata, value);
  }
  put_text(content, metadata);
  return record(kChannel, content);
}

/// Appends a message. Times in ns since 1970.
inline void put_message(std::string& to, std::uint16_t channel, std::uint32_t sequence,
                        std::uint64_t recorded, std::uint64_t published, std::string_view data) {
  to.push_back(static_cast<char>(kMessage));
  put_number(to, static_cast<std::uint64_t>(2 + 4 + 8 + 8 + data.size()));
  put_number(to, channel);
  put_number(to, sequence);
  put_number(to, recorded);
  put_number(to, published);
  to += data;
}

}  // namespace mcap
}  // namespace majak::io
