// SPDX-License-Identifier: Apache-2.0
#include "majak/io/ros1_bag.hpp"

#include <optional>
#include <utility>

#include "majak/core/error.hpp"
#include "majak/io/unpack.hpp"

namespace majak::io {

namespace {

enum Op : unsigned char {
  kMessage = 2,
  kBagHeader = 3,
  kIndex = 4,
  kChunk = 5,
  kChunkInfo = 6,
  kConnection = 7,
};

constexpr std::string_view kMagic = "#ROSBAG V2.0\n";
constexpr std::uint32_t kLongestHeader = 1U << 20;
constexpr std::size_t kLargestChunk = std::size_t{1} << 29;
constexpr std::uint32_t kIndexEntry = 12;  // bytes: sec, nsec, offset

const char* const kCutOff = "the bag ends inside its last record; kept what was whole";
const char* const kLost = "a damaged record; everything behind it is left out";
const char* const kBadChunk = "damaged chunks; left out";
const char* const kHugeChunk = "chunks larger than 512 MB; left out";
const char* const kBadRecord = "damaged records inside a chunk; the rest of the chunk is left out";
const char* const kStranger = "messages of a connection that the bag does not describe; left out";
const char* const kIndexSize = "index records that state a wrong length; mended";

std::uint32_t u32_of(std::string_view bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i)
    value |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[i])) << (8 * i);
  return value;
}

/// Cuts a piece behind its own length off the front; nothing when it is not all there.
std::optional<std::string_view> take_sized(std::string_view& bytes) {
  if (bytes.size() < 4) return std::nullopt;
  const std::uint32_t size = u32_of(bytes);
  if (size > bytes.size() - 4) return std::nullopt;
  const std::string_view piece = bytes.substr(4, size);
  bytes.remove_prefix(4 + std::size_t{size});
  return piece;
}

/// Calls use(name, value) for every field of a header; false when it is damaged.
template <class Use>
bool each_field(std::string_view header, Use use) {
  while (!header.empty()) {
    const auto field = take_sized(header);
    if (!field) return false;
    const std::size_t equal = field->find('=');
    if (equal == std::string_view::npos) return false;
    use(field->substr(0, equal), field->substr(equal + 1));
  }
  return true;
}

[[noreturn]] void refuse(std::string_view head) {
  const auto space = head.find(" V");
  if (!looks_like_ros1_bag(head) || space == std::string_view::npos) throw Error("no ROS bag");
  const std::string_view version = head.substr(space + 2, 3);
  if (version.starts_with("1."))
    throw Error("a ROS bag of the old format " + std::string(version) +
                "; convert it where ROS 1 is installed: rosbag fix OLD.bag NEW.bag" +
                (version == "1.2" ? "" : " (after rosbag reindex OLD.bag)"));
  throw Error("a ROS bag of format " + std::string(version) + "; only 2.0 is known");
}

}  // namespace

struct Ros1Bag::Record {
  unsigned char op = 0;
  std::optional<std::uint32_t> connection, count, size, seconds, nanoseconds;
  std::uint32_t data_size = 0;
  std::string_view topic, compression, data;

  /// Reads the header; false when it is damaged.
  bool parse(std::string_view header) {
    const auto number = [](std::string_view value) -> std::optional<std::uint32_t> {
      if (value.size() != 4) return std::nullopt;
      return u32_of(value);
    };
    const bool sound = each_field(header, [&](std::string_view name, std::string_view value) {
      if (name == "op" && value.size() == 1) op = static_cast<unsigned char>(value[0]);
      if (name == "conn") connection = number(value);
      if (name == "count") count = number(value);
      if (name == "size") size = number(value);
      if (name == "topic") topic = value;
      if (name == "compression") compression = value;
      if (name == "encryptor" && !value.empty()) throw Error("an encrypted ROS bag");
      if (name == "time" && value.size() == 8) {
        seconds = u32_of(value);
        nanoseconds = u32_of(value.substr(4));
      }
    });
    return sound && op != 0;
  }

  Time time() const { return Time{*seconds} * kSecond + *nanoseconds; }
};

bool looks_like_ros1_bag(std::string_view head) {
  return head.starts_with("#ROSBAG V") || head.starts_with("#ROSRECORD V");
}

Ros1Bag::Ros1Bag(std::unique_ptr<ByteStream> bytes, Depth depth)
    : pieces_(std::move(bytes)), depth_(depth) {
  std::string head;
  pieces_.read(head, kMagic.size());
  if (head == kMagic) return;
  if (kMagic.starts_with(head)) throw Error("the bag ends before its first record");
  std::string rest;
  pieces_.read(rest, 8);
  refuse(head + rest);
}

/// The next record outside of chunks, its data still unread. False at the end.
bool Ros1Bag::read_record(Record& record) {
  std::string size;
  ++records_;
  if (!pieces_.read(size, 4)) {
    cut_off_ = !size.empty();
    return false;
  }
  const std::uint32_t header_size = u32_of(size);
  if (header_size > kLongestHeader) {
    report_.count(kLost, records_);
    return false;
  }
  if (!pieces_.read(header_, header_size) || !pieces_.read(size, 4)) {
    cut_off_ = true;
    return false;
  }
  record = {};
  record.data_size = u32_of(size);
  if (record.parse(header_)) return true;
  report_.count(kLost, records_);
  return false;
}

/// rosbag of 2010 wrote the length of another layout before its index; the count is right.
std::uint64_t Ros1Bag::mended_size(const Record& record) {
  if (record.op != kIndex || !record.count) return record.data_size;
  const std::uint64_t size = std::uint64_t{*record.count} * kIndexEntry;
  if (size != record.data_size) report_.count(kIndexSize, records_);
  return size;
}

void Ros1Bag::learn_connection(const Record& record) {
  if (!record.connection) return;
  std::string_view topic = record.topic, type;
  each_field(record.data, [&](std::string_view name, std::string_view value) {
    if (name == "type") type = value;
  });
  topic_of_[*record.connection] = topic_index(topic, type, ros::Encoding::ros1);
}

/// Messages become visible, connections are learned; false when there is nothing to give out.
bool Ros1Bag::take(const Record& record, Message& message) {
  if (record.op == kConnection) learn_connection(record);
  if (record.op != kMessage) return false;
  const auto known = record.connection ? topic_of_.find(*record.connection) : topic_of_.end();
  if (known == topic_of_.end() || !record.seconds) {
    report_.count(kStranger, records_);
    return false;
  }
  message = {known->second, record.time(), record.data};
  return true;
}

void Ros1Bag::open_chunk(const Record& record, bool whole) {
  const std::string_view packing = record.compression;
  if (packing == "none") {
    chunk_ = data_;
    return;
  }
  const bool bzip2 = packing == "bz2", known = bzip2 || packing == "lz4";
  const std::size_t limit = record.size.value_or(0);
  const bool sound =
      known && limit <= kLargestChunk &&
      unpack(bzip2 ? ChunkPacking::bzip2 : ChunkPacking::lz4, data_, limit, unpacked_);
  if (sound || (!whole && known)) {
    chunk_ = unpacked_;
  } else {
    report_.count(limit > kLargestChunk ? kHugeChunk : kBadChunk, records_);
  }
}

bool Ros1Bag::next_in_chunk(Message& message) {
  while (!chunk_.empty()) {
    const auto header = take_sized(chunk_);
    const auto data = header ? take_sized(chunk_) : std::nullopt;
    Record record;
    if (!data || !record.parse(*header)) {
      if (!cut_off_) report_.count(kBadRecord, records_);
      chunk_ = {};
      return false;
    }
    record.data = *data;
    if (take(record, message)) return true;
  }
  return false;
}

void Ros1Bag::finish() {
  if (finished_) return;
  finished_ = true;
  if (cut_off_) report_.count(kCutOff, records_);
  for (const auto& [what, entry] : pieces_.report().entries()) report_.add(what, entry);
}

bool Ros1Bag::next(Message& message) {
  Record record;
  while (!finished_) {
    if (next_in_chunk(message)) return true;
    if (cut_off_ || !read_record(record)) break;
    const std::uint64_t size = mended_size(record);
    const bool wanted =
        record.op == kConnection ||
        (depth_ == Depth::messages && (record.op == kMessage || record.op == kChunk));
    if (!wanted || (record.op == kChunk && size > kLargestChunk)) {
      if (wanted) report_.count(kHugeChunk, records_);
      cut_off_ = !pieces_.skip(size);
      continue;
    }
    cut_off_ = !pieces_.read(data_, size);
    if (record.op == kChunk) {
      open_chunk(record, !cut_off_);
      continue;
    }
    record.data = data_;
    if (!cut_off_ && take(record, message)) return true;
  }
  finish();
  return false;
}

}  // namespace majak::io
