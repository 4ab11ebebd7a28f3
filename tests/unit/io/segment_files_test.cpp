// SPDX-License-Identifier: Apache-2.0
#include "majak/io/segment_files.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

namespace majak::io {
namespace {

std::vector<map::Segment> two() {
  map::Segment wall;
  wall.a = {-1.25, 2}, wall.b = {3.75, 2};
  wall.covariance << 1e-4, 0, 0, 4e-6;
  wall.sigma_a = 0.03, wall.sigma_b = 0.04;
  wall.points = 50, wall.scans = 7;
  map::Segment slanted = wall;
  slanted.a = {-0.00001, 0.12345}, slanted.b = {1, -1};
  return {wall, slanted};
}

/// Groups of a DXF: code and value.
std::vector<std::pair<int, std::string>> groups_of(const std::string& dxf) {
  std::vector<std::pair<int, std::string>> groups;
  std::istringstream in(dxf);
  for (std::string code, value; std::getline(in, code) && std::getline(in, value);)
    groups.emplace_back(std::stoi(code), value);
  return groups;
}

TEST(SegmentFiles, SvgHasALineEachWithYDown) {
  EXPECT_EQ(segments_svg(two()),
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"7.0000cm\" height=\"5.0000cm\" "
            "viewBox=\"-2.2500 -3.0000 7.0000 5.0000\">\n"
            "<g stroke=\"black\" stroke-width=\"0.04\" stroke-linecap=\"round\">\n"
            "<line x1=\"-1.2500\" y1=\"-2.0000\" x2=\"3.7500\" y2=\"-2.0000\"/>\n"
            "<line x1=\"0.0000\" y1=\"-0.1235\" x2=\"1.0000\" y2=\"1.0000\"/>\n"
            "</g>\n</svg>\n");
}

TEST(SegmentFiles, DxfIsGroupsWithClosedSections) {
  const auto groups = groups_of(segments_dxf(two()));
  int open = 0, tables = 0, lines = 0;
  for (const auto& [code, value] : groups) {
    if (code != 0) continue;
    open += (value == "SECTION") - (value == "ENDSEC");
    tables += (value == "TABLE") - (value == "ENDTAB");
    lines += value == "LINE";
    EXPECT_TRUE(open == 0 || open == 1);
  }
  EXPECT_EQ(open, 0);
  EXPECT_EQ(tables, 0);
  EXPECT_EQ(lines, 2);
  EXPECT_EQ(groups[3], std::pair(1, std::string("AC1009")));
  EXPECT_EQ(groups.back(), std::pair(0, std::string("EOF")));
}

TEST(SegmentFiles, DxfHasTheEndsOfEachLine) {
  const auto groups = groups_of(segments_dxf(two()));
  std::vector<std::vector<std::pair<int, double>>> lines;
  bool in_line = false;
  for (const auto& [code, value] : groups) {
    if (code == 0 && (in_line = value == "LINE")) lines.emplace_back();
    if (in_line && code >= 10) lines.back().emplace_back(code, std::stod(value));
  }
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines[0], (std::vector<std::pair<int, double>>{
                          {10, -1.25}, {20, 2}, {30, 0}, {11, 3.75}, {21, 2}, {31, 0}}));
  EXPECT_EQ(lines[1], (std::vector<std::pair<int, double>>{
                          {10, 0}, {20, 0.1235}, {30, 0}, {11, 1}, {21, -1}, {31, 0}}));
}

TEST(SegmentFiles, GeoJsonIsReadBack) {
  const auto json = nlohmann::json::parse(segments_geojson(two()));
  EXPECT_EQ(json["type"], "FeatureCollection");
  ASSERT_EQ(json["features"].size(), 2U);
  const auto& wall = json["features"][0];
  EXPECT_EQ(wall["type"], "Feature");
  EXPECT_EQ(wall["geometry"]["type"], "LineString");
  EXPECT_EQ(wall["geometry"]["coordinates"], nlohmann::json::parse("[[-1.25, 2.0], [3.75, 2.0]]"));
  EXPECT_EQ(wall["properties"],
            nlohmann::json::parse(R"({"length": 5.0, "points": 50, "scans": 7, "sigma_a": 0.03,
              "sigma_angle": 0.002, "sigma_b": 0.04, "sigma_offset": 0.01})"));
}

TEST(SegmentFiles, Wkt) {
  EXPECT_EQ(segments_wkt(two()),
            "MULTILINESTRING ((-1.2500 2.0000, 3.7500 2.0000), (0.0000 0.1235, 1.0000 -1.0000))\n");
}

TEST(SegmentFiles, HaveForbiddenZonesOfTheirOwnKind) {
  const Zones zones = {{{0, 0}, {9, 0}, {9, 2.5}}};
  EXPECT_NE(
      segments_svg(two(), zones).find("points=\"0.0000,0.0000 9.0000,0.0000 9.0000,-2.5000\"/>"),
      std::string::npos);
  EXPECT_NE(segments_svg({}, zones).find("viewBox=\"-1.0000 -3.5000 11.0000 4.5000\""),
            std::string::npos);
  EXPECT_EQ(segments_wkt({}, zones),
            "GEOMETRYCOLLECTION (MULTILINESTRING EMPTY, POLYGON ((0.0000 0.0000, 9.0000 0.0000, "
            "9.0000 2.5000, 0.0000 0.0000)))\n");
  const auto json = nlohmann::json::parse(segments_geojson(two(), zones));
  ASSERT_EQ(json["features"].size(), 3U);
  EXPECT_EQ(json["features"][2]["properties"]["kind"], "forbidden");
  EXPECT_EQ(json["features"][2]["geometry"]["coordinates"],
            nlohmann::json::parse("[[[0.0, 0.0], [9.0, 0.0], [9.0, 2.5], [0.0, 0.0]]]"));
  int corners = 0, on_layer = 0, layers = 0;
  for (const auto& [code, value] : groups_of(segments_dxf(two(), zones))) {
    corners += code == 0 && value == "VERTEX";
    layers += code == 2 && value == "FORBIDDEN";
    on_layer += code == 8 && value == "FORBIDDEN";
  }
  EXPECT_EQ(corners, 3);
  EXPECT_EQ(layers, 1);
  EXPECT_EQ(on_layer, 5);  // with the polyline's begin and end
}

TEST(SegmentFiles, OfNothingAreValid) {
  EXPECT_EQ(segments_wkt({}), "MULTILINESTRING EMPTY\n");
  EXPECT_TRUE(nlohmann::json::parse(segments_geojson({}))["features"].empty());
  EXPECT_EQ(groups_of(segments_dxf({})).back().second, "EOF");
  EXPECT_NE(segments_svg({}).find("viewBox=\"-1.0000 -1.0000 2.0000 2.0000\""), std::string::npos);
}

}  // namespace
}  // namespace majak::io
