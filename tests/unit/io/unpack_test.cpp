// SPDX-License-Identifier: Apache-2.0
#include "majak/io/unpack.hpp"

#include <gtest/gtest.h>

#include "log_fixtures.hpp"
#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/io/byte_stream.hpp"
#include "majak/io/piece_reader.hpp"

namespace majak::io {
namespace {

constexpr std::size_t kPlenty = std::size_t{1} << 24;

std::string some_bytes(std::size_t size) {
  RandomStream random(size);
  std::string bytes;
  while (bytes.size() < size) bytes.push_back(static_cast<char>('a' + random.below(4)));
  return bytes;
}

std::string packed(ChunkPacking packing, const std::string& plain) {
  return packing == ChunkPacking::bzip2 ? testing::bzip2(plain) : pack(packing, plain);
}

class Unpack : public ::testing::TestWithParam<ChunkPacking> {};

TEST_P(Unpack, GivesBackWhatWasPacked) {
  for (const std::size_t size : {0U, 1U, 1000U, 65535U, 65536U, 65537U, 300000U}) {
    const std::string plain = some_bytes(size), bytes = packed(GetParam(), plain);
    std::string out = "before";
    EXPECT_TRUE(unpack(GetParam(), bytes, size, out)) << size;
    EXPECT_EQ(out, plain);
    EXPECT_TRUE(unpack(GetParam(), bytes, kPlenty, out)) << size;
    EXPECT_EQ(out, plain);
  }
}

TEST_P(Unpack, MoreThanTheLimitIsNoSuccess) {
  const std::string plain = some_bytes(70000);
  std::string out;
  for (const std::size_t limit : {0U, 1U, 65536U, 69999U}) {
    EXPECT_FALSE(unpack(GetParam(), packed(GetParam(), plain), limit, out));
    EXPECT_LE(out.size(), limit);
    EXPECT_TRUE(plain.starts_with(out));
  }
}

TEST_P(Unpack, CutOffItGivesWhatCameBefore) {
  const std::string plain = some_bytes(3000), bytes = packed(GetParam(), plain);
  for (std::size_t size = 0; size < bytes.size(); size += 7) {
    std::string out;
    const bool all = unpack(GetParam(), bytes.substr(0, size), kPlenty, out);
    EXPECT_EQ(all, GetParam() == ChunkPacking::none) << size;
    EXPECT_TRUE(plain.starts_with(out)) << size;
  }
}

TEST_P(Unpack, DamageNeverLooksWhole) {
  if (GetParam() == ChunkPacking::none || GetParam() == ChunkPacking::zstd)
    return;  // no sum of their own: the recordings carry one
  const std::string plain = some_bytes(500), bytes = packed(GetParam(), plain);
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    std::string damaged = bytes, out;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    const bool all = unpack(GetParam(), damaged, kPlenty, out);
    EXPECT_FALSE(all && out != plain) << at;
  }
}

INSTANTIATE_TEST_SUITE_P(Packings, Unpack,
                         ::testing::Values(ChunkPacking::none, ChunkPacking::bzip2,
                                           ChunkPacking::lz4, ChunkPacking::zstd));

TEST(Unpack, NothingElseIsPacked) { EXPECT_THROW(pack(ChunkPacking::bzip2, "x"), Error); }

TEST(PieceReader, GivesPiecesAndWhatThereWas) {
  const std::string whole = some_bytes(300000);
  PieceReader pieces(open_bytes_in_memory(whole).bytes);
  std::string piece;
  std::size_t at = 0;
  for (const std::size_t size : {1U, 0U, 70000U, 3U, 65536U, 100000U}) {
    ASSERT_TRUE(pieces.read(piece, size));
    EXPECT_EQ(piece, whole.substr(at, size));
    at += size;
    EXPECT_TRUE(pieces.skip(5));
    at += 5;
    EXPECT_EQ(pieces.position(), at);
  }
  EXPECT_FALSE(pieces.read(piece, std::uint64_t{1} << 60));
  EXPECT_EQ(piece, whole.substr(at));
  EXPECT_EQ(pieces.position(), whole.size());
  EXPECT_FALSE(pieces.skip(1));
  EXPECT_TRUE(pieces.read(piece, 0));
}

TEST(Gzip, ReadsBackAsItWas) {
  for (const std::string& plain : {std::string(), std::string("a"), std::string(100000, 'x')}) {
    auto opened = open_bytes_in_memory(gzip(plain));
    std::string back, more(4096, ' ');
    while (const std::size_t n = opened.bytes->read(more.data(), more.size()))
      back.append(more, 0, n);
    EXPECT_EQ(back, plain);
  }
  EXPECT_EQ(gzip("same"), gzip("same"));
  EXPECT_LT(gzip(std::string(100000, 'x')).size(), 200U);
}

}  // namespace
}  // namespace majak::io
