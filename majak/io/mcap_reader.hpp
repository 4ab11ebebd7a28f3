// SPDX-License-Identifier: Apache-2.0
// McapReader: the messages of an MCAP file (mcap.dev/spec), read from the first byte to the last;
// the index is not asked, so that a recording that was cut off reads like any other.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "majak/io/piece_reader.hpp"
#include "majak/io/ros_log.hpp"

namespace majak::io {

bool looks_like_mcap(std::string_view head);

class McapReader final : public MessageLog {
 public:
  /// Throws Error, without the file's name, when this is no MCAP file.
  explicit McapReader(std::unique_ptr<ByteStream> bytes, Depth depth = Depth::messages);

  bool next(Message& message) override;

 private:
  bool next_in_chunk(Message& message);
  bool take(std::uint8_t opcode, std::string_view content, Message& message);
  void read_schema(std::string_view content);
  void read_channel(std::string_view content);
  bool read_message(std::string_view content, Message& message);
  void open_chunk(std::string_view content, bool whole);
  void finish();

  PieceReader pieces_;
  Depth depth_;
  std::string data_, unpacked_;
  std::string_view chunk_;  ///< what is left of the chunk
  std::map<std::uint16_t, std::string> schemas_;
  std::map<std::uint16_t, std::size_t> topic_of_;
  std::int64_t records_ = 0;
  bool cut_off_ = false, finished_ = false;
};

}  // namespace majak::io
