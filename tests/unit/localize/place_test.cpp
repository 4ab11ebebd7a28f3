// SPDX-License-Identifier: Apache-2.0
#include "majak/localize/place.hpp"

#include <gtest/gtest.h>

#include "majak/core/error.hpp"
#include "tests/support/ascii_map.hpp"
#include "tests/support/ascii_room.hpp"

namespace majak::localize {
namespace {

std::string error_of(map::KnownMap known) {
  try {
    place_of(std::move(known));
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(Place, AMapThatNobodyCanBeOnIsRefused) {
  EXPECT_NE(error_of(fixture::ascii_map({"...", "..."})).find("no wall"), std::string::npos);
  EXPECT_NE(error_of(fixture::ascii_map({"###", "#  "})).find("no free space"), std::string::npos);
  EXPECT_NE(error_of({}).find("no wall"), std::string::npos);
  EXPECT_EQ(error_of(fixture::ascii_map({"###", "#.#"})), "");
}

TEST(Place, ARunsSurfacesLieWhereItsScansSawThem) {
  const fixture::AsciiRoom room({"########", "#......#", "#..a...#", "########"});
  Site site;
  site.scans.push_back({});
  site.scans[0].scan = room.scan(room.pose('a', 0.2), fixture::all_around());
  site.scans[0].estimate.T_map_robot = room.pose('a', 0.2);
  const auto place = place_of(site);
  ASSERT_GT(place->surfaces.surfels().size(), 50U);
  for (const map::Surfel& s : place->surfaces.surfels()) {
    const double to_wall = std::min(
        {std::abs(s.x - 0.5), std::abs(s.x - 3.5), std::abs(s.y - 0.5), std::abs(s.y - 1.5)});
    EXPECT_LT(to_wall, 1e-3);
  }
  EXPECT_EQ(place->known.at(room.place('a')), map::CellState::free);
}

}  // namespace
}  // namespace majak::localize
