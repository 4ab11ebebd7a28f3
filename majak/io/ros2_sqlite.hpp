// SPDX-License-Identifier: Apache-2.0
// ROS 2 bags beside MCAP: the SQLite file (*.db3), and the folder that `ros2 bag record` makes:
// metadata.yaml and the files that it lists.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "majak/io/ros_log.hpp"
#include "majak/io/sqlite.hpp"

namespace majak::io {

bool looks_like_sqlite(std::string_view head);

class Ros2Sqlite final : public MessageLog {
 public:
  /// Throws Error, without the file's name, when this is no ROS 2 bag.
  explicit Ros2Sqlite(const std::filesystem::path& path, Depth depth = Depth::messages);

  bool next(Message& message) override;

 private:
  void read_topics();

  Database database_;
  std::vector<std::pair<std::int64_t, std::size_t>> topic_of_;  ///< id in the file, index here
  std::unique_ptr<Statement> rows_;
  std::string unpacked_;
  std::int64_t row_ = 0;
};

/// The files of a folder in the order that its metadata.yaml states; empty when it has none.
/// Throws Error, without the folder's name, when metadata.yaml cannot be understood.
std::vector<std::filesystem::path> ros2_bag_files(const std::filesystem::path& folder);

/// Several recordings, one behind the other.
class ChainedLogs final : public MessageLog {
 public:
  explicit ChainedLogs(std::vector<OpenMessages> open, Depth depth = Depth::messages)
      : open_(std::move(open)), depth_(depth) {}

  bool next(Message& message) override;

 private:
  void adopt_topics();

  std::vector<OpenMessages> open_;
  Depth depth_;
  std::size_t at_ = 0;
  std::unique_ptr<MessageLog> log_;
  std::vector<std::size_t> topic_of_;  ///< of the current one, in all of them
};

}  // namespace majak::io
