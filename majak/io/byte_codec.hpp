// SPDX-License-Identifier: Apache-2.0
// Little-endian bytes of the site file's records: fixed-width numbers, varints, ranges without
// loss.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "majak/core/pose2.hpp"

namespace majak::io {

class ByteWriter {
 public:
  explicit ByteWriter(std::string& out) : out_(out) {}
  void u8(std::uint8_t value) { out_.push_back(static_cast<char>(value)); }
  void u32(std::uint32_t value);
  void u64(std::uint64_t value);
  void f32(float value);  ///< all bits, also those of not-a-numbers
  void f64(double value);
  void varint(std::uint64_t value);  ///< 7 bits a byte, low first
  void pose(const Pose2& pose);
  void symmetric(const Mat3& matrix);  ///< 6 numbers when exactly symmetric, else 9

 private:
  std::string& out_;
};

/// Throws Error("...") without a position when the bytes end early or mean nothing.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : rest_(bytes) {}
  std::uint8_t u8();
  std::uint32_t u32();
  std::uint64_t u64();
  float f32();
  double f64();
  std::uint64_t varint();
  Pose2 pose();
  Mat3 symmetric();
  std::size_t left() const { return rest_.size(); }
  /// Nothing may be left.
  void expect_end() const;

 private:
  std::string_view take(std::size_t n);
  std::string_view rest_;
};

/// Ranges, bit by bit: as steps of whole centimetres or millimetres from beam to beam where all
/// of them are exactly that (one byte a beam, mostly), else as float32.
void write_ranges(ByteWriter& writer, const std::vector<float>& ranges);
std::vector<float> read_ranges(ByteReader& reader);

/// A running 64-bit check of content: any change inside one word changes it for certain, anything
/// else with the odds of 64 bits.
class ContentHash {
 public:
  void add(std::uint64_t word);
  void add(double value);  ///< -0 counts as 0, and every not-a-number as the same
  void add(std::string_view bytes);
  std::uint64_t value() const { return state_; }

 private:
  std::uint64_t state_ = 0x6d616a616b736974ULL;
};

}  // namespace majak::io
