// SPDX-License-Identifier: Apache-2.0
#include "majak/io/beacon_map.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "majak/core/error.hpp"

namespace majak::io {
namespace {

std::string message_of(const std::string& text) {
  try {
    parse_beacon_map(text, "r.txt");
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(BeaconMap, ReadsNumbersPlacesAndNames) {
  const auto map = parse_beacon_map(
      "# reflectors of the hall\n"
      "\n"
      "7 1.5 -2.25 door\n"
      "  0\t3e1 4 # by the window\r\n"
      "12 0 0",
      "r.txt");
  ASSERT_EQ(map.beacons.size(), 3U);
  EXPECT_EQ(map.beacons[0].number, 7);
  EXPECT_EQ(map.beacons[0].p_map, Vec2(1.5, -2.25));
  EXPECT_EQ(map.beacons[0].name, "door");
  EXPECT_EQ(map.find(0)->p_map, Vec2(30, 4));
  EXPECT_EQ(map.find(0)->name, "");
  EXPECT_EQ(map.find(12)->p_map, Vec2(0, 0));
  EXPECT_EQ(map.find(5), nullptr);
}

TEST(BeaconMap, ErrorsSayTheLine) {
  EXPECT_EQ(message_of("1 0 0\n2 x 1\n"), "r.txt:2: a beacon is `number x y [name]`, metres");
  EXPECT_EQ(message_of("\n\n1 0\n"), "r.txt:3: a beacon is `number x y [name]`, metres");
  EXPECT_EQ(message_of("1 0 0 a b\n"),
            "r.txt:1: more than `number x y [name]`; a name is one word");
  EXPECT_EQ(message_of("1 0 0\n1 5 5\n"), "r.txt:2: number 1 is there twice");
  EXPECT_EQ(message_of("1 0 0\n2 0 0.0001\n"), "r.txt:2: beacon 2 stands where beacon 1 does");
  for (const char* number : {"-1", "1.5", "nan", "1e10"}) {
    EXPECT_EQ(message_of(std::string(number) + " 0 0\n"),
              "r.txt:1: a beacon's number is a whole number, 0 ... 1000000000");
  }
  for (const char* place : {"nan", "inf", "1e9"}) {
    EXPECT_EQ(message_of("1 0 " + std::string(place) + "\n"),
              "r.txt:1: a beacon's place is too far off");
  }
}

TEST(BeaconMap, WithoutBeaconsIsRefused) {
  EXPECT_EQ(message_of(""), "r.txt: no beacon; a line is `number x y [name]`");
  EXPECT_EQ(message_of("# nothing\n"), "r.txt: no beacon; a line is `number x y [name]`");
  EXPECT_THROW(read_beacon_map("/nonexistent/r.txt"), Error);
}

}  // namespace
}  // namespace majak::io
