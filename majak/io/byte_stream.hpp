// SPDX-License-Identifier: Apache-2.0
// ByteStream: bytes of a file, unpacked on the way. Plain, gzip (any number of members) and bzip2
// (any number of streams) are told apart by their first bytes. A packed file that ends early or is
// damaged gives what could be unpacked, and says so in its report.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>

#include "majak/core/report.hpp"

namespace majak::io {

class ByteStream {
 public:
  virtual ~ByteStream();
  /// Fills up to `size` bytes; 0 only at the end. Throws majak::Error when the medium fails.
  virtual std::size_t read(char* to, std::size_t size) = 0;
  /// What was noticed so far.
  const Report& report() const { return report_; }

 protected:
  Report report_;
};

/// How a stream is packed.
enum class Packing { none, gzip, bzip2 };

/// "" or ", gzip" or ", bzip2".
const char* packing_suffix(Packing packing);

struct OpenedBytes {
  std::unique_ptr<ByteStream> bytes;
  Packing packing = Packing::none;
};

/// A file by its path. Throws majak::Error when it cannot be opened.
OpenedBytes open_bytes(const std::filesystem::path& path);

/// The same from memory: what tests and fuzzers use.
OpenedBytes open_bytes_in_memory(std::string content);

/// `head` again, then the rest of `tail`: gives back what was read to look inside.
std::unique_ptr<ByteStream> prepend(std::string head, std::unique_ptr<ByteStream> tail);

}  // namespace majak::io
