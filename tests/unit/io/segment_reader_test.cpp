// SPDX-License-Identifier: Apache-2.0
#include "majak/io/segment_reader.hpp"

#include <gtest/gtest.h>

#include "majak/core/error.hpp"
#include "majak/io/segment_files.hpp"

namespace majak::io {
namespace {

std::vector<map::Segment> some() {
  std::vector<map::Segment> walls(3);
  walls[0].a = {0, 0}, walls[0].b = {4.25, 0};
  walls[1].a = {4.25, 0}, walls[1].b = {4.25, -3.0001};
  walls[2].a = {-1e3, 7.5}, walls[2].b = {2, 8};
  return walls;
}

using WithZones = std::string (*)(std::span<const map::Segment>, const Zones&);
struct Format {
  const char* kind;
  std::string (*text)(std::span<const map::Segment>);
  WithZones with_zones;
};
class SegmentReader : public testing::TestWithParam<Format> {};

TEST_P(SegmentReader, ReadsWhatWasWritten) {
  const auto walls = some();
  const auto read = parse_segments(GetParam().text(walls), GetParam().kind, "f");
  ASSERT_EQ(read.size(), walls.size());
  for (std::size_t i = 0; i < walls.size(); ++i) {
    EXPECT_LT((read[i].a - walls[i].a).norm(), 1e-9);
    EXPECT_LT((read[i].b - walls[i].b).norm(), 1e-9);
  }
  EXPECT_THROW(parse_segments(GetParam().text({}), GetParam().kind, "f"), Error);
}

TEST_P(SegmentReader, TakesNoForbiddenZoneForAWall) {
  const Zones zones = {{{0, 0}, {1, 0}, {1, 2}}, {{5, 5}, {6, 5}, {6, 6}, {5, 6}}};
  const std::string text = GetParam().with_zones(some(), zones);
  EXPECT_GT(text.size(), GetParam().text(some()).size() + 40);
  const auto read = parse_segments(text, GetParam().kind, "f");
  ASSERT_EQ(read.size(), some().size());
  for (std::size_t i = 0; i < read.size(); ++i) EXPECT_LT((read[i].b - some()[i].b).norm(), 1e-9);
}

TEST_P(SegmentReader, SurvivesAnyTornText) {
  const std::string whole = GetParam().text(some());
  for (std::size_t n = 0; n < whole.size(); ++n) {
    const auto at_most = some().size();
    try {
      EXPECT_LE(parse_segments(whole.substr(0, n), GetParam().kind, "f").size(), at_most);
    } catch (const Error&) {
    }
  }
}
INSTANTIATE_TEST_SUITE_P(All, SegmentReader,
                         testing::Values(Format{".svg", segments_svg, segments_svg},
                                         Format{".dxf", segments_dxf, segments_dxf},
                                         Format{".geojson", segments_geojson, segments_geojson},
                                         Format{".wkt", segments_wkt, segments_wkt}));

TEST(SegmentReaderOfOthers, LinesOfSeveralPointsAndPolygons) {
  EXPECT_EQ(parse_segments("LINESTRING (0 0, 1 0, 1 1)", ".wkt", "f").size(), 2U);
  EXPECT_EQ(parse_segments("POLYGON Z ((0 0 5, 1 0 5, 1 1 5, 0 0 5))", ".wkt", "f").size(), 3U);
  const char* polygon =
      R"({"type":"Polygon","coordinates":[[[0,0],[2,0],[2,1],[0,0]],[[9,9],[8,9]]]})";
  const auto walls = parse_segments(polygon, ".geojson", "f");
  ASSERT_EQ(walls.size(), 4U) << "rings are not joined";
  EXPECT_EQ(walls[3].a, Vec2(9, 9));
  EXPECT_THROW(parse_segments(R"({"type":"Point","coordinates":[1,2]})", ".json", "f"), Error);
}

}  // namespace
}  // namespace majak::io
