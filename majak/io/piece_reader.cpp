// SPDX-License-Identifier: Apache-2.0
#include "majak/io/piece_reader.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

namespace majak::io {

namespace {
constexpr std::size_t kBlock = std::size_t{1} << 16;
constexpr std::size_t kGrowth = std::size_t{1} << 20;
}  // namespace

PieceReader::PieceReader(std::unique_ptr<ByteStream> bytes)
    : bytes_(std::move(bytes)), buffer_(kBlock, '\0') {}

bool PieceReader::refill() {
  begin_ = 0;
  end_ = bytes_->read(buffer_.data(), buffer_.size());
  return end_ > 0;
}

/// Up to `size` bytes, fewer only at the end of the file.
std::size_t PieceReader::fill(char* to, std::size_t size) {
  std::size_t have = 0;
  while (have < size) {
    if (begin_ == end_ && size - have >= kBlock) {  // large pieces go straight through
      const std::size_t n = bytes_->read(to + have, size - have);
      if (n == 0) break;
      have += n;
      continue;
    }
    if (begin_ == end_ && !refill()) break;
    const std::size_t n = std::min(size - have, end_ - begin_);
    std::memcpy(to + have, buffer_.data() + begin_, n);
    begin_ += n;
    have += n;
  }
  position_ += have;
  return have;
}

bool PieceReader::read(std::string& to, std::uint64_t size) {
  to.clear();
  while (to.size() < size) {
    const std::size_t have = to.size();
    const auto more =
        static_cast<std::size_t>(std::min<std::uint64_t>(size - have, std::max(kGrowth, have)));
    to.resize(have + more);
    const std::size_t n = fill(to.data() + have, more);
    if (n == more) continue;
    to.resize(have + n);
    return false;
  }
  return true;
}

bool PieceReader::skip(std::uint64_t size) {
  while (size > 0) {
    if (begin_ == end_ && !refill()) return false;
    const auto n = static_cast<std::size_t>(std::min<std::uint64_t>(size, end_ - begin_));
    begin_ += n;
    position_ += n;
    size -= n;
  }
  return true;
}

}  // namespace majak::io
