// SPDX-License-Identifier: Apache-2.0
#include "majak/match/range_offset.hpp"

#include <gtest/gtest.h>

#include "tests/support/ascii_room.hpp"

namespace majak::match {
namespace {

const fixture::AsciiRoom& room() {
  static const fixture::AsciiRoom r({"##########",  //
                                     "#........#",  //
                                     "#...a....#",  //
                                     "#........#",  //
                                     "##########"});
  return r;
}

map::SurfelMap map_of_room() {
  map::SurfelMap map;
  add_to(map, scan_points(room().scan(room().pose('a'), fixture::all_around(1440)), {}, true),
         room().pose('a'));
  return map;
}

RangeOffset found(double offset, const AlignOptions& options = {}) {
  Scan scan = room().scan(room().pose('a', 0.2), fixture::all_around());
  for (float& range : scan.ranges) range += static_cast<float>(offset);
  return range_offset(scan_points(scan, {}, false), map_of_room(), room().pose('a', 0.2),
                      Vec2::Zero(), options);
}

TEST(RangeOffset, FindsWhatWasAdded) {
  const double none = found(0).offset;
  EXPECT_NEAR(none, 0, 0.001);
  for (const double offset : {-0.02, -0.005, 0.005, 0.02})
    EXPECT_NEAR(found(offset).offset - none, offset, 0.001) << offset;
}

TEST(RangeOffset, InformationGoesWithTheSquareOfSigma) {
  AlignOptions half;
  half.sigma /= 2;
  EXPECT_GT(found(0).information, 100 / (0.02 * 0.02)) << "hundreds of returns";
  EXPECT_NEAR(found(0, half).information / found(0).information, 4, 1e-9);
}

TEST(RangeOffset, OneWallTellsNothing) {
  map::SurfelMap wall;
  ScanPoints points;
  for (float y = -1; y < 1; y += 0.05F) {
    wall.add(2, y, -1, 0);
    points.x.push_back(2.01F), points.y.push_back(y);
  }
  // The pose takes up what one wall shows; but for the rays that meet it askew.
  const double alone = range_offset(points, wall, {}, Vec2::Zero(), {}).information;
  EXPECT_LT(alone, 0.02 * static_cast<double>(points.size()) / (0.02 * 0.02));
}

}  // namespace
}  // namespace majak::match
