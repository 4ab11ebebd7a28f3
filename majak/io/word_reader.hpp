// SPDX-License-Identifier: Apache-2.0
// WordReader: the words of a byte stream whatever separates them, in bounded memory. For tables
// that do not keep to lines.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "majak/io/byte_stream.hpp"

namespace majak::io {

class WordReader {
 public:
  static constexpr std::size_t kLongestWord = 256;  ///< what is longer is cut, so it is no number

  explicit WordReader(std::unique_ptr<ByteStream> bytes);

  /// The next word, empty at the end; valid until the next call. A blank stands behind it.
  std::string_view word();
  /// The next word as a number. False at the end (then at_end()) or when it is none.
  bool number(double& value);
  bool at_end() const { return at_end_; }
  /// Line of the last word, from 1.
  std::int64_t line() const { return line_; }
  const Report& report() const { return bytes_->report(); }

 private:
  bool refill();

  std::unique_ptr<ByteStream> bytes_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0, end_ = 0;
  std::int64_t line_ = 1;
  bool drained_ = false;
  bool at_end_ = false;
};

}  // namespace majak::io
