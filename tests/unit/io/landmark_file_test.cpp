// SPDX-License-Identifier: Apache-2.0
#include "majak/io/landmark_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "majak/core/error.hpp"

namespace majak::io {
namespace {

std::string complaint(const std::string& text) {
  try {
    parse_landmarks(text, "trunks.txt");
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(LandmarkFile, LinesArePlaces) {
  const auto places = parse_landmarks(
      "# x y radius, m\n"
      "1.5 -2 0.2\n"
      "\n"
      "3e1 4 0.1 # gone from 60 s of the run on\n",
      "trunks.txt");
  ASSERT_EQ(places.size(), 2U);
  EXPECT_EQ(places[0], Vec2(1.5, -2));
  EXPECT_EQ(places[1], Vec2(30, 4));
}

TEST(LandmarkFile, SaysWhichLineIsWrong) {
  using testing::HasSubstr;
  EXPECT_THAT(complaint("1 2 0.1\n1 2\n"), HasSubstr("trunks.txt:2: a landmark is `x y radius`"));
  EXPECT_THAT(complaint("1 2 0.1 4\n"), HasSubstr("trunks.txt:1: "));
  EXPECT_THAT(complaint("a 2 0.1\n"), HasSubstr("trunks.txt:1: "));
  EXPECT_THAT(complaint("3e7 2 0.1\n"), HasSubstr("too far off"));
  EXPECT_THAT(complaint("nan 2 0.1\n"), HasSubstr("trunks.txt:1: "));
  EXPECT_THAT(complaint("# nothing\n"), HasSubstr("no landmark"));
  EXPECT_THROW(read_landmarks("no/such/file.txt"), Error);
}

}  // namespace
}  // namespace majak::io
