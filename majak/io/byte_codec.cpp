// SPDX-License-Identifier: Apache-2.0
#include "majak/io/byte_codec.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "majak/core/error.hpp"
#include "majak/core/event.hpp"

namespace majak::io {

namespace {

enum RangeCode : std::uint8_t { kRaw = 0, kCentimetres = 1, kMillimetres = 2 };
enum Symbol : std::uint64_t { kIsNoReturn = 0, kIsInvalid = 1, kFirstStep = 2 };

constexpr float kMaxSteps = 1e6F;  // 10 km in centimetres; larger values go raw

double per_metre(RangeCode code) { return code == kCentimetres ? 100.0 : 1000.0; }

float metres(std::int64_t steps, double scale) {
  return static_cast<float>(static_cast<double>(steps) / scale);
}

std::uint64_t zigzag(std::int64_t value) {
  return (static_cast<std::uint64_t>(value) << 1) ^ static_cast<std::uint64_t>(value >> 63);
}

std::int64_t unzigzag(std::uint64_t value) {
  return static_cast<std::int64_t>(value >> 1) ^ -static_cast<std::int64_t>(value & 1);
}

bool is_canonical_invalid(float range) {
  return std::bit_cast<std::uint32_t>(range) == std::bit_cast<std::uint32_t>(kInvalidRange);
}

/// Whole steps of every range, if every range is one.
bool in_steps(const std::vector<float>& ranges, double scale, std::vector<std::int64_t>& steps) {
  steps.resize(ranges.size());
  const auto limit = static_cast<float>(kMaxSteps / scale);
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const float range = ranges[i];
    if (range == kNoReturn || is_canonical_invalid(range)) continue;
    if (!(std::abs(range) < limit)) return false;
    const double scaled = static_cast<double>(range) * scale;
    steps[i] = static_cast<std::int64_t>(scaled + (scaled < 0 ? -0.5 : 0.5));
    if (std::bit_cast<std::uint32_t>(metres(steps[i], scale)) !=
        std::bit_cast<std::uint32_t>(range))
      return false;
  }
  return true;
}

void write_steps(ByteWriter& writer, const std::vector<float>& ranges,
                 const std::vector<std::int64_t>& steps) {
  std::int64_t last = 0;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    if (ranges[i] == kNoReturn) {
      writer.varint(kIsNoReturn);
    } else if (std::isnan(ranges[i])) {
      writer.varint(kIsInvalid);
    } else {
      writer.varint(zigzag(steps[i] - last) + kFirstStep);
      last = steps[i];
    }
  }
}

}  // namespace

void ByteWriter::u32(std::uint32_t value) {
  for (int i = 0; i < 4; ++i, value >>= 8) u8(static_cast<std::uint8_t>(value));
}

void ByteWriter::u64(std::uint64_t value) {
  char bytes[8];
  for (char& byte : bytes) {
    byte = static_cast<char>(value & 0xff);
    value >>= 8;
  }
  out_.append(bytes, sizeof bytes);
}

void ByteWriter::f32(float value) { u32(std::bit_cast<std::uint32_t>(value)); }

void ByteWriter::f64(double value) { u64(std::bit_cast<std::uint64_t>(value)); }

void ByteWriter::varint(std::uint64_t value) {
  for (; value >= 0x80; value >>= 7) u8(static_cast<std::uint8_t>(value | 0x80));
  u8(static_cast<std::uint8_t>(value));
}

void ByteWriter::pose(const Pose2& pose) {
  f64(pose.x);
  f64(pose.y);
  f64(pose.theta);
}

void ByteWriter::symmetric(const Mat3& matrix) {
  bool exact = true;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < r; ++c) {
      exact &=
          std::bit_cast<std::uint64_t>(matrix(r, c)) == std::bit_cast<std::uint64_t>(matrix(c, r));
    }
  }
  u8(exact ? 1 : 0);
  for (int r = 0; r < 3; ++r) {
    for (int c = exact ? r : 0; c < 3; ++c) f64(matrix(r, c));
  }
}

std::string_view ByteReader::take(std::size_t n) {
  if (rest_.size() < n) throw Error("a record ends early");
  const std::string_view bytes = rest_.substr(0, n);
  rest_.remove_prefix(n);
  return bytes;
}

std::uint8_t ByteReader::u8() { return static_cast<std::uint8_t>(take(1)[0]); }

std::uint32_t ByteReader::u32() {
  std::uint32_t value = 0;
  const std::string_view bytes = take(4);
  for (std::size_t i = 4; i-- > 0;) value = value << 8 | static_cast<std::uint8_t>(bytes[i]);
  return value;
}

std::uint64_t ByteReader::u64() {
  std::uint64_t value = 0;
  const std::string_view bytes = take(8);
  for (std::size_t i = 8; i-- > 0;) value = value << 8 | static_cast<std::uint8_t>(bytes[i]);
  return value;
}

float ByteReader::f32() { return std::bit_cast<float>(u32()); }

double ByteReader::f64() { return std::bit_cast<double>(u64()); }

std::uint64_t ByteReader::varint() {
  std::uint64_t value = 0;
  for (int shift = 0; shift < 64; shift += 7) {
    const std::uint8_t byte = u8();
    value |= std::uint64_t{byte & 0x7fU} << shift;
    if (byte < 0x80) return value;
  }
  throw Error("a number has too many bytes");
}

Pose2 ByteReader::pose() {
  Pose2 pose;
  pose.x = f64();
  pose.y = f64();
  pose.theta = f64();
  return pose;
}

Mat3 ByteReader::symmetric() {
  const bool exact = u8() != 0;
  Mat3 matrix;
  for (int r = 0; r < 3; ++r) {
    for (int c = exact ? r : 0; c < 3; ++c) {
      matrix(r, c) = f64();
      if (exact) matrix(c, r) = matrix(r, c);
    }
  }
  return matrix;
}

void ByteReader::expect_end() const {
  if (!rest_.empty()) throw Error("a record is too long");
}

void write_ranges(ByteWriter& writer, const std::vector<float>& ranges) {
  writer.varint(ranges.size());
  std::vector<std::int64_t> steps;
  for (const RangeCode code : {kCentimetres, kMillimetres}) {
    if (!in_steps(ranges, per_metre(code), steps)) continue;
    writer.u8(code);
    write_steps(writer, ranges, steps);
    return;
  }
  writer.u8(kRaw);
  for (const float range : ranges) writer.f32(range);
}

std::vector<float> read_ranges(ByteReader& reader) {
  const std::uint64_t count = reader.varint();
  const std::uint8_t code = reader.u8();
  if (count > reader.left()) throw Error("a record ends early");  // a beam takes a byte at least
  if (code > kMillimetres) throw Error("a scan is packed in an unknown way");
  std::vector<float> ranges(static_cast<std::size_t>(count));
  std::int64_t last = 0;
  for (float& range : ranges) {
    if (code == kRaw) {
      range = reader.f32();
      continue;
    }
    const std::uint64_t symbol = reader.varint();
    if (symbol < kFirstStep) {
      range = symbol == kIsNoReturn ? kNoReturn : kInvalidRange;
      continue;
    }
    const std::int64_t change = unzigzag(symbol - kFirstStep);
    last = static_cast<std::int64_t>(static_cast<std::uint64_t>(last) +
                                     static_cast<std::uint64_t>(change));
    range = metres(last, per_metre(static_cast<RangeCode>(code)));
  }
  return ranges;
}

void ContentHash::add(std::uint64_t word) {
  state_ = std::rotl((state_ ^ word) * 0x9e3779b97f4a7c15ULL, 29);
}

void ContentHash::add(double value) {
  if (std::isnan(value)) value = std::numeric_limits<double>::quiet_NaN();
  add(std::bit_cast<std::uint64_t>(value + 0.0));
}

void ContentHash::add(std::string_view bytes) {
  add(std::uint64_t{bytes.size()});
  for (std::size_t i = 0; i < bytes.size(); i += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + i, std::min<std::size_t>(8, bytes.size() - i));
    add(word);
  }
}

}  // namespace majak::io
