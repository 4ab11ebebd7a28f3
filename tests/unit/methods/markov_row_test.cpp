// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <string>

#include "majak/core/error.hpp"
#include "majak/methods/methods.hpp"

namespace majak::methods {
namespace {

TEST(MarkovRow, NeedsAMap) {
  try {
    method("markov").make({});
    FAIL();
  } catch (const Error& e) {
    EXPECT_STREQ(e.what(), "markov needs --map MAP");
  }
}

TEST(MarkovRow, KnowsNothingOfNoScans) {
  map::KnownMap map{.width = 20, .height = 20, .cells = {}};
  map.cells.assign(400, map::CellState::free);
  map.cells[0] = map::CellState::occupied;
  LocalizeOptions options;
  options.place = localize::place_of(map);
  EXPECT_TRUE(method("markov").make(options).finish().estimates.empty());
}

}  // namespace
}  // namespace majak::methods
