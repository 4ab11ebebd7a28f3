// SPDX-License-Identifier: Apache-2.0
// LineReader: the lines of a byte stream in bounded memory. A line longer than the limit is passed
// over and counted, however long it is.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "majak/core/report.hpp"
#include "majak/io/byte_stream.hpp"

namespace majak::io {

class LineReader {
 public:
  static constexpr std::size_t kLongestLine = std::size_t{1} << 20;

  explicit LineReader(std::unique_ptr<ByteStream> bytes, std::size_t longest = kLongestLine);

  /// The next line without its end; valid until the next call. The byte behind it is '\n'.
  std::optional<std::string_view> next();
  /// Number of the line that next() returned last, from 1.
  std::int64_t line() const { return line_; }
  /// False when the file ended inside the line that next() returned last.
  bool terminated() const { return terminated_; }
  /// Lines passed over, and what befell the bytes below. Grows while reading.
  Report report() const;

 private:
  bool refill();
  bool pass_over_long_line();

  std::unique_ptr<ByteStream> bytes_;
  std::size_t longest_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0;  ///< first byte not yet given out
  std::size_t end_ = 0;    ///< one past the last byte that was read
  std::int64_t line_ = 0;
  bool terminated_ = true;
  bool at_end_ = false;
  Report own_;
};

}  // namespace majak::io
