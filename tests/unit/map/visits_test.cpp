// SPDX-License-Identifier: Apache-2.0
#include "majak/map/visits.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "majak/core/error.hpp"

namespace majak::map {
namespace {

Site at_times(const std::vector<double>& seconds) {
  Site site;
  for (const double t : seconds) {
    site.scans.emplace_back();
    site.scans.back().scan.time = from_seconds(t);
    site.scans.back().scan.ranges = {1};
  }
  return site;
}

TEST(Visits, AGapBeginsAnother) {
  const Site site = at_times({0, 1, 2, 100, 101, 500});
  EXPECT_EQ(split_visits(site), (std::vector<Visit>{{0, 3}, {3, 5}, {5, 6}}));
  EXPECT_EQ(visit_maps(site, split_visits(site)).size(), 3U);
  EXPECT_TRUE(split_visits({}).empty());
}

// All scans, each once, in order, and no visit longer than asked.
TEST(Visits, LongOnesAreCutInEqualParts) {
  std::vector<double> times;
  for (int i = 0; i <= 1000; ++i) times.push_back(i);
  const auto visits = split_visits(at_times(times));
  ASSERT_EQ(visits.size(), 4U);
  std::size_t next = 0;
  for (const Visit& v : visits) {
    EXPECT_EQ(v.first, next);
    EXPECT_NEAR(static_cast<double>(v.last - v.first), 250, 1);
    next = v.last;
  }
  EXPECT_EQ(next, times.size());
  EXPECT_LE(split_visits(at_times(times), {.gap = 60, .longest = 10, .most = 7}).size(), 7U);
  EXPECT_THROW(split_visits(at_times(times), {.gap = -1, .longest = 300, .most = 24}), Error);
}

}  // namespace
}  // namespace majak::map
