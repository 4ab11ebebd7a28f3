// SPDX-License-Identifier: Apache-2.0
#include "majak/io/byte_codec.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <limits>

#include "majak/core/error.hpp"
#include "majak/core/event.hpp"
#include "majak/core/random.hpp"

namespace majak::io {
namespace {

TEST(ByteCodec, ReadsBackNumbersBitByBit) {
  std::string bytes;
  ByteWriter writer(bytes);
  const std::vector<std::uint64_t> words = {
      0, 1, 127, 128, 0xffffffff, std::numeric_limits<std::uint64_t>::max()};
  for (const std::uint64_t word : words) writer.varint(word), writer.u64(word);
  writer.f64(-0.0), writer.f32(1.5F), writer.u8(200), writer.u32(0x80000001U);
  ByteReader reader(bytes);
  for (const std::uint64_t word : words) {
    EXPECT_EQ(reader.varint(), word);
    EXPECT_EQ(reader.u64(), word);
  }
  EXPECT_TRUE(std::signbit(reader.f64()));
  EXPECT_EQ(reader.f32(), 1.5F);
  EXPECT_EQ(reader.u8(), 200);
  EXPECT_EQ(reader.u32(), 0x80000001U);
  EXPECT_NO_THROW(reader.expect_end());
}

TEST(ByteCodec, HasLittleEndianBytes) {
  std::string bytes;
  ByteWriter(bytes).u32(0x04030201);
  ByteWriter(bytes).varint(300);
  EXPECT_EQ(bytes, "\x01\x02\x03\x04\xac\x02");
}

TEST(ByteCodec, KeepsMatricesSymmetricOrNot) {
  Mat3 symmetric, other;
  symmetric << 1, 2, 3, 2, 4, 5, 3, 5, 6;
  other << 1, 2, 3, 4, 5, 6, 7, 8, 9;
  for (const auto& [matrix, size] : {std::pair(symmetric, 49U), std::pair(other, 73U)}) {
    std::string bytes;
    ByteWriter(bytes).symmetric(matrix);
    EXPECT_EQ(bytes.size(), size);
    EXPECT_EQ(ByteReader(bytes).symmetric(), matrix);
  }
}

TEST(ByteCodec, RefusesBytesThatEndEarlyOrGoOn) {
  std::string bytes;
  ByteWriter(bytes).u64(1);
  for (std::size_t n = 0; n < 8; ++n)
    EXPECT_THROW(ByteReader(std::string_view(bytes).substr(0, n)).u64(), Error);
  EXPECT_THROW(ByteReader(std::string(11, '\xff')).varint(), Error);
  EXPECT_THROW(ByteReader("x").expect_end(), Error);
}

std::string packed(const std::vector<float>& ranges) {
  std::string bytes;
  ByteWriter writer(bytes);
  write_ranges(writer, ranges);
  return bytes;
}

void expect_round_trip(const std::vector<float>& ranges) {
  const std::string bytes = packed(ranges);
  ByteReader reader(bytes);
  const std::vector<float> back = read_ranges(reader);
  ASSERT_EQ(back.size(), ranges.size());
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    EXPECT_EQ(std::bit_cast<std::uint32_t>(back[i]), std::bit_cast<std::uint32_t>(ranges[i]))
        << i << ' ' << ranges[i];
  }
  EXPECT_EQ(reader.left(), 0U);
}

TEST(Ranges, AreKeptBitByBit) {
  const float inf = std::numeric_limits<float>::infinity();
  expect_round_trip({});
  expect_round_trip({1.23F, 4.56F, 81.83F, 0.0F, kNoReturn, kInvalidRange});
  expect_round_trip({1.234F, 8.191F, kNoReturn});
  expect_round_trip({1.23456789F, 3e-39F, std::numeric_limits<float>::max(), -inf, -0.0F, -1.5F});
  expect_round_trip({std::bit_cast<float>(0x7fc12345U),
                     std::bit_cast<float>(0xffc00000U)});  // other not-a-numbers
  RandomStream random(11);
  for (int i = 0; i < 500; ++i) {
    std::vector<float> ranges(random.below(40));
    const double scale = i % 3 == 0 ? 100 : i % 3 == 1 ? 1000 : 12345.6;
    for (float& r : ranges) r = static_cast<float>(std::floor(random.uniform(-2e4, 2e5)) / scale);
    for (std::size_t k = 0; k < ranges.size(); k += 5)
      ranges[k] = k % 2 ? kInvalidRange : kNoReturn;
    expect_round_trip(ranges);
  }
}

TEST(Ranges, OfWholeCentimetresTakeAByteABeam) {
  std::vector<float> ranges;
  for (int i = 0; i < 180; ++i) ranges.push_back(static_cast<float>((300 + (i * i) % 50) / 100.0));
  EXPECT_LT(packed(ranges).size(), 190U);
  ranges[7] = 1.23456F;
  EXPECT_GT(packed(ranges).size(), 720U) << "one range that is no whole step is not rounded";
}

TEST(Ranges, NeverReadBeyondTheirBytes) {
  const std::string whole = packed({1.23F, 4.56F, kNoReturn, 7.0F});
  for (std::size_t n = 0; n < whole.size(); ++n) {
    ByteReader reader(std::string_view(whole).substr(0, n));
    EXPECT_THROW(read_ranges(reader), Error) << n;
  }
  std::string huge;  // a count that no memory holds
  ByteWriter(huge).varint(std::uint64_t{1} << 60);
  ByteWriter(huge).u8(0);
  ByteReader reader(huge);
  EXPECT_THROW(read_ranges(reader), Error);
  RandomStream random(12);
  for (int i = 0; i < 2000; ++i) {
    std::string noise(random.below(30), '\0');
    for (char& c : noise) c = static_cast<char>(random.below(256));
    ByteReader any(noise);
    try {
      EXPECT_LE(read_ranges(any).size(), noise.size());
    } catch (const Error&) {
    }
  }
}

TEST(ContentHash, NoticesEveryBitAndTheOrder) {
  const auto of = [](std::string_view bytes) {
    ContentHash hash;
    hash.add(bytes);
    return hash.value();
  };
  const std::string text = "where the robot was, and how sure that is";
  for (std::size_t i = 0; i < text.size() * 8; ++i) {
    std::string changed = text;
    changed[i / 8] = static_cast<char>(changed[i / 8] ^ (1 << i % 8));
    EXPECT_NE(of(changed), of(text)) << i;
  }
  EXPECT_NE(of("ab"), of("ba"));
  EXPECT_NE(of("a"), of(std::string_view("a\0", 2)));
  ContentHash one, two;
  one.add("ab"), one.add("c");
  two.add("a"), two.add("bc");
  EXPECT_NE(one.value(), two.value());
}

TEST(ContentHash, TakesZeroForMinusZeroAsSqliteDoes) {
  ContentHash a, b;
  a.add(0.0), b.add(-0.0);
  EXPECT_EQ(a.value(), b.value());
}

}  // namespace
}  // namespace majak::io
