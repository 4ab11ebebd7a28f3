// SPDX-License-Identifier: Apache-2.0
// Ros1Bag: a ROS 1 bag of format 2.0, read from the first byte to the last. Its index is not asked,
// so that a recording that was cut off reads like any other.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "majak/io/piece_reader.hpp"
#include "majak/io/ros_log.hpp"

namespace majak::io {

/// "#ROSBAG V..." or the "#ROSRECORD V..." of its first years.
bool looks_like_ros1_bag(std::string_view head);

class Ros1Bag final : public MessageLog {
 public:
  /// Throws Error, without the file's name, when this is no bag of format 2.0.
  explicit Ros1Bag(std::unique_ptr<ByteStream> bytes, Depth depth = Depth::messages);

  bool next(Message& message) override;
  const Report& report() const override { return report_; }

 private:
  struct Record;

  bool read_record(Record& record);
  std::uint64_t mended_size(const Record& record);
  bool next_in_chunk(Message& message);
  bool take(const Record& record, Message& message);
  void open_chunk(const Record& record, bool whole);
  void learn_connection(const Record& record);
  void finish();

  PieceReader pieces_;
  Depth depth_;
  std::string header_, data_;  ///< of the record outside of chunks
  std::string unpacked_;
  std::string_view chunk_;  ///< what is left of the chunk
  std::map<std::uint32_t, std::size_t> topic_of_;
  std::int64_t records_ = 0;
  bool cut_off_ = false, finished_ = false;
};

}  // namespace majak::io
