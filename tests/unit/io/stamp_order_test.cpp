// SPDX-License-Identifier: Apache-2.0
#include "majak/io/stamp_order.hpp"

#include <gtest/gtest.h>

#include "majak/core/random.hpp"

namespace majak::io {
namespace {

Event fix(Time time, double east = 0) { return GpsFix{time, east, 0}; }

std::vector<Time> through(StampOrder order, const std::vector<Time>& stamps) {
  std::vector<Time> out;
  const auto take = [&] {
    while (order.ready()) out.push_back(time_of(order.take()));
  };
  for (const Time time : stamps) {
    order.add(fix(time));
    take();
  }
  order.close();
  take();
  return out;
}

TEST(StampOrder, SortsWhatComesLateByLessThanTheWindow) {
  RandomStream random(4);
  std::vector<Time> stamps;
  for (int i = 0; i < 2000; ++i) stamps.push_back(i * 10 + static_cast<Time>(random.below(100)));
  std::vector<Time> sorted = stamps;
  std::sort(sorted.begin(), sorted.end());
  EXPECT_EQ(through(StampOrder(200), stamps), sorted);
  EXPECT_NE(through(StampOrder(20), stamps), sorted);
}

TEST(StampOrder, LosesNothingWhenAClockJumps) {
  EXPECT_EQ(through(StampOrder(10), {100, 105, 1000, 1, 2, 1001}),
            (std::vector<Time>{100, 105, 1, 2, 1000, 1001}));
  // One stamp of the far future makes all that follow go at once, in the order of the file.
  EXPECT_EQ(through(StampOrder(10), {1, 999999, 3, 2, 4}), (std::vector<Time>{1, 3, 2, 4, 999999}));
}

TEST(StampOrder, EqualStampsKeepTheOrderOfTheFile) {
  StampOrder order;
  for (int i = 0; i < 20; ++i) order.add(fix(5, i));
  order.close();
  for (int i = 0; i < 20; ++i) EXPECT_EQ(std::get<GpsFix>(order.take()).east, i);
  EXPECT_FALSE(order.ready());
}

TEST(StampOrder, HoldsNoMoreThanItMay) {
  StampOrder order(1000, 3);
  for (const Time time : {5, 4, 3}) order.add(fix(time));
  EXPECT_FALSE(order.ready());
  order.add(fix(6));
  ASSERT_TRUE(order.ready());
  EXPECT_EQ(time_of(order.take()), 3);
  EXPECT_FALSE(order.ready());
}

}  // namespace
}  // namespace majak::io
