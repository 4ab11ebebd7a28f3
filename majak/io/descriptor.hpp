// SPDX-License-Identifier: Apache-2.0
// Descriptor: a file, device or socket of the operating system, closed when it goes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "majak/core/time.hpp"

namespace majak::io {

class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor();

  int get() const { return fd_; }
  explicit operator bool() const { return fd_ >= 0; }

  enum class Ready { yes, no, gone };
  /// Waits until there is something to read. `gone`: the other side was unplugged or closed.
  Ready wait_readable(Duration timeout) const;
  /// Reads what is there, at most the span's size; 0 where nothing is. Throws Error, with `what` in
  /// it, when the other side has gone.
  std::size_t read(std::span<std::uint8_t> bytes, const char* what) const;
  /// Writes all, and waits for room where there is none, at most `patience` without progress.
  /// Throws Error where the other side has gone or takes nothing.
  void write(std::span<const std::uint8_t> bytes, const char* what,
             Duration patience = 2 * kSecond) const;

 private:
  int fd_ = -1;
};

}  // namespace majak::io
