// SPDX-License-Identifier: Apache-2.0
// McapWriter: an MCAP file with everything that the specification (mcap.dev/spec) knows for it:
// chunks with their sums and message indexes, statistics, chunk index, summary offsets.
//
//   GrowingFile file("run.mcap");
//   McapWriter writer([&](std::string_view bytes) { file.write(bytes); });
//   const auto scans = writer.add_channel({.topic = "/scan", .encoding = "cdr", ...});
//   writer.write(scans, time, time, bytes);
//   writer.flush();   // as often as the caller can bear to lose what came since
//   writer.close();
//
// Bytes go out in whole chunks only, so that a recorder that is killed leaves a file which every
// reader opens, less its last chunk.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "majak/core/time.hpp"
#include "majak/io/mcap_records.hpp"
#include "majak/io/unpack.hpp"

namespace majak::io {

struct McapOptions {
  std::string profile = "ros2";
  std::string library = "majak";
  std::size_t chunk_size = std::size_t{1} << 20;  ///< bytes after which a chunk is closed
  ChunkPacking packing = ChunkPacking::none;      ///< none, lz4 or zstd
};

class McapWriter {
 public:
  using Sink = std::function<void(std::string_view)>;

  /// Writes the head of the file.
  explicit McapWriter(Sink sink, McapOptions options = {});

  /// Returns the number by which write() knows the channel. Channels of the same schema share it.
  std::uint16_t add_channel(const McapChannel& channel);

  /// Times in nanoseconds, not negative. Throws Error for a channel that was not added.
  void write(std::uint16_t channel, Time recorded, Time published, std::string_view data);
  /// The same with a sequence number; otherwise messages of a channel are counted from 0.
  void write(std::uint16_t channel, std::uint32_t sequence, Time recorded, Time published,
             std::string_view data);

  /// Closes the chunk and hands it to the sink; nothing when there is no message in it.
  void flush();
  /// The rest of the file; nothing may be written after it.
  void close();

  std::uint64_t messages() const { return messages_; }

 private:
  struct IndexEntry {
    std::uint64_t time, offset;
  };
  struct Span {
    std::uint64_t first = 0, last = 0;
    bool any = false;
    void add(std::uint64_t time);
  };

  void put(std::string_view bytes);
  std::uint16_t add_schema(const McapChannel& channel);
  std::string statistics() const;

  Sink sink_;
  McapOptions options_;
  std::uint64_t position_ = 0;
  std::uint32_t data_crc_ = 0;
  std::map<std::string, std::uint16_t> schema_ids_;
  std::vector<std::string> schemas_, channels_;  ///< as records
  std::vector<std::uint64_t> channel_messages_;
  std::string chunk_;
  std::map<std::uint16_t, std::vector<IndexEntry>> index_;  ///< of the chunk
  Span chunk_span_, span_;
  std::uint64_t messages_ = 0;
  std::uint32_t chunks_ = 0;
  std::string chunk_indexes_;  ///< as records
  bool closed_ = false;
};

/// A file that grows at its end: what write() took survives the program's death at once.
class GrowingFile {
 public:
  /// An empty file in the place of whatever was there. Throws Error (path, cause).
  explicit GrowingFile(const std::string& path);
  ~GrowingFile();
  GrowingFile(const GrowingFile&) = delete;
  GrowingFile& operator=(const GrowingFile&) = delete;

  void write(std::string_view bytes);
  /// Waits until the disk has it: what survives a loss of power.
  void sync();

 private:
  [[noreturn]] void fail(const char* doing) const;

  std::string path_;
  int descriptor_;
};

}  // namespace majak::io
