// SPDX-License-Identifier: Apache-2.0
#include "majak/io/mcap_writer.hpp"

#include <fcntl.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>
#include <utility>

#include "majak/core/error.hpp"
#include "majak/io/mcap_format.hpp"

namespace majak::io {

using mcap::put_number, mcap::put_text, mcap::record;

namespace {

std::uint32_t crc_of(std::string_view bytes, std::uint32_t before = 0) {
  return static_cast<std::uint32_t>(
      crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

const char* name_of(ChunkPacking packing) {
  switch (packing) {
    case ChunkPacking::none:
      return "";
    case ChunkPacking::lz4:
      return "lz4";
    case ChunkPacking::zstd:
      return "zstd";
    case ChunkPacking::bzip2:
      break;
  }
  throw Error("MCAP chunks are packed with lz4 or zstd");
}

std::uint64_t unsigned_time(Time time) {
  if (time < 0) throw Error("MCAP has no times before 1970");
  return static_cast<std::uint64_t>(time);
}

}  // namespace

void McapWriter::Span::add(std::uint64_t time) {
  first = any ? std::min(first, time) : time;
  last = any ? std::max(last, time) : time;
  any = true;
}

McapWriter::McapWriter(Sink sink, McapOptions options)
    : sink_(std::move(sink)), options_(std::move(options)) {
  name_of(options_.packing);
  put(mcap::head(options_.profile, options_.library));
}

void McapWriter::put(std::string_view bytes) {
  sink_(bytes);
  position_ += bytes.size();
  data_crc_ = crc_of(bytes, data_crc_);
}

std::uint16_t McapWriter::add_schema(const McapChannel& channel) {
  if (channel.schema.empty()) return 0;
  std::string key;  // all that makes a schema
  put_text(key, channel.schema);
  put_text(key, channel.schema_encoding);
  put_text(key, channel.schema_text);
  const auto [known, is_new] =
      schema_ids_.emplace(key, static_cast<std::uint16_t>(schema_ids_.size() + 1));
  if (is_new) {
    schemas_.push_back(mcap::schema_record(known->second, channel));
    chunk_ += schemas_.back();
  }
  return known->second;
}

std::uint16_t McapWriter::add_channel(const McapChannel& channel) {
  if (channels_.size() == std::numeric_limits<std::uint16_t>::max())
    throw Error("MCAP has no more than 65535 channels");
  const std::uint16_t schema = add_schema(channel);
  const auto id = static_cast<std::uint16_t>(channels_.size() + 1);
  channels_.push_back(mcap::channel_record(id, schema, channel));
  channel_messages_.push_back(0);
  chunk_ += channels_.back();
  return id;
}

void McapWriter::write(std::uint16_t channel, Time recorded, Time published,
                       std::string_view data) {
  const bool known = channel != 0 && channel <= channel_messages_.size();
  write(channel, known ? static_cast<std::uint32_t>(channel_messages_[channel - 1U]) : 0, recorded,
        published, data);
}

void McapWriter::write(std::uint16_t channel, std::uint32_t sequence, Time recorded, Time published,
                       std::string_view data) {
  if (channel == 0 || channel > channel_messages_.size())
    throw Error("a message for a channel that the recording does not have");
  const std::uint64_t time = unsigned_time(recorded), published_at = unsigned_time(published);
  index_[channel].push_back({time, chunk_.size()});
  chunk_span_.add(time);
  span_.add(time);
  ++channel_messages_[channel - 1U];
  ++messages_;
  mcap::put_message(chunk_, channel, sequence, time, published_at, data);
  if (chunk_.size() >= options_.chunk_size) flush();
}

void McapWriter::flush() {
  if (index_.empty()) return;
  const std::string packed = pack(options_.packing, chunk_);
  std::string content;
  put_number(content, chunk_span_.first);
  put_number(content, chunk_span_.last);
  put_number(content, static_cast<std::uint64_t>(chunk_.size()));
  put_number(content, crc_of(chunk_));
  put_text(content, name_of(options_.packing));
  put_number(content, static_cast<std::uint64_t>(packed.size()));
  std::string bytes = record(mcap::kChunk, content + packed);
  const std::uint64_t length = bytes.size();

  std::string offsets;
  for (const auto& [channel, entries] : index_) {
    put_number(offsets, channel);
    put_number(offsets, position_ + bytes.size());
    std::string index, array;
    for (const IndexEntry& entry : entries) {
      put_number(array, entry.time);
      put_number(array, entry.offset);
    }
    put_number(index, channel);
    put_text(index, array);
    bytes += record(mcap::kMessageIndex, index);
  }

  std::string summary;
  put_number(summary, chunk_span_.first);
  put_number(summary, chunk_span_.last);
  put_number(summary, position_);
  put_number(summary, length);
  put_text(summary, offsets);
  put_number(summary, static_cast<std::uint64_t>(bytes.size() - length));
  put_text(summary, name_of(options_.packing));
  put_number(summary, static_cast<std::uint64_t>(packed.size()));
  put_number(summary, static_cast<std::uint64_t>(chunk_.size()));
  chunk_indexes_ += record(mcap::kChunkIndex, summary);
  ++chunks_;
  put(bytes);
  chunk_.clear();
  index_.clear();
  chunk_span_ = {};
}

std::string McapWriter::statistics() const {
  std::string content, counts;
  put_number(content, messages_);
  put_number(content, static_cast<std::uint16_t>(schemas_.size()));
  put_number(content, static_cast<std::uint32_t>(channels_.size()));
  put_number(content, std::uint32_t{0});  // attachments
  put_number(content, std::uint32_t{0});  // metadata
  put_number(content, chunks_);
  put_number(content, span_.first);
  put_number(content, span_.last);
  for (std::size_t i = 0; i < channel_messages_.size(); ++i) {
    if (channel_messages_[i] == 0) continue;
    put_number(counts, static_cast<std::uint16_t>(i + 1));
    put_number(counts, channel_messages_[i]);
  }
  put_text(content, counts);
  return record(mcap::kStatistics, content);
}

void McapWriter::close() {
  if (std::exchange(closed_, true)) return;
  flush();
  // Channels without a message stand in no chunk yet.
  if (!chunk_.empty()) put(chunk_);
  std::string data_end;
  put_number(data_end, data_crc_);
  put(record(mcap::kDataEnd, data_end));

  const std::uint64_t summary_start = position_;
  std::string summary, offsets;
  const auto group = [&](mcap::Opcode opcode, std::string_view records) {
    if (records.empty()) return;
    std::string content(1, static_cast<char>(opcode));
    put_number(content, summary_start + summary.size());
    put_number(content, static_cast<std::uint64_t>(records.size()));
    offsets += record(mcap::kSummaryOffset, content);
    summary += records;
  };
  const auto joined = [](const std::vector<std::string>& records) {
    std::string bytes;
    for (const std::string& r : records) bytes += r;
    return bytes;
  };
  group(mcap::kSchema, joined(schemas_));
  group(mcap::kChannel, joined(channels_));
  group(mcap::kStatistics, statistics());
  group(mcap::kChunkIndex, chunk_indexes_);

  std::string footer;
  put_number(footer, summary_start);
  put_number(footer, static_cast<std::uint64_t>(summary_start + summary.size()));
  put_number(footer, std::uint32_t{0});
  summary += offsets + record(mcap::kFooter, footer);
  const std::size_t before_crc = summary.size() - 4;
  const std::uint32_t crc = crc_of(std::string_view(summary).substr(0, before_crc));
  summary.resize(before_crc);
  put_number(summary, crc);
  put(summary + std::string(mcap::kMagic));
}

GrowingFile::GrowingFile(const std::string& path)
    : path_(path),
      descriptor_(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666)) {
  if (descriptor_ < 0) fail("cannot be made");
}

GrowingFile::~GrowingFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void GrowingFile::fail(const char* doing) const {
  throw Error(path_ + ": " + doing + ": " + std::strerror(errno));
}

void GrowingFile::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(descriptor_, bytes.data(), bytes.size());
    if (n < 0 && errno != EINTR) fail("cannot be written");
    if (n > 0) bytes.remove_prefix(static_cast<std::size_t>(n));
  }
}

void GrowingFile::sync() {
  // A pipe cannot be waited for, and needs not.
  if (::fdatasync(descriptor_) != 0 && errno != EINVAL && errno != EROFS)
    fail("cannot be written to the disk");
}

}  // namespace majak::io
