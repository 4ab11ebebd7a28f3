// SPDX-License-Identifier: Apache-2.0
#include "majak/io/byte_stream.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "log_fixtures.hpp"
#include "majak/core/error.hpp"

namespace majak::io {
namespace {

using testing::bzip2;
using testing::gzip;

struct Unpacked {
  std::string text;
  std::int64_t noticed = 0;
  Packing packing = Packing::none;
};

Unpacked unpack(std::string packed, std::size_t step = 7) {
  auto [bytes, packing] = open_bytes_in_memory(std::move(packed));
  Unpacked result;
  result.packing = packing;
  std::string block(step, '\0');
  while (const std::size_t n = bytes->read(block.data(), step)) result.text.append(block, 0, n);
  EXPECT_EQ(bytes->read(block.data(), step), 0u) << "the end stays the end";
  for (const auto& [what, entry] : bytes->report().entries()) result.noticed += entry.count;
  return result;
}

const std::string kText =
    "FLASER 2 1.00 2.00 0 0 0 0 0 0 1.5 host 0.5\nODOM 1 2 3 0 0 0 1.6 host 0.6\n";

TEST(ByteStream, GivesPlainBytesAsTheyAre) {
  for (const std::string& text :
       {std::string(), std::string("B"), std::string("BZh"), std::string("\x1f"), kText}) {
    const Unpacked got = unpack(text);
    EXPECT_EQ(got.text, text);
    EXPECT_EQ(got.packing, Packing::none);
    EXPECT_EQ(got.noticed, 0);
  }
}

TEST(ByteStream, UnpacksWhateverTheBlockSize) {
  std::string text;
  for (int i = 0; i < 3000; ++i) text += std::to_string(i * 7919) + " ";
  for (const std::size_t step : {std::size_t{1}, std::size_t{13}, std::size_t{1} << 20}) {
    EXPECT_EQ(unpack(gzip(text), step).text, text);
    EXPECT_EQ(unpack(bzip2(text), step).text, text);
  }
  EXPECT_EQ(unpack(gzip(text)).packing, Packing::gzip);
  EXPECT_EQ(unpack(bzip2(text)).packing, Packing::bzip2);
}

TEST(ByteStream, ReadsSeveralMembersInARow) {
  for (const auto& pack : {gzip, bzip2}) {
    const Unpacked got = unpack(pack("one ") + pack("") + pack("two ") + pack("three"));
    EXPECT_EQ(got.text, "one two three");
    EXPECT_EQ(got.noticed, 0);
  }
}

TEST(ByteStream, LeavesOutJunkBehindTheEndAndSaysSo) {
  for (const auto& pack : {gzip, bzip2}) {
    const Unpacked got = unpack(pack(kText) + "junk");
    EXPECT_EQ(got.text, kText);
    EXPECT_EQ(got.noticed, 1);
  }
}

TEST(ByteStream, EveryTruncationGivesABeginningAndSaysSo) {
  for (const auto& pack : {gzip, bzip2}) {
    const std::string whole = pack(kText + kText);
    for (std::size_t size = 4; size < whole.size(); ++size) {
      const Unpacked got = unpack(whole.substr(0, size));
      EXPECT_TRUE((kText + kText).starts_with(got.text)) << size;
      EXPECT_EQ(got.noticed, 1) << size;
    }
    EXPECT_EQ(unpack(whole).noticed, 0);
  }
}

TEST(ByteStream, EveryFlippedBitIsSurvived) {
  for (const auto& pack : {gzip, bzip2}) {
    const std::string whole = pack(kText);
    int noticed = 0;
    for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
      std::string damaged = whole;
      damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << (bit % 8)));
      noticed += unpack(damaged).noticed > 0 ? 1 : 0;
    }
    EXPECT_GT(noticed, static_cast<int>(6 * whole.size()));  // checksums; a gzip header has slack
  }
}

TEST(ByteStream, AMissingFileIsOneLine) {
  try {
    open_bytes("/nowhere/at/all.log");
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(std::string(e.what()),
              "/nowhere/at/all.log: cannot be opened: No such file or directory");
  }
}

TEST(ByteStream, AFolderIsNoFile) {
  EXPECT_THROW(open_bytes(std::filesystem::temp_directory_path()), Error);
}

TEST(ByteStream, PrependGivesTheHeadFirst) {
  auto stream = prepend("ab", open_bytes_in_memory("cd").bytes);
  char got[4] = {};
  std::size_t have = 0;
  while (const std::size_t n = stream->read(got + have, 4 - have)) have += n;
  EXPECT_EQ(std::string(got, have), "abcd");
}

}  // namespace
}  // namespace majak::io
