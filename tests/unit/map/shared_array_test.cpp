// SPDX-License-Identifier: Apache-2.0
#include "majak/map/shared_array.hpp"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "majak/core/random.hpp"
#include "majak/map/surfel_map.hpp"

namespace majak::map {
namespace {

using Array = SharedArray<int, 3>;

template <class Copies>
double together(const Copies& copies) {
  double sum = 0;
  for (const auto& c : copies) sum += c.share_of_bytes();
  return sum;
}

TEST(SharedArray, AnyHistoryOfCopiesEqualsDeepCopies) {
  RandomStream r(1);
  std::vector<Array> shared(5);
  std::vector<std::vector<int>> deep(5);
  for (int step = 0; step < 4000; ++step) {
    const auto a = r.below(5), b = r.below(5);
    const int value = static_cast<int>(r.below(1000));
    switch (r.below(8)) {
      case 0:
        shared[a] = shared[b], deep[a] = deep[b];
        break;
      case 1: {
        const std::size_t size = r.below(40);
        shared[a].resize(size, value), deep[a].resize(size, value);
        break;
      }
      case 2:
      case 3:
        shared[a].push_back(value), deep[a].push_back(value);
        break;
      case 4:
        if (r.below(20) == 0) shared[a].clear(), deep[a].clear();
        break;
      default:
        if (deep[a].empty()) break;
        const std::size_t i = r.below(deep[a].size());
        shared[a].write(i) = value, deep[a][i] = value;
    }
    for (std::size_t k = 0; k < 5; ++k) {
      ASSERT_EQ(shared[k].size(), deep[k].size());
      for (std::size_t i = 0; i < deep[k].size(); ++i) ASSERT_EQ(shared[k][i], deep[k][i]);
    }
  }
}

TEST(SharedArray, CopiesNeedTheMemoryOfOneAndOfWhatDiffers) {
  Array one;
  one.resize(80000, 7);  // 10000 pages
  const double alone = one.share_of_bytes();
  EXPECT_EQ(alone, static_cast<double>(one.bytes()));
  std::vector<Array> copies(10, one);
  one.clear();
  one = Array();
  const double tables = 9.0 * 10000 * sizeof(void*);
  EXPECT_NEAR(together(copies), alone + tables, 1e-6 * alone);
  for (std::size_t i = 0; i < 800; ++i) copies[3].write(i) = 1;  // 100 pages
  EXPECT_NEAR(together(copies), alone + tables + 0.01 * (alone - 10000 * sizeof(void*)),
              1e-6 * alone);
}

TEST(SharedArray, CopiesBelongToAThreadEach) {
  Array one;
  one.resize(1000, 0);
  std::vector<Array> copies(8, one);
  std::vector<std::jthread> threads;
  for (int t = 0; t < 8; ++t)
    threads.emplace_back([&copies, t] {
      Array& mine = copies[static_cast<std::size_t>(t)];
      for (std::size_t i = 0; i < 1000; ++i) mine.write(i) += t;
    });
  threads.clear();
  for (int t = 0; t < 8; ++t)
    for (std::size_t i = 0; i < 1000; ++i) ASSERT_EQ(copies[static_cast<std::size_t>(t)][i], t);
  for (std::size_t i = 0; i < 1000; ++i) ASSERT_EQ(one[i], 0);
}

// A walk along a wall and back, seen a little differently by every seed.
template <class Map>
void draw_wall(Map& map, std::uint64_t seed, double from, double to, double y = 0) {
  RandomStream r(seed);
  for (double x = from; x < to; x += 0.03)
    map.add(static_cast<float>(x), static_cast<float>(y + r.uniform(-0.03, 0.03)), 0, 1);
}

template <class A, class B>
void expect_same(const A& a, const B& b) {
  ASSERT_EQ(a.surfels().size(), b.surfels().size());
  RandomStream r(9);
  std::vector<float> x(2000), y(2000);
  for (std::size_t i = 0; i < 2000; ++i) {
    x[i] = static_cast<float>(r.uniform(-2, 42)), y[i] = static_cast<float>(r.uniform(-0.5, 0.5));
  }
  std::vector<std::uint32_t> in_a(2000), in_b(2000);
  a.nearest(x.data(), y.data(), 2000, in_a.data());
  b.nearest(x.data(), y.data(), 2000, in_b.data());
  ASSERT_EQ(in_a, in_b);
  for (std::uint32_t i = 0; i < a.surfels().size(); ++i) {
    ASSERT_EQ(a.surfel(i).x, b.surfel(i).x);
    ASSERT_EQ(a.surfel(i).y, b.surfel(i).y);
    ASSERT_EQ(a.surfel(i).nx, b.surfel(i).nx);
  }
}

TEST(SharedSurfelMap, AFamilyOfMapsEqualsSurfelMapsOfTheirOwn) {
  std::vector<SharedSurfelMap> shared(4);
  std::vector<SurfelMap> own(4);
  RandomStream r(3);
  for (std::uint64_t step = 0; step < 60; ++step) {
    const auto child = r.below(4), parent = r.below(4);
    if (step % 5 == 4) shared[child] = shared[parent], own[child] = own[parent];
    const auto at = r.below(4);
    const double from = r.uniform(0, 38);
    draw_wall(shared[at], step, from, from + 2);
    draw_wall(own[at], step, from, from + 2);
  }
  for (std::size_t i = 0; i < 4; ++i) expect_same(shared[i], own[i]);
}

TEST(SharedSurfelMap, ChildrenOfOneNeedLittleMoreThanIt) {
  SharedSurfelMap parent;
  for (std::uint64_t wall = 0; wall < 20; ++wall)
    draw_wall(parent, wall, 0, 25, static_cast<double>(wall));
  const double alone = parent.share_of_bytes();
  std::vector<SharedSurfelMap> children(30, parent);
  parent = SharedSurfelMap();
  EXPECT_LT(together(children), 1.6 * alone);  // 30 tables of pages; deep copies: 30 times
  for (std::uint64_t i = 0; i < 30; ++i) draw_wall(children[i], i, 0, 2);
  EXPECT_LT(together(children), 2 * alone);
}

TEST(OlderSurfels, SeesWhatWasThereThenAndNothingElse) {
  SharedSurfelMap map;
  draw_wall(map, 1, 0, 10);
  const auto count = static_cast<std::uint32_t>(map.surfels().size());
  const SharedSurfelMap then = map;
  draw_wall(map, 2, 20, 30);  // far off: no cell has both
  const OlderSurfels older(map, count);
  RandomStream r(5);
  std::vector<float> x(3000), y(3000, 0.01F);
  for (float& v : x) v = static_cast<float>(r.uniform(-1, 31));
  std::vector<std::uint32_t> seen(3000), before(3000), now(3000);
  older.nearest(x.data(), y.data(), 3000, seen.data());
  then.nearest(x.data(), y.data(), 3000, before.data());
  map.nearest(x.data(), y.data(), 3000, now.data());
  EXPECT_EQ(seen, before);
  EXPECT_NE(seen, now);
  EXPECT_EQ(older.surfel(0).x, map.surfel(0).x);
}

}  // namespace
}  // namespace majak::map
