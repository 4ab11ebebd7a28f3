// SPDX-License-Identifier: Apache-2.0
#include "majak/core/options.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace majak {
namespace {

struct Sample {
  bool flag = true;
  int count = 3;
  double size = 0.5;
};

void describe(OptionFields& f, Sample& o) {
  f.add("sample.flag", o.flag, {"", "on or off"});
  f.add("sample.count", o.count, {"1", "how many", 1, 10});
  f.add("sample.size", o.size, {"m", "how large", 0});
}

TEST(OptionFields, KeepOrderNamesAndRanges) {
  Sample sample;
  OptionFields fields;
  describe(fields, sample);
  ASSERT_EQ(fields.list.size(), 3U);
  EXPECT_EQ(fields.list[0].name, "sample.flag");
  EXPECT_EQ(fields.list[1].name, "sample.count");
  EXPECT_EQ(fields.list[2].name, "sample.size");
  EXPECT_EQ(fields.list[1].info.min, 1);
  EXPECT_EQ(fields.list[1].info.max, 10);
  EXPECT_EQ(fields.list[2].info.unit, std::string("m"));
  EXPECT_EQ(fields.list[2].info.min, 0);
  EXPECT_TRUE(std::isinf(fields.list[2].info.max));
  EXPECT_TRUE(std::isinf(fields.list[0].info.min));
}

TEST(OptionFields, ReadAndWriteTheStructItself) {
  Sample sample;
  OptionFields fields;
  describe(fields, sample);
  EXPECT_EQ(*std::get<bool*>(fields.list[0].value), true);
  EXPECT_EQ(*std::get<int*>(fields.list[1].value), 3);
  EXPECT_EQ(*std::get<double*>(fields.list[2].value), 0.5);
  *std::get<bool*>(fields.list[0].value) = false;
  *std::get<int*>(fields.list[1].value) = 9;
  *std::get<double*>(fields.list[2].value) = 0.25;
  EXPECT_FALSE(sample.flag);
  EXPECT_EQ(sample.count, 9);
  EXPECT_EQ(sample.size, 0.25);
}

}  // namespace
}  // namespace majak
