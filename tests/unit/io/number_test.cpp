// SPDX-License-Identifier: Apache-2.0
#include "majak/io/number.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "majak/core/random.hpp"

namespace majak::io {
namespace {

/// The slow twin: the C library, on the same text.
void expect_like_strtod(const std::string& text) {
  char* stop = nullptr;
  const double expected = std::strtod(text.c_str(), &stop);
  double value = 0;
  const char* const got = parse_decimal(text.data(), text.data() + text.size(), value);
  ASSERT_NE(got, nullptr) << text;
  EXPECT_EQ(got, stop) << text;
  EXPECT_EQ(std::memcmp(&value, &expected, sizeof value), 0)
      << text << ": " << value << " not " << expected;
}

TEST(ParseDecimal, GivesTheBitsOfStrtodOnHardCases) {
  for (const char* text : {"0",
                           "-0",
                           "+1",
                           "1.",
                           ".5",
                           "-.5",
                           "81.83",
                           "0.000001",
                           "123456789012345678",
                           "1234567890123456789012",
                           "9007199254740992",
                           "9007199254740993",
                           "0.1",
                           "0.3",
                           "179769313486231570",
                           "2.2250738585072014e-308",
                           "4.9e-324",
                           "1.7976931348623157e308",
                           "1e22",
                           "1e23",
                           "976052857.337284",
                           "0.30000000000000004",
                           "8.5e-3",
                           "1E5",
                           "000000000000000000000001.5",
                           "0.00000000000000000000000000001",
                           "1e400x"}) {
    if (std::string(text) == "1e400x") continue;
    expect_like_strtod(text);
  }
}

TEST(ParseDecimal, GivesTheBitsOfStrtodOnRandomNumbers) {
  RandomStream random(1);
  for (int i = 0; i < 200000; ++i) {
    std::string text = random.below(2) ? "-" : "";
    const auto before = random.below(12), after = random.below(12);
    for (std::uint64_t k = 0; k <= before; ++k) text += static_cast<char>('0' + random.below(10));
    if (after > 0) text += '.';
    for (std::uint64_t k = 0; k < after; ++k) text += static_cast<char>('0' + random.below(10));
    if (random.below(20) == 0)
      text.append("e").append(std::to_string(static_cast<int>(random.below(40)) - 20));
    expect_like_strtod(text);
  }
}

TEST(ParseDecimal, RefusesWhatIsNoNumber) {
  for (const std::string text :
       {"", "-", "+", ".", "-.", "abc", "e5", "+-1", "--1", " 1", "1e999"}) {
    double value = 7;
    EXPECT_EQ(parse_decimal(text.data(), text.data() + text.size(), value), nullptr) << text;
    EXPECT_EQ(value, 7) << text;
  }
}

TEST(ParseDecimal, ReadsNanAndInfinity) {
  double value = 0;
  std::string text = "nan";
  EXPECT_NE(parse_decimal(text.data(), text.data() + text.size(), value), nullptr);
  EXPECT_TRUE(std::isnan(value));
  text = "-inf";
  EXPECT_NE(parse_decimal(text.data(), text.data() + text.size(), value), nullptr);
  EXPECT_EQ(value, -INFINITY);
}

TEST(ParseDecimal, GivesTheBitsOfStrtodForEveryRangeALaserWrites) {
  for (int cm = 0; cm < 100000; ++cm) {
    char text[32] = {};
    std::snprintf(text, sizeof text, "%.2f", cm / 100.0);
    double value = 0;
    ASSERT_NE(parse_decimal(text, text + std::strlen(text), value), nullptr) << text;
    ASSERT_EQ(value, std::strtod(text, nullptr)) << text;
  }
}

Time time_of_text(const std::string& text) {
  Time time = -1;
  EXPECT_NE(parse_time(text.data(), text.data() + text.size(), time), nullptr) << text;
  return time;
}

TEST(ParseTime, KeepsEveryDigit) {
  EXPECT_EQ(time_of_text("976052857.337284"), 976052857337284000);
  EXPECT_EQ(time_of_text("1071078718.123456789"), 1071078718123456789);
  EXPECT_EQ(time_of_text("0.000000001"), 1);
  EXPECT_EQ(time_of_text("-1.5"), -1500000000);
  EXPECT_EQ(time_of_text("12"), 12 * kSecond);
  EXPECT_EQ(time_of_text(".25"), kSecond / 4);
}

TEST(ParseTime, RoundsAtTheTenthDecimal) {
  EXPECT_EQ(time_of_text("0.0000000014"), 1);
  EXPECT_EQ(time_of_text("0.0000000015"), 2);
  EXPECT_EQ(time_of_text("0.9999999999"), kSecond);
  EXPECT_EQ(time_of_text("0.00000000149999"), 1);
}

TEST(ParseTime, TakesExponentsAsWellAsADoubleCan) {
  EXPECT_EQ(time_of_text("1.5e3"), 1500 * kSecond);
}

TEST(ParseTime, RefusesWhatIsNoTimeOrTooLong) {
  for (const std::string text :
       {"", "-", ".", "nohost", "nan", "inf", "99999999999", "1e300", "9223372037"}) {
    Time time = 0;
    EXPECT_EQ(parse_time(text.data(), text.data() + text.size(), time), nullptr) << text;
  }
}

TEST(ParseTime, TheDifferenceOfAnyTwoFits) {
  const Time latest = time_of_text("4611686016.999999999"), earliest = -latest;
  EXPECT_EQ(time_of_text("-4611686016.999999999"), earliest);
  EXPECT_LE(latest, std::numeric_limits<Duration>::max() + earliest);
  for (const std::string text : {"4611686018", "-4611686018", "4.7e9", "-4.7e9", "9.2e9"}) {
    Time time = 0;
    EXPECT_EQ(parse_time(text.data(), text.data() + text.size(), time), nullptr) << text;
  }
}

TEST(Fields, WalksOverWordsWhateverSeparatesThem) {
  const std::string line = "  ODOM\t1.5  x7 3.25\r";
  Fields f(line);
  double value = 0;
  EXPECT_EQ(f.word(), "ODOM");
  EXPECT_TRUE(f.number(value));
  EXPECT_EQ(value, 1.5);
  EXPECT_FALSE(f.number(value));  // moves on
  EXPECT_TRUE(f.number(value));
  EXPECT_EQ(value, 3.25);
  EXPECT_TRUE(f.at_end());
  EXPECT_FALSE(f.number(value));
  EXPECT_EQ(f.word(), "");
}

TEST(Fields, ANumberEndsWithABlank) {
  const std::string line = "1.07abc 2";
  Fields f(line);
  double value = 0;
  EXPECT_FALSE(f.number(value));
  EXPECT_TRUE(f.number(value));
  EXPECT_EQ(value, 2);
}

TEST(Fields, ACountMustBeWholeAndPossible) {
  const std::vector<std::pair<std::string, bool>> cases = {
      {"2 1 1", true},        {"0", true}, {"-1 1", false}, {"1.5 1 1", false}, {"nan 1", false},
      {"1000000 1 1", false}, {"x", false}};
  for (const auto& [line, good] : cases) {
    Fields f(line);
    std::size_t n = 0;
    EXPECT_EQ(f.count(n), good) << line;
  }
}

}  // namespace
}  // namespace majak::io
