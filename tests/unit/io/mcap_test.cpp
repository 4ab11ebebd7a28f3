// SPDX-License-Identifier: Apache-2.0
// MCAP as the specification has it: byte by byte, and whatever befalls the file.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <iterator>

#include "majak/core/error.hpp"
#include "majak/io/mcap_reader.hpp"
#include "majak/io/mcap_writer.hpp"
#include "ros_fixtures.hpp"

namespace majak::io {
namespace {

using testing::Heard;
using testing::is_prefix;
using testing::le;
using testing::sized;
using testing::Told;

const std::string kMagic("\x89MCAP0\r\n");

std::string record(int opcode, const std::string& content) {
  return le(static_cast<std::uint64_t>(opcode), 1) + le(content.size(), 8) + content;
}

/// The check sum of zlib, bit by bit.
std::uint32_t crc32_slowly(std::string_view bytes) {
  std::uint32_t crc = 0xffffffff;
  for (const char c : bytes) {
    crc ^= static_cast<unsigned char>(c);
    for (int i = 0; i < 8; ++i) crc = (crc >> 1) ^ ((crc & 1) != 0 ? 0xedb88320U : 0U);
  }
  return ~crc;
}

Heard hear(std::string bytes, Depth depth = Depth::messages) {
  McapReader reader(open_bytes_in_memory(std::move(bytes)).bytes, depth);
  return testing::hear(reader);
}

/// Three chunks, two channels of one schema and one of another.
std::string some_file(ChunkPacking packing) {
  std::string bytes;
  McapWriter writer([&](std::string_view more) { bytes += more; },
                    {.chunk_size = 250, .packing = packing});
  const auto scan = writer.add_channel(
      {"/scan", "cdr", "sensor_msgs/msg/LaserScan", "ros2msg", "float32 x\n", {{"a", "b"}}});
  const auto raw = writer.add_channel({.topic = "/raw", .encoding = "x-telegram"});
  writer.write(scan, 10, 9, "one");
  writer.write(raw, 20, 20, std::string(200, 'r'));
  const auto other = writer.add_channel(
      {"/scan2", "cdr", "sensor_msgs/msg/LaserScan", "ros2msg", "float32 x\n", {}});
  writer.write(scan, 15, 15, "two");
  writer.flush();
  writer.flush();
  writer.write(other, 30, 30, "");
  writer.close();
  writer.close();
  return bytes;
}

const std::vector<Told> kTold = {{"/scan", 10, "one"},
                                 {"/raw", 20, std::string(200, 'r')},
                                 {"/scan", 15, "two"},
                                 {"/scan2", 30, ""}};

TEST(McapWriter, FollowsTheSpecificationToTheByte) {
  // One message in one chunk with every index, laid out by hand from the tables of mcap.dev/spec.
  std::string bytes;
  McapWriter writer([&](std::string_view more) { bytes += more; }, {.profile = "", .library = ""});
  const auto id =
      writer.add_channel({"example", "a", "Example", "c", "\x04\x05\x06", {{"foo", "bar"}}});
  writer.write(id, 10, 2, 1, "\x01\x02\x03");
  writer.close();

  const std::string schema =
      record(3, le(1, 2) + sized("Example") + sized("c") + sized("\x04\x05\x06"));
  const std::string channel = record(
      4, le(1, 2) + le(1, 2) + sized("example") + sized("a") + sized(sized("foo") + sized("bar")));
  const std::string message =
      record(5, le(1, 2) + le(10, 4) + le(2, 8) + le(1, 8) + "\x01\x02\x03");
  const std::string records = schema + channel + message;
  EXPECT_EQ(records.size(), 115U);
  const std::string head = kMagic + record(1, sized("") + sized(""));
  EXPECT_EQ(head.size(), 25U);
  const std::string chunk =
      record(6, le(2, 8) + le(2, 8) + le(115, 8) + le(crc32_slowly(records), 4) + sized("") +
                    le(115, 8) + records);
  EXPECT_EQ(chunk.size(), 164U);
  const std::string index =
      record(7, le(1, 2) + sized(le(2, 8) + le(schema.size() + channel.size(), 8)));
  EXPECT_EQ(index.size(), 31U);
  const std::string data = head + chunk + index;
  const std::string end = record(15, le(crc32_slowly(data), 4));
  EXPECT_EQ(data.size() + end.size(), 233U);
  const std::string statistics =
      record(11, le(1, 8) + le(1, 2) + le(1, 4) + le(0, 4) + le(0, 4) + le(1, 4) + le(2, 8) +
                     le(2, 8) + sized(le(1, 2) + le(1, 8)));
  const std::string chunk_index =
      record(8, le(2, 8) + le(2, 8) + le(25, 8) + le(164, 8) + sized(le(1, 2) + le(189, 8)) +
                    le(31, 8) + sized("") + le(115, 8) + le(115, 8));
  const std::string offsets =
      record(14, le(3, 1) + le(233, 8) + le(34, 8)) +
      record(14, le(4, 1) + le(267, 8) + le(47, 8)) +
      record(14, le(11, 1) + le(314, 8) + le(statistics.size(), 8)) +
      record(14, le(8, 1) + le(314 + statistics.size(), 8) + le(chunk_index.size(), 8));
  const std::string summary = schema + channel + statistics + chunk_index + offsets;
  const std::string footer =
      "\x02" + le(20, 8) + le(233, 8) + le(233 + summary.size() - offsets.size(), 8);
  const std::string expected =
      data + end + summary + footer + le(crc32_slowly(summary + footer), 4) + kMagic;
  EXPECT_EQ(bytes, expected);
}

TEST(McapWriter, AnEmptyRecordingIsWhole) {
  std::string bytes;
  McapWriter writer([&](std::string_view more) { bytes += more; });
  writer.add_channel({.topic = "/never", .encoding = "cdr"});
  writer.close();
  const Heard heard = hear(bytes);
  EXPECT_TRUE(heard.messages.empty());
  EXPECT_TRUE(heard.report.empty());
  EXPECT_EQ(heard.topics.size(), 1U);
  EXPECT_TRUE(bytes.ends_with(kMagic));
}

TEST(McapWriter, WhatWasFlushedIsThereBeforeTheEnd) {
  std::string bytes;
  McapWriter writer([&](std::string_view more) { bytes += more; });
  const auto id = writer.add_channel({.topic = "/a", .encoding = "cdr"});
  writer.write(id, 1, 1, "kept");
  EXPECT_TRUE(hear(bytes).messages.empty());
  writer.flush();
  writer.write(id, 2, 2, "lost");
  const Heard heard = hear(bytes);
  EXPECT_EQ(heard.messages, (std::vector<Told>{{"/a", 1, "kept"}}));
  EXPECT_EQ(heard.noticed("not closed"), 1);
}

TEST(McapWriter, RefusesWhatTheFormatHasNoPlaceFor) {
  McapWriter writer([](std::string_view) {});
  EXPECT_THROW(writer.write(1, 0, 0, ""), Error);
  const auto id = writer.add_channel({.topic = "/a"});
  EXPECT_THROW(writer.write(0, 0, 0, ""), Error);
  EXPECT_THROW(writer.write(id, -1, 0, ""), Error);
  EXPECT_THROW(McapWriter([](std::string_view) {}, {.packing = ChunkPacking::bzip2}), Error);
}

class PackedMcap : public ::testing::TestWithParam<ChunkPacking> {};

TEST_P(PackedMcap, WhatIsWrittenIsRead) {
  const Heard heard = hear(some_file(GetParam()));
  EXPECT_EQ(heard.messages, kTold);
  EXPECT_TRUE(heard.report.empty());
  ASSERT_EQ(heard.topics.size(), 3U);
  EXPECT_EQ(heard.topics[0], (Topic{"/scan", "sensor_msgs/LaserScan", ros::Encoding::cdr}));
  EXPECT_EQ(heard.topics[1], (Topic{"/raw", "", std::nullopt}));
  EXPECT_EQ(hear(some_file(GetParam()), Depth::topics).topics, heard.topics);
  EXPECT_TRUE(hear(some_file(GetParam()), Depth::topics).messages.empty());
}

TEST_P(PackedMcap, CutOffAtEveryByteItKeepsWhatWasWhole) {
  const std::string whole = some_file(GetParam());
  std::size_t most = 0;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    if (size < kMagic.size()) {
      EXPECT_THROW(hear(whole.substr(0, size)), Error);
      continue;
    }
    const Heard heard = hear(whole.substr(0, size));
    ASSERT_TRUE(is_prefix(heard.messages, kTold)) << size;
    EXPECT_GE(heard.messages.size(), most) << size;
    most = heard.messages.size();
    EXPECT_EQ(heard.noticed("damaged"), 0) << size;
    EXPECT_EQ(heard.noticed("describe"), 0) << size;
  }
  EXPECT_EQ(most, kTold.size());
}

TEST_P(PackedMcap, NoDamagedByteChangesAMessageUnseen) {
  // The chunks carry a sum. Outside of them a byte may change a topic's name, no message.
  const std::string whole = some_file(GetParam());
  for (std::size_t at = kMagic.size(); at < whole.size(); ++at) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x21);
    const Heard heard = hear(damaged);
    for (const Told& message : heard.messages)
      EXPECT_NE(std::find(kTold.begin(), kTold.end(), message), kTold.end()) << at;
  }
}

INSTANTIATE_TEST_SUITE_P(Chunks, PackedMcap,
                         ::testing::Values(ChunkPacking::none, ChunkPacking::lz4,
                                           ChunkPacking::zstd));

TEST(McapReader, ReadsMessagesOutsideOfChunksAndPassesOverTheUnknown) {
  const std::string schema = record(3, le(1, 2) + sized("x/msg/Y") + sized("ros2msg") + sized(""));
  const std::string channel = record(
      4, le(7, 2) + le(1, 2) + sized("/t") + sized("cdr") + sized("") + "more of the future");
  const auto message = [](int id, std::uint64_t time, const char* data) {
    return record(
        5, le(static_cast<std::uint64_t>(id), 2) + le(0, 4) + le(time, 8) + le(time, 8) + data);
  };
  const std::string head = kMagic + record(1, sized("") + sized(""));
  const Heard heard =
      hear(head + schema + channel + record(9, "attachment") + message(7, 5, "a") +
           record(0x90, "?") + message(8, 6, "stranger") + message(7, ~std::uint64_t{0}, "late") +
           record(5, "short") + record(3, "") + record(4, "x") + channel + message(7, 7, "b") +
           record(15, le(0, 4)) + message(7, 8, "behind the end"));
  EXPECT_EQ(heard.messages, (std::vector<Told>{{"/t", 5, "a"}, {"/t", 7, "b"}}));
  EXPECT_EQ(heard.topics, (std::vector<Topic>{{"/t", "x/Y", ros::Encoding::cdr}}));
  EXPECT_EQ(heard.noticed("does not describe"), 1);
  EXPECT_EQ(heard.noticed("2262"), 1);
  EXPECT_EQ(heard.noticed("damaged records"), 3);
}

TEST(McapReader, LeavesOutChunksThatAreDamaged) {
  const std::string head = kMagic + record(1, sized("") + sized(""));
  const std::string records =
      record(4, le(1, 2) + le(0, 2) + sized("/t") + sized("ros1") + sized("")) +
      record(5, le(1, 2) + le(0, 4) + le(1, 8) + le(1, 8) + "m");
  const auto chunk = [](std::string_view packing, std::uint64_t size, std::uint32_t crc,
                        const std::string& stored) {
    return record(6, le(0, 8) + le(0, 8) + le(size, 8) + le(crc, 4) + sized(packing) +
                         le(stored.size(), 8) + stored);
  };
  const auto noticed = [&](const std::string& bytes, const char* words) {
    const Heard heard = hear(head + bytes + chunk("", records.size(), 0, records));
    EXPECT_EQ(heard.messages, (std::vector<Told>{{"/t", 1, "m"}})) << words;
    return heard.noticed(words);
  };
  EXPECT_EQ(noticed(chunk("", records.size(), 1, records), "damaged chunks"), 1);
  EXPECT_EQ(noticed(chunk("", records.size() + 1, 0, records), "damaged chunks"), 1);
  EXPECT_EQ(noticed(chunk("lz4", records.size(), 0, records), "damaged chunks"), 1);
  EXPECT_EQ(noticed(chunk("zstd", 5, 0, pack(ChunkPacking::zstd, records)), "damaged chunks"), 1);
  EXPECT_EQ(noticed(chunk("snappy", 5, 0, records), "not known"), 1);
  EXPECT_EQ(noticed(chunk("zstd", ~std::uint64_t{0}, 0, "x"), "larger than"), 1);
  EXPECT_EQ(noticed(record(6, "short"), "damaged records"), 1);
  EXPECT_EQ(noticed(chunk("", 3, 0, "\x05\x01z"), "damaged chunks"), 1);
  // A length that lies reads to the end of the file, no further, and takes no memory for it.
  EXPECT_EQ(hear(head + "\x05" + le(~std::uint64_t{0}, 8) + "x").noticed("larger than"), 1);
}

TEST(McapReader, RefusesOtherFiles) {
  EXPECT_THROW(hear("nothing of this kind"), Error);
  EXPECT_TRUE(looks_like_mcap(some_file(ChunkPacking::none)));
  EXPECT_FALSE(looks_like_mcap("\x89MCAP"));
}

TEST(GrowingFile, HasEveryByteAtOnce) {
  const std::string path =
      ::testing::TempDir() + "/majak_growing_" + std::to_string(::getpid()) + ".mcap";
  const auto content = [&] {
    std::ifstream in(path, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  std::ofstream(path) << "what was there before, longer than what comes";
  {
    GrowingFile file(path);
    EXPECT_EQ(content(), "");
    file.write("one");
    EXPECT_EQ(content(), "one");
    file.write(std::string(100000, 'x'));
    file.sync();
    EXPECT_EQ(content().size(), 100003U);
  }
  EXPECT_EQ(content().size(), 100003U);
  std::filesystem::remove(path);
  EXPECT_THROW(GrowingFile("/nowhere/x.mcap"), Error);
  GrowingFile full("/dev/full");
  EXPECT_THROW(full.write("x"), Error);
}

}  // namespace
}  // namespace majak::io
