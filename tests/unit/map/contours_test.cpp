// SPDX-License-Identifier: Apache-2.0
#include "majak/map/contours.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/support/ascii_map.hpp"

namespace majak::map {
namespace {

using fixture::ascii_map;

constexpr ContourOptions kShort{.min_length = 0};

std::vector<Segment> longer_than(double length, std::vector<Segment> segments) {
  std::erase_if(segments, [&](const Segment& s) { return s.length() < length; });
  return segments;
}

/// '#' where a segment runs, '.' elsewhere.
std::vector<std::string> picture(const CellMask& mask) {
  std::vector<std::string> lines;
  for (int y = mask.height - 1; y >= 0; --y) {
    std::string line;
    for (int x = 0; x < mask.width; ++x) line += mask.at(x, y) ? '#' : '.';
    lines.push_back(line);
  }
  return lines;
}

const std::vector<std::string> kRoom = {
    "##########", "#........#", "#........#", "#........#", "##########",
};

TEST(ContourSegments, OfARoomAreItsWalls) {
  const auto walls = longer_than(2, contour_segments(ascii_map(fixture::finer(kRoom, 5), 0.2)));
  ASSERT_EQ(walls.size(), 4U);
  double length = 0;
  for (const Segment& wall : walls) {
    length += wall.length();
    EXPECT_GT(wall.normal().dot(Vec2(5, 2.5) - wall.middle()), 0) << "the room is to the left";
    const bool flat = std::abs(wall.direction().y()) < 1e-9;
    const bool upright = std::abs(wall.direction().x()) < 1e-9;
    EXPECT_TRUE(flat || upright);
    if (flat) EXPECT_NEAR(std::abs(wall.middle().y() - 2.5), 1.6, 1e-9);
    if (upright) EXPECT_NEAR(std::abs(wall.middle().x() - 5), 4.1, 1e-9);
  }
  EXPECT_NEAR(length, 2 * (8 + 3), 8 * 0.2 + 1e-9);  // each but for its corners
}

TEST(ContourSegments, AWallBetweenTwoRoomsHasTwoSides) {
  const auto walls = longer_than(2, contour_segments(ascii_map({
                                        "......",
                                        "......",
                                        "######",
                                        "......",
                                        "......",
                                    })));
  ASSERT_EQ(walls.size(), 2U);
  EXPECT_NEAR(walls[0].direction().dot(walls[1].direction()), -1, 1e-9);
  for (const Segment& wall : walls) EXPECT_NEAR(wall.length(), 6, 1e-9);
}

TEST(ContourSegments, ADoorStaysOpen) {
  for (const Segment& s : contour_segments(ascii_map({
                                               "..........",
                                               "####..####",
                                               "..........",
                                           }),
                                           kShort))
    EXPECT_FALSE(std::min(s.a.x(), s.b.x()) < 4 && std::max(s.a.x(), s.b.x()) > 6);
}

TEST(ContourSegments, AreStraightAlongSlantedWalls) {
  KnownMap map = ascii_map(std::vector<std::string>(120, std::string(120, '.')), 0.05);
  for (const double turn : {0.0, 0.1, 0.5, 0.78, 1.2}) {
    for (int y = 0; y < 120; ++y)
      for (int x = 0; x < 120; ++x) {
        const Vec2 p = map.centre(x, y) - Vec2(3, 3);
        const double across = -std::sin(turn) * p.x() + std::cos(turn) * p.y();
        map.cells[map.index(x, y)] = across > 0 ? CellState::free : CellState::occupied;
      }
    const auto walls = longer_than(1, contour_segments(map));
    ASSERT_EQ(walls.size(), 1U) << turn;
    EXPECT_GT(walls[0].length(), 5.9);
    EXPECT_NEAR(
        std::abs(std::sin(std::atan2(walls[0].direction().y(), walls[0].direction().x()) - turn)),
        0, 0.003);
  }
}

TEST(ContourSegments, KnowNothingOfWallsBesideTheUnknown) {
  EXPECT_TRUE(contour_segments(ascii_map({"    ", "####", "    "}), kShort).empty());
  EXPECT_TRUE(contour_segments(ascii_map({"....", "...."}), kShort).empty());
  EXPECT_TRUE(contour_segments(KnownMap{}, kShort).empty());
}

TEST(ContourSegments, ACellByItselfIsTooShort) {
  const KnownMap map = ascii_map({"...", ".#.", "..."}, 0.05);
  EXPECT_TRUE(contour_segments(map).empty());
}

TEST(ContourSegments, WallsThatTouchAtCornersHangTogether) {
  const auto walls = contour_segments(ascii_map({
                                          "......",
                                          "....##",
                                          "..##..",
                                          "##....",
                                          "......",
                                      }),
                                      kShort);
  EXPECT_GE(
      std::count_if(walls.begin(), walls.end(), [](const Segment& s) { return s.length() > 5; }),
      2);
}

TEST(CellsOf, AreWhatSegmentsRunThrough) {
  const KnownMap frame = ascii_map(std::vector<std::string>(4, std::string(6, '.')));
  Segment flat, steep, outside;
  flat.a = {0.5, 0.5}, flat.b = {4.5, 0.5};
  steep.a = {5.6, 3.5}, steep.b = {3.6, 1.5};
  outside.a = {-9, -9}, outside.b = {-5, 30};
  EXPECT_EQ(picture(cells_of({flat, steep, outside}, frame)), (std::vector<std::string>{
                                                                  ".....#",
                                                                  "....##",
                                                                  "...##.",
                                                                  "#####.",
                                                              }));
}

TEST(ConversionError, IsNothingForSegmentsOfTheCellsThemselves) {
  const KnownMap map = ascii_map(fixture::finer(kRoom, 5), 0.2);
  const ConversionError error = conversion_error(map, contour_segments(map));
  EXPECT_EQ(error.missed, 0);
  EXPECT_EQ(error.added, 0);
}

TEST(ConversionError, CountsWhatIsMissingAndWhatIsMadeUp) {
  const KnownMap map = ascii_map(fixture::finer(kRoom, 5), 0.2);
  auto walls = contour_segments(map);
  const auto longest =
      std::max_element(walls.begin(), walls.end(),
                       [](const Segment& a, const Segment& b) { return a.length() < b.length(); });
  const double share = longest->length() / (2 * (8 + 3));
  Segment wrong = *longest;
  walls.erase(longest);
  EXPECT_NEAR(conversion_error(map, walls).missed, share, 0.03);
  wrong.a += 1.5 * wrong.normal(), wrong.b += 1.5 * wrong.normal();
  walls.push_back(wrong);
  EXPECT_NEAR(conversion_error(map, walls).added, share, 0.06);
}

}  // namespace
}  // namespace majak::map
