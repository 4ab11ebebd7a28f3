// SPDX-License-Identifier: Apache-2.0
#include "majak/io/word_reader.hpp"

#include <cstring>
#include <utility>

#include "majak/io/number.hpp"

namespace majak::io {

namespace {
constexpr std::size_t kBlock = std::size_t{1} << 15;
}

WordReader::WordReader(std::unique_ptr<ByteStream> bytes)
    : bytes_(std::move(bytes)), buffer_(kBlock + 1) {}

bool WordReader::refill() {
  if (drained_) return false;
  std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
  end_ -= begin_;
  begin_ = 0;
  const std::size_t got = bytes_->read(buffer_.data() + end_, kBlock - end_);
  end_ += got;
  drained_ = got == 0;
  return got > 0;
}

std::string_view WordReader::word() {
  for (;; ++begin_) {  // to the first letter
    if (begin_ == end_ && !refill()) {
      at_end_ = true;
      return {};
    }
    if (!is_blank(buffer_[begin_])) break;
    line_ += buffer_[begin_] == '\n' ? 1 : 0;
  }
  std::size_t size = 1;
  for (; size < kLongestWord; ++size) {
    if (begin_ + size == end_ && !refill()) break;
    if (is_blank(buffer_[begin_ + size])) break;
  }
  if (begin_ + size == end_) buffer_[end_] = '\n';
  const std::string_view found(buffer_.data() + begin_, size);
  begin_ += size;
  return found;
}

bool WordReader::number(double& value) {
  const std::string_view text = word();
  if (text.empty()) return false;
  const char* const end = text.data() + text.size();
  // A cut word may have a digit behind it; no number is that long.
  return text.size() < kLongestWord && parse_decimal(text.data(), end, value) == end;
}

}  // namespace majak::io
