// SPDX-License-Identifier: Apache-2.0
#include "majak/core/option_range.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace majak {
namespace {

struct Toy {
  double length = 1;  // m
  int count = 3;
  bool on = true;
};
void describe(OptionFields& fields, Toy& o) {
  fields.add("toy.length", o.length, {"m", "", 0.5, 2});
  fields.add("toy.count", o.count, {"1", "", 1, 5});
  fields.add("toy.on", o.on, {"", ""});
}

TEST(RequireInRange, BordersAreInside) {
  for (const double length : {0.5, 1.0, 2.0})
    for (const int count : {1, 5}) EXPECT_NO_THROW(require_in_range(Toy{length, count, false}));
}

TEST(RequireInRange, SaysWhichOptionIsNot) {
  for (const double length : {0.49, 2.01, -1.0, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_THAT(
        [&] {
          require_in_range(Toy{length, 3, true});
        },
        testing::ThrowsMessage<Error>("option toy.length is out of its range"));
  EXPECT_THAT(
      [] {
        require_in_range(Toy{1, 6, true});
      },
      testing::ThrowsMessage<Error>("option toy.count is out of its range"));
}

}  // namespace
}  // namespace majak
