// SPDX-License-Identifier: Apache-2.0
// The two serialisations of ROS: packed (ROS 1, little endian) and CDR (ROS 2, aligned, either byte
// order), field by field. Lengths in the bytes are checked before anything is allocated for them.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/core/time.hpp"

namespace majak::io::ros {

enum class Encoding : std::uint8_t { ros1, cdr };

template <std::size_t Size>
using Bits = std::conditional_t<
    Size == 1, std::uint8_t,
    std::conditional_t<Size == 2, std::uint16_t,
                       std::conditional_t<Size == 4, std::uint32_t, std::uint64_t>>>;

template <class T>
inline constexpr bool kNumber = std::is_arithmetic_v<T>;

/// Bytes up to the next multiple of `size`; CDR counts from behind its four bytes of encapsulation.
inline constexpr std::size_t padding(std::size_t position, std::size_t size) {
  return (size - position % size) % size;
}

class Reader {
 public:
  static constexpr bool kReads = true;

  Reader(std::string_view bytes, Encoding encoding)
      : bytes_(bytes), aligned_(encoding == Encoding::cdr) {
    if (!aligned_) return;
    if (bytes_.size() < 4) throw Error("the message is shorter than its encapsulation");
    const bool plain = bytes_[0] == 0 && (bytes_[1] == 0 || bytes_[1] == 1);
    if (!plain) throw Error("the message is no plain CDR");
    big_endian_ = bytes_[1] == 0;
    bytes_.remove_prefix(4);
  }

  bool ros1() const { return !aligned_; }

  template <class T>
  requires kNumber<T>
  void operator()(T& value) {
    if (aligned_) at_ += padding(at_, sizeof(T));
    need(sizeof(T));
    Bits<sizeof(T)> bits = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      const std::size_t shift = 8 * (big_endian_ ? sizeof(T) - 1 - i : i);
      bits |= static_cast<Bits<sizeof(T)>>(
          static_cast<Bits<sizeof(T)>>(static_cast<unsigned char>(bytes_[at_ + i])) << shift);
    }
    at_ += sizeof(T);
    value = std::bit_cast<T>(bits);
  }

  template <class T, std::size_t N>
  void operator()(std::array<T, N>& values) {
    for (T& value : values) (*this)(value);
  }

  void operator()(std::string& text) {
    std::uint32_t size = 0;
    (*this)(size);
    need(size);
    text.assign(bytes_.substr(at_, size));
    at_ += size;
    if (aligned_ && !text.empty() && text.back() == '\0') text.pop_back();
  }

  template <class T>
  requires kNumber<T>
  void operator()(std::vector<T>& values) {
    std::uint32_t count = 0;
    (*this)(count);
    if (count > (bytes_.size() - at_) / sizeof(T)) throw_short();
    values.resize(count);
    for (T& value : values) (*this)(value);
  }

  template <class T, class Each>
  void list(std::vector<T>& values, Each each) {
    std::uint32_t count = 0;
    (*this)(count);
    values.clear();
    for (std::uint32_t i = 0; i < count; ++i) each(values.emplace_back());
  }

  void stamp(Time& time) {
    std::uint32_t seconds = 0, nanoseconds = 0;
    (*this)(seconds);
    (*this)(nanoseconds);
    const std::int64_t whole =
        aligned_ ? static_cast<std::int64_t>(static_cast<std::int32_t>(seconds)) : seconds;
    time = whole * kSecond + nanoseconds;
  }

 private:
  [[noreturn]] static void throw_short() { throw Error("the message ends early"); }
  void need(std::size_t size) const {
    if (at_ > bytes_.size() || size > bytes_.size() - at_) throw_short();
  }

  std::string_view bytes_;
  std::size_t at_ = 0;
  bool aligned_;
  bool big_endian_ = false;
};

class Writer {
 public:
  static constexpr bool kReads = false;

  explicit Writer(Encoding encoding) : aligned_(encoding == Encoding::cdr) {
    if (aligned_) bytes_.assign("\0\1\0\0", kStart);
  }

  bool ros1() const { return !aligned_; }
  std::string take() { return std::move(bytes_); }

  template <class T>
  requires kNumber<T>
  void operator()(const T& value) {
    if (aligned_) bytes_.append(padding(bytes_.size() - kStart, sizeof(T)), '\0');
    const auto bits = std::bit_cast<Bits<sizeof(T)>>(value);
    for (std::size_t i = 0; i < sizeof(T); ++i)
      bytes_.push_back(static_cast<char>(static_cast<unsigned char>(bits >> (8 * i))));
  }

  template <class T, std::size_t N>
  void operator()(const std::array<T, N>& values) {
    for (const T& value : values) (*this)(value);
  }

  void operator()(const std::string& text) {
    (*this)(count_of(text.size() + (aligned_ ? 1 : 0)));
    bytes_ += text;
    if (aligned_) bytes_.push_back('\0');
  }

  template <class T>
  requires kNumber<T>
  void operator()(const std::vector<T>& values) {
    (*this)(count_of(values.size()));
    for (const T value : values) (*this)(value);
  }

  template <class T, class Each>
  void list(const std::vector<T>& values, Each each) {
    (*this)(count_of(values.size()));
    for (const T& value : values) each(value);
  }

  void stamp(Time time) {
    Time seconds = time / kSecond, nanoseconds = time % kSecond;
    if (nanoseconds < 0) {
      --seconds;
      nanoseconds += kSecond;
    }
    const bool fits = aligned_ ? seconds == static_cast<std::int32_t>(seconds)
                               : seconds == static_cast<std::uint32_t>(seconds);
    if (!fits) throw Error("a stamp that ROS cannot write: it is too far from 1970");
    (*this)(static_cast<std::uint32_t>(seconds));
    (*this)(static_cast<std::uint32_t>(nanoseconds));
  }

 private:
  static constexpr std::size_t kStart = 4;  ///< bytes of encapsulation

  static std::uint32_t count_of(std::size_t size) {
    if (size > std::numeric_limits<std::uint32_t>::max())
      throw Error("a message longer than ROS can write");
    return static_cast<std::uint32_t>(size);
  }

  std::string bytes_;
  bool aligned_;
};

}  // namespace majak::io::ros
