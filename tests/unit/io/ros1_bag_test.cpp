// SPDX-License-Identifier: Apache-2.0
#include "majak/io/ros1_bag.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "majak/core/error.hpp"
#include "ros_fixtures.hpp"

namespace majak::io {
namespace {

using testing::BagBuilder;
using testing::Heard;
using testing::Told;

Heard hear(std::string bytes, Depth depth = Depth::messages) {
  Ros1Bag bag(open_bytes_in_memory(std::move(bytes)).bytes, depth);
  return testing::hear(bag);
}

/// Two chunks of two topics, with an index behind the first.
std::string some_bag(std::string_view packing) {
  BagBuilder bag;
  bag.bytes +=
      BagBuilder::chunk(packing, BagBuilder::connection(0, "/scan", "sensor_msgs/LaserScan") +
                                     BagBuilder::message(0, 5 * kSecond + 7, "first") +
                                     BagBuilder::connection(1, "/od=om", "nav_msgs/Odometry") +
                                     BagBuilder::message(1, 6 * kSecond, "sec=ond"));
  bag.bytes += BagBuilder::index(0, 1, std::string(12, 'i'));
  bag.bytes += BagBuilder::index(1, 1, std::string(12, 'i'));
  bag.bytes += BagBuilder::chunk(packing, BagBuilder::message(0, 7 * kSecond, "") +
                                              BagBuilder::message(1, 8 * kSecond, "last"));
  bag.bytes += BagBuilder::connection(0, "/scan", "sensor_msgs/LaserScan");
  bag.bytes += BagBuilder::connection(1, "/od=om", "nav_msgs/Odometry");
  bag.bytes += BagBuilder::record(testing::op(6), "chunk info");
  return bag.bytes;
}

const std::vector<Told> kTold = {{"/scan", 5 * kSecond + 7, "first"},
                                 {"/od=om", 6 * kSecond, "sec=ond"},
                                 {"/scan", 7 * kSecond, ""},
                                 {"/od=om", 8 * kSecond, "last"}};

class PackedBag : public ::testing::TestWithParam<const char*> {};

TEST_P(PackedBag, GivesTheMessagesInTheOrderOfTheFile) {
  const Heard heard = hear(some_bag(GetParam()));
  EXPECT_EQ(heard.messages, kTold);
  ASSERT_EQ(heard.topics.size(), 2U);
  EXPECT_EQ(heard.topics[1], (Topic{"/od=om", "nav_msgs/Odometry", ros::Encoding::ros1}));
  EXPECT_TRUE(heard.report.empty());
}

TEST_P(PackedBag, TheTopicsAloneAreReadWithoutUnpacking) {
  const Heard heard = hear(some_bag(GetParam()), Depth::topics);
  EXPECT_TRUE(heard.messages.empty());
  EXPECT_EQ(heard.topics.size(), 2U);
}

TEST_P(PackedBag, CutOffAnywhereItKeepsWhatWasWhole) {
  const std::string whole = some_bag(GetParam());
  const std::size_t magic = std::string_view("#ROSBAG V2.0\n").size();
  std::size_t most = 0;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    if (size < magic) {
      EXPECT_THROW(hear(whole.substr(0, size)), Error) << size;
      continue;
    }
    const Heard heard = hear(whole.substr(0, size));
    EXPECT_TRUE(testing::is_prefix(heard.messages, kTold)) << size;
    EXPECT_GE(heard.messages.size(), most) << size;
    most = heard.messages.size();
    EXPECT_LE(heard.noticed("ends inside its last record"), 1) << size;
    EXPECT_EQ(heard.noticed("damaged"), 0) << size;
  }
  EXPECT_EQ(most, kTold.size());
}

TEST_P(PackedBag, AnyDamagedByteEndsInNothingWorse) {
  const std::string whole = some_bag(GetParam());
  for (std::size_t at = 13; at < whole.size(); ++at) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x41);
    try {
      EXPECT_LE(hear(damaged).messages.size(), kTold.size()) << at;
    } catch (const Error&) {
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Chunks, PackedBag, ::testing::Values("none", "bz2", "lz4"));

TEST(Ros1Bag, ADamagedChunkIsLeftOutAndTheNextIsRead) {
  for (const char* packing : {"bz2", "lz4"}) {
    std::string bytes = some_bag(packing);
    const std::size_t at = bytes.find(packing) + 120;  // inside the packed bytes
    bytes[at] = static_cast<char>(bytes[at] ^ 0x7f);
    const Heard heard = hear(bytes);
    // The connections of the second chunk stood in the first.
    EXPECT_EQ(heard.noticed("damaged chunks"), 1) << packing;
    EXPECT_EQ(heard.noticed("does not describe"), 2) << packing;
  }
  BagBuilder bag;
  bag.bytes += BagBuilder::chunk(
      "none", BagBuilder::connection(0, "/a", "x/Y") + BagBuilder::message(0, 1, "1") + "junk");
  bag.bytes += BagBuilder::chunk("snappy", "?");
  bag.bytes += BagBuilder::chunk("none", BagBuilder::message(0, 2, "2"));
  const Heard heard = hear(bag.bytes);
  EXPECT_EQ(heard.messages, (std::vector<Told>{{"/a", 1, "1"}, {"/a", 2, "2"}}));
  EXPECT_EQ(heard.noticed("damaged records inside a chunk"), 1);
  EXPECT_EQ(heard.noticed("damaged chunks"), 1);
}

TEST(Ros1Bag, AnIndexOfTheWrongLengthIsPassedByItsCount) {
  BagBuilder bag;
  bag.bytes += BagBuilder::chunk(
      "none", BagBuilder::connection(0, "/a", "x/Y") + BagBuilder::message(0, 1, "1"));
  std::string index = BagBuilder::index(0, 2, std::string(24, 'i'));
  index.replace(index.size() - 28, 4, testing::le(40, 4));
  bag.bytes += index + BagBuilder::chunk("none", BagBuilder::message(0, 2, "2"));
  const Heard heard = hear(bag.bytes);
  EXPECT_EQ(heard.messages.size(), 2U);
  EXPECT_EQ(heard.noticed("wrong length"), 1);
}

TEST(Ros1Bag, SizesThatLieAllocateNothing) {
  BagBuilder bag;
  std::string chunk = BagBuilder::chunk("bz2", "abc");
  chunk.replace(chunk.find("size=") + 5, 4, "\xff\xff\xff\xff");
  EXPECT_EQ(hear(bag.bytes + chunk).noticed("larger than"), 1);
  EXPECT_EQ(hear(bag.bytes + "\xff\xff\xff\xff more").noticed("a damaged record"), 1);
  const std::string header = testing::sized(testing::op(2)) + "\xff\xff\xff\xff" + "abc";
  EXPECT_EQ(hear(bag.bytes + header).noticed("ends inside"), 1);
}

TEST(Ros1Bag, RefusesOldBagsWithTheCommandThatConverts) {
  const auto error = [](std::string bytes) -> std::string {
    try {
      hear(std::move(bytes));
    } catch (const Error& e) {
      return e.what();
    }
    return "no error";
  };
  EXPECT_THAT(error("#ROSRECORD V1.2\n....."), ::testing::HasSubstr("old format 1.2"));
  EXPECT_THAT(error("#ROSRECORD V1.2\n....."), ::testing::HasSubstr("rosbag fix"));
  EXPECT_THAT(error("#ROSBAG V1.1\n........."), ::testing::HasSubstr("rosbag reindex"));
  EXPECT_THAT(error("#ROSBAG V3.0\n........."), ::testing::HasSubstr("format 3.0"));
  EXPECT_THAT(error("#ROSBAG V2"), ::testing::HasSubstr("ends before"));
  EXPECT_THAT(error("something else altogether"), ::testing::HasSubstr("no ROS bag"));
  EXPECT_THAT(error("#ROSBAG V2.0\n" +
                    BagBuilder::record(testing::op(3) + testing::field("encryptor", "aes"), "")),
              ::testing::HasSubstr("encrypted"));
}

// ---- bags of the data folder ----------------------------------------------------------------

Heard hear_bag(const char* name) {
  Ros1Bag bag(open_bytes(testing::data_folder() / "bags" / name).bytes);
  return testing::hear(bag);
}
bool data_absent() { return !std::filesystem::exists(testing::data_folder() / "bags"); }

TEST(Ros1BagData, TheSameBagThreeTimesGivesTheSameMessages) {
  if (data_absent()) GTEST_SKIP() << "the data folder is absent (set MAJAK_DATA)";
  // The unpacked one was written while recording, and 21 of its messages came late.
  const auto by_time = [](std::vector<Told> messages) {
    std::sort(messages.begin(), messages.end(), [](const Told& a, const Told& b) {
      return std::tie(std::get<1>(a), a) < std::tie(std::get<1>(b), b);
    });
    return messages;
  };
  const Heard plain = hear_bag("foxglove_example.bag");
  EXPECT_EQ(plain.messages.size(), 8647U);
  EXPECT_TRUE(plain.report.empty());
  for (const char* name : {"foxglove_example-bz2.bag", "foxglove_example-lz4.bag"}) {
    const Heard packed = hear_bag(name);
    EXPECT_TRUE(packed.messages == by_time(packed.messages)) << name;
    EXPECT_TRUE(packed.messages.size() == 8647U &&
                by_time(packed.messages) == by_time(plain.messages))
        << name;
    EXPECT_TRUE(packed.report.empty()) << name;
  }
}

TEST(Ros1BagData, OthersAreReadWhole) {
  if (data_absent()) GTEST_SKIP() << "the data folder is absent (set MAJAK_DATA)";
  const auto of_topic = [](const Heard& heard, std::string_view name) {
    return std::count_if(heard.messages.begin(), heard.messages.end(),
                         [&](const Told& m) { return std::get<0>(m) == name; });
  };
  const Heard lms = hear_bag("sick_rms_lms1xx.bag");
  EXPECT_EQ(of_topic(lms, "/sick_lms_1xx/scan"), 89);
  EXPECT_EQ(of_topic(lms, "/tf"), 17);
  EXPECT_TRUE(lms.report.empty());
  // A bag of 2010: two chunks whose index records state a wrong length.
  const Heard old = hear_bag("ccny_laser_scan_matcher_demo.bag");
  EXPECT_EQ(old.messages.size(), 360U);
  EXPECT_EQ(old.noticed("wrong length"), 2);
  EXPECT_THROW(hear_bag("ccny_laser_scan_sparsifier_demo.bag"), Error);
}

}  // namespace
}  // namespace majak::io
