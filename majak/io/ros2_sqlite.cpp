// SPDX-License-Identifier: Apache-2.0
#include "majak/io/ros2_sqlite.hpp"

#include <algorithm>
#include <fstream>
#include <system_error>
#include <utility>

#include "majak/core/error.hpp"
#include "majak/io/unpack.hpp"

namespace majak::io {

namespace {

constexpr std::string_view kMagic{"SQLite format 3\0", 16};
constexpr std::string_view kZstd = "\x28\xb5\x2f\xfd";
constexpr std::size_t kLargestMessage = std::size_t{1} << 29;

const char* const kStranger = "messages of a topic that the file does not describe; left out";
const char* const kBadPacked = "packed messages that are damaged; left out";
const char* const kDamaged = "the database is damaged or cut off; kept what came before";
const char* const kUnmerged =
    "the recording was not closed; what is only in its -wal file is left out";

bool is_file(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::file_size(path, ignored) > 0 && !ignored;
}

/// What stands behind "- " or "key: ", without quotes.
std::string plain_scalar(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  const bool quoted = text.size() >= 2 && (text.front() == '"' || text.front() == '\'') &&
                      text.back() == text.front();
  return std::string(quoted ? text.substr(1, text.size() - 2) : text);
}

}  // namespace

bool looks_like_sqlite(std::string_view head) { return head.starts_with(kMagic); }

Ros2Sqlite::Ros2Sqlite(const std::filesystem::path& path, Depth depth)
    : database_(Database::read_only(path.string())) {
  if (is_file(path.string() + "-wal")) report_.count(kUnmerged);
  try {
    read_topics();
    rows_ = std::make_unique<Statement>(
        database_, "SELECT topic_id, timestamp, data FROM messages ORDER BY timestamp, id");
    if (depth == Depth::topics) rows_.reset();
  } catch (const Error&) {
    throw Error("an SQLite file without the tables of a ROS 2 bag");
  }
}

void Ros2Sqlite::read_topics() {
  Statement rows(database_, "SELECT id, name, type, serialization_format FROM topics ORDER BY id");
  while (rows.step()) {
    const std::int64_t id = rows.integer();
    const std::string name(rows.bytes()), type(rows.bytes());
    const bool cdr = rows.bytes() == "cdr";
    const auto encoding = cdr ? std::optional(ros::Encoding::cdr) : std::nullopt;
    topic_of_.emplace_back(id, topic_index(name, type, encoding));
  }
}

bool Ros2Sqlite::next(Message& message) {
  while (rows_) {
    try {
      if (!rows_->step()) break;
    } catch (const Error&) {
      report_.count(kDamaged, row_ + 1);
      break;
    }
    ++row_;
    const std::int64_t id = rows_->integer();
    message.time = rows_->integer();
    message.data = rows_->bytes();
    const auto known = std::find_if(topic_of_.begin(), topic_of_.end(),
                                    [&](const auto& topic) { return topic.first == id; });
    if (known == topic_of_.end()) {
      report_.count(kStranger, row_);
      continue;
    }
    message.topic = known->second;
    if (message.data.starts_with(kZstd)) {  // plain CDR begins with a zero
      if (!unpack(ChunkPacking::zstd, message.data, kLargestMessage, unpacked_)) {
        report_.count(kBadPacked, row_);
        continue;
      }
      message.data = unpacked_;
    }
    return true;
  }
  rows_.reset();
  return false;
}

/// Only the list `relative_file_paths` matters; it is written by a program, one file a line.
std::vector<std::filesystem::path> ros2_bag_files(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  std::ifstream in(folder / "metadata.yaml");
  std::string line;
  bool inside = false;
  while (std::getline(in, line)) {
    const std::size_t begin = std::min(line.find_first_not_of(" \t"), line.size());
    const std::string_view text = std::string_view(line).substr(begin);
    if (text.starts_with("relative_file_paths:")) {
      inside = true;
    } else if (inside && text.starts_with("- ")) {
      const std::filesystem::path name = plain_scalar(text.substr(2));
      if (name.extension() == ".zstd")
        throw Error("a packed bag; unpack its files first: zstd -d " + name.string());
      // Old versions wrote the folder's own name before it.
      files.push_back(is_file(folder / name) ? folder / name : folder / name.filename());
    } else {
      inside = false;
    }
  }
  if (files.empty() && in.eof() && is_file(folder / "metadata.yaml"))
    throw Error("metadata.yaml lists no files (relative_file_paths)");
  return files;
}

void ChainedLogs::adopt_topics() {
  for (std::size_t i = topic_of_.size(); i < log_->topics().size(); ++i) {
    const Topic& topic = log_->topics()[i];
    topic_of_.push_back(topic_index(topic.name, topic.type, topic.encoding));
  }
}

bool ChainedLogs::next(Message& message) {
  for (;;) {
    if (!log_) {
      if (at_ == open_.size()) return false;
      log_ = open_[at_++](depth_);
      topic_of_.clear();
    }
    const bool more = log_->next(message);
    adopt_topics();
    if (more) {
      message.topic = topic_of_[message.topic];
      return true;
    }
    for (const auto& [what, entry] : log_->report().entries()) report_.add(what, entry);
    log_.reset();
  }
}

}  // namespace majak::io
