// SPDX-License-Identifier: Apache-2.0
// PieceReader: pieces of known length out of a byte stream. Memory grows with the bytes that really
// come, so a length that lies costs nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "majak/io/byte_stream.hpp"

namespace majak::io {

class PieceReader {
 public:
  explicit PieceReader(std::unique_ptr<ByteStream> bytes);

  /// `size` bytes into `to`; false when the file ends before, `to` then has what there was.
  bool read(std::string& to, std::uint64_t size);
  /// Passes over `size` bytes; false when the file ends before.
  bool skip(std::uint64_t size);
  /// Bytes read so far.
  std::uint64_t position() const { return position_; }
  /// What befell the bytes below.
  const Report& report() const { return bytes_->report(); }

 private:
  std::size_t fill(char* to, std::size_t size);
  bool refill();

  std::unique_ptr<ByteStream> bytes_;
  std::string buffer_;
  std::size_t begin_ = 0, end_ = 0;
  std::uint64_t position_ = 0;
};

}  // namespace majak::io
