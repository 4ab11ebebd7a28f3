// SPDX-License-Identifier: Apache-2.0
#include "majak/io/mcap_reader.hpp"

#include <zlib.h>

#include <optional>
#include <utility>

#include "majak/core/error.hpp"
#include "majak/io/mcap_format.hpp"
#include "majak/io/unpack.hpp"

namespace majak::io {

namespace {

constexpr std::uint64_t kLargestRecord = std::uint64_t{1} << 29;

const char* const kCutOff = "the file ends inside its last record; kept what was whole";
const char* const kNoEnd = "the recording was not closed; kept what was whole";
const char* const kHuge = "records larger than 512 MB; left out";
const char* const kBadChunk = "damaged chunks; left out";
const char* const kBadPacking = "chunks packed in a way that is not known; left out";
const char* const kBadRecord = "damaged records; left out";
const char* const kStranger = "messages of a channel that the file does not describe; left out";
const char* const kLate = "messages stamped after the year 2262; left out";

/// Fields of a record from left to right; after the first that is not all there, none is sound.
class Fields {
 public:
  explicit Fields(std::string_view bytes) : rest_(bytes) {}

  template <class T>
  T number() {
    const std::string_view bytes = take(sizeof(T));
    T value = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i)
      value = static_cast<T>(value | static_cast<T>(static_cast<unsigned char>(bytes[i])) << 8 * i);
    return value;
  }
  std::string_view text() { return take(number<std::uint32_t>()); }
  std::string_view rest() const { return rest_; }
  bool sound() const { return sound_; }

 private:
  std::string_view take(std::uint64_t size) {
    sound_ = sound_ && size <= rest_.size();
    if (!sound_) return {};
    const std::string_view bytes = rest_.substr(0, static_cast<std::size_t>(size));
    rest_.remove_prefix(bytes.size());
    return bytes;
  }

  std::string_view rest_;
  bool sound_ = true;
};

std::uint32_t crc_of(std::string_view bytes) {
  return static_cast<std::uint32_t>(
      crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

std::optional<ros::Encoding> encoding_of(std::string_view name) {
  if (name == "ros1") return ros::Encoding::ros1;
  if (name == "cdr") return ros::Encoding::cdr;
  return std::nullopt;
}

}  // namespace

bool looks_like_mcap(std::string_view head) { return head.starts_with(mcap::kMagic); }

McapReader::McapReader(std::unique_ptr<ByteStream> bytes, Depth depth)
    : pieces_(std::move(bytes)), depth_(depth) {
  std::string magic;
  pieces_.read(magic, mcap::kMagic.size());
  if (magic == mcap::kMagic) return;
  if (mcap::kMagic.starts_with(magic)) throw Error("the MCAP file ends before its first record");
  throw Error("no MCAP file");
}

void McapReader::read_schema(std::string_view content) {
  Fields fields(content);
  const auto id = fields.number<std::uint16_t>();
  const std::string_view name = fields.text();
  if (!fields.sound()) return report_.count(kBadRecord, records_);
  if (id != 0) schemas_[id] = name;
}

void McapReader::read_channel(std::string_view content) {
  Fields fields(content);
  const auto id = fields.number<std::uint16_t>(), schema = fields.number<std::uint16_t>();
  const std::string_view topic = fields.text(), encoding = fields.text();
  if (!fields.sound()) return report_.count(kBadRecord, records_);
  const auto type = schemas_.find(schema);
  topic_of_[id] = topic_index(topic, type == schemas_.end() ? std::string_view() : type->second,
                              encoding_of(encoding));
}

bool McapReader::read_message(std::string_view content, Message& message) {
  Fields fields(content);
  const auto channel = fields.number<std::uint16_t>();
  fields.number<std::uint32_t>();  // sequence
  const auto time = fields.number<std::uint64_t>();
  fields.number<std::uint64_t>();  // when it was published
  const auto known = topic_of_.find(channel);
  const char* const problem = !fields.sound()            ? kBadRecord
                              : known == topic_of_.end() ? kStranger
                              : (time >> 63) != 0        ? kLate
                                                         : nullptr;
  if (problem != nullptr) {
    report_.count(problem, records_);
    return false;
  }
  message = {known->second, static_cast<Time>(time), fields.rest()};
  return true;
}

bool McapReader::take(std::uint8_t opcode, std::string_view content, Message& message) {
  if (opcode == mcap::kSchema) read_schema(content);
  if (opcode == mcap::kChannel) read_channel(content);
  return opcode == mcap::kMessage && read_message(content, message);
}

/// A chunk that the end of the file cuts gives the records that are whole; its sum is not known.
void McapReader::open_chunk(std::string_view content, bool whole) {
  Fields fields(content);
  fields.number<std::uint64_t>();  // times of the first and the last message
  fields.number<std::uint64_t>();
  const auto size = fields.number<std::uint64_t>();
  const auto crc = fields.number<std::uint32_t>();
  const std::string_view packing = fields.text();
  const auto stored = fields.number<std::uint64_t>();
  if (!fields.sound()) return whole ? report_.count(kBadRecord, records_) : void();
  if (whole && stored > fields.rest().size()) return report_.count(kBadChunk, records_);
  if (size > kLargestRecord) return report_.count(kHuge, records_);
  const auto packed = fields.rest().substr(0, static_cast<std::size_t>(stored));
  const bool lz4 = packing == "lz4";
  if (packing.empty()) {
    chunk_ = packed;
  } else if (lz4 || packing == "zstd") {
    const auto kind = lz4 ? ChunkPacking::lz4 : ChunkPacking::zstd;
    const bool sound = unpack(kind, packed, static_cast<std::size_t>(size), unpacked_);
    if (whole && !sound) return report_.count(kBadChunk, records_);
    chunk_ = unpacked_;
  } else {
    return report_.count(kBadPacking, records_);
  }
  if (whole && (chunk_.size() != size || (crc != 0 && crc != crc_of(chunk_)))) {
    chunk_ = {};
    report_.count(kBadChunk, records_);
  }
}

bool McapReader::next_in_chunk(Message& message) {
  while (!chunk_.empty()) {
    Fields record(chunk_);
    const auto opcode = record.number<std::uint8_t>();
    const auto size = record.number<std::uint64_t>();
    if (!record.sound() || size > record.rest().size()) {
      if (!cut_off_) report_.count(kBadChunk, records_);
      chunk_ = {};
      return false;
    }
    const std::string_view content = record.rest().substr(0, static_cast<std::size_t>(size));
    chunk_.remove_prefix(static_cast<std::size_t>(content.data() + content.size() - chunk_.data()));
    if (take(opcode, content, message)) return true;
  }
  return false;
}

void McapReader::finish() {
  if (finished_) return;
  finished_ = true;
  if (cut_off_) report_.count(kCutOff, records_);
  for (const auto& [what, entry] : pieces_.report().entries()) report_.add(what, entry);
}

bool McapReader::next(Message& message) {
  std::string head;
  while (!finished_) {
    if (next_in_chunk(message)) return true;
    if (cut_off_) break;
    ++records_;
    if (!pieces_.read(head, 9)) {
      if (head.empty()) report_.count(kNoEnd);
      cut_off_ = !head.empty();
      break;
    }
    Fields fields(head);
    const auto opcode = fields.number<std::uint8_t>();
    const auto size = fields.number<std::uint64_t>();
    // Behind the end of the data stand copies of what was read already; only the list of topics
    // needs them.
    if (opcode == mcap::kFooter || (opcode == mcap::kDataEnd && depth_ == Depth::messages)) break;
    const bool deep = opcode == mcap::kMessage || opcode == mcap::kChunk;
    const bool wanted =
        opcode == mcap::kSchema || opcode == mcap::kChannel || (deep && depth_ == Depth::messages);
    if (!wanted || size > kLargestRecord) {
      if (wanted) report_.count(kHuge, records_);
      cut_off_ = !pieces_.skip(size);
      continue;
    }
    cut_off_ = !pieces_.read(data_, size);
    if (opcode == mcap::kChunk) {
      open_chunk(data_, !cut_off_);
    } else if (!cut_off_ && take(opcode, data_, message)) {
      return true;
    }
  }
  finish();
  return false;
}

}  // namespace majak::io
