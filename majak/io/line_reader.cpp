// SPDX-License-Identifier: Apache-2.0
#include "majak/io/line_reader.hpp"

#include <cstring>
#include <utility>

namespace majak::io {

namespace {

constexpr std::size_t kBlock = std::size_t{1} << 17;  // stays in the second-level cache
const char* const kTooLong = "lines longer than 1 MB; passed over";

const char* find_line_end(const char* from, std::size_t size) {
  return static_cast<const char*>(std::memchr(from, '\n', size));
}

}  // namespace

LineReader::LineReader(std::unique_ptr<ByteStream> bytes, std::size_t longest)
    : bytes_(std::move(bytes)), longest_(longest), buffer_(kBlock + 1) {}

/// Moves what is left to the front and reads behind it; one byte stays free for the line end.
bool LineReader::refill() {
  if (at_end_) return false;
  if (begin_ > 0) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
  }
  if (end_ + 1 == buffer_.size()) buffer_.resize(buffer_.size() * 2 - 1);
  const std::size_t got = bytes_->read(buffer_.data() + end_, buffer_.size() - 1 - end_);
  end_ += got;
  at_end_ = got == 0;
  return got > 0;
}

bool LineReader::pass_over_long_line() {
  own_.count(kTooLong, ++line_);
  for (;;) {
    if (const char* stop = find_line_end(buffer_.data() + begin_, end_ - begin_)) {
      begin_ = static_cast<std::size_t>(stop - buffer_.data()) + 1;
      return true;
    }
    begin_ = end_;
    if (!refill()) return false;
  }
}

std::optional<std::string_view> LineReader::next() {
  std::size_t searched = 0;
  for (;;) {
    char* const from = buffer_.data() + begin_;
    const std::size_t have = end_ - begin_;
    if (const char* stop = find_line_end(from + searched, have - searched)) {
      const auto size = static_cast<std::size_t>(stop - from);
      begin_ += size + 1;
      if (size > longest_) {
        own_.count(kTooLong, ++line_);
        searched = 0;
        continue;
      }
      ++line_;
      terminated_ = true;
      return std::string_view(from, size);
    }
    if (have > longest_) {
      searched = 0;
      if (!pass_over_long_line()) return std::nullopt;
      continue;
    }
    searched = have;
    if (refill()) continue;
    if (have == 0) return std::nullopt;
    char* const last = buffer_.data() + begin_;  // refill() may have moved it
    last[have] = '\n';
    begin_ = end_;
    ++line_;
    terminated_ = false;
    return std::string_view(last, have);
  }
}

Report LineReader::report() const {
  Report all = own_;
  for (const auto& [what, entry] : bytes_->report().entries()) all.add(what, entry);
  return all;
}

}  // namespace majak::io
