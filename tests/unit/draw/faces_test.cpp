// SPDX-License-Identifier: Apache-2.0
// Every face of every odd place is a page, or an error that says why not.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "majak/core/error.hpp"
#include "majak/draw/face.hpp"
#include "majak/draw/face_figure.hpp"

namespace majak::draw {
namespace {

using ::testing::HasSubstr;

/// A turn in the middle of a room of 6 x 4 m.
PosedScan in_a_room(int i, const Pose2& pose) {
  PosedScan posed;
  posed.scan.time = i * kSecond / 5 + i / 20 * 100 * kSecond;  // three visits
  posed.scan.start_angle = -kPi / 2;
  posed.scan.angle_step = kPi / 180;
  posed.scan.max_range = 8;
  for (int beam = 0; beam <= 180; ++beam) {
    const double angle = posed.scan.angle(std::size_t(beam)) + pose.theta;
    const double x = std::cos(angle), y = std::sin(angle);
    const double to_x = ((x > 0 ? 3 : -3) - pose.x) / x, to_y = ((y > 0 ? 2 : -2) - pose.y) / y;
    const double range = std::min(std::abs(to_x), std::abs(to_y));
    posed.scan.ranges.push_back(float(range));
    posed.scan.intensities.push_back(float(500 / (range * range)));
  }
  posed.estimate.T_map_robot = pose;
  posed.estimate.covariance = 1e-4 * Mat3::Identity();
  posed.key = true;
  return posed;
}

Site room(int scans) {
  Site site;
  site.source_name = "room.log";
  for (int i = 0; i < scans; ++i)
    site.scans.push_back(in_a_room(i, {0.02 * i - 0.5, 0.01 * i, 0.1 * i}));
  return site;
}

Site without_returns() {
  Site site = room(30);
  for (PosedScan& posed : site.scans) posed.scan.ranges.assign(posed.scan.ranges.size(), kNoReturn);
  return site;
}

/// Every second scan somewhere else in the same room.
Site wrong_poses() {
  Site site = room(24);
  for (std::size_t i = 0; i < site.scans.size(); i += 2)
    site.scans[i].estimate.T_map_robot = {0.7, -0.4, 0.35 * double(i)};
  return site;
}

Site lost() {
  Site site = room(10);
  for (PosedScan& posed : site.scans) posed.estimate.health = Health::lost;
  return site;
}

/// Floor and a wall, as a second laser saw them.
map::SolidCloud cloud() {
  map::SolidCloud cloud;
  for (int k = 0; k < 15; ++k)
    for (int i = 0; i < 15; ++i) {
      map::SolidPoint floor, wall;
      floor.count = wall.count = 1;
      floor.normal = floor.towards = Vec3::UnitZ(), wall.normal = wall.towards = Vec3::UnitX();
      floor.mean = {0.1 * i + 0.05, 0.1 * k + 0.05, 0}, floor.cell = {i, k, 0};
      wall.mean = {0, 0.1 * i + 0.05, 0.1 * k + 0.1}, wall.cell = {0, i, k + 1};
      cloud.points.push_back(floor), cloud.points.push_back(wall);
    }
  return cloud;
}

class EveryFace : public ::testing::TestWithParam<Face> {};

TEST_P(EveryFace, IsAPageOfARoom) {
  const map::SolidCloud seen = cloud();
  FaceOptions options;
  options.cloud = &seen;
  const FacePage page = GetParam().make(room(60), options);
  EXPECT_FALSE(page.lead.empty());
  EXPECT_GT(page.bytes, 0U);
  ASSERT_EQ(page.figure.panels.size(), 1U);
  EXPECT_FALSE(page.figure.panels[0].marks.empty());
}

TEST_P(EveryFace, SurvivesOddPlaces) {
  for (const Site& site : {Site{}, room(1), without_returns(), wrong_poses(), lost()}) {
    try {
      const FacePage page = GetParam().make(site, {});
      EXPECT_FALSE(figure_svg(page.figure).empty());
      for (const auto& [name, value] : page.figures) EXPECT_TRUE(std::isfinite(value)) << name;
    } catch (const Error& e) {
      EXPECT_GT(std::string(e.what()).size(), 10U);
    }
  }
}

TEST_P(EveryFace, IsTheSameForAnyNumberOfThreads) {
  FaceOptions one, eight;
  one.threads = {1}, eight.threads = {8};
  const Site site = room(40);
  std::string said[2];
  for (const auto& [options, text] : {std::pair{&one, &said[0]}, std::pair{&eight, &said[1]}}) {
    try {
      const FacePage page = GetParam().make(site, *options);
      *text = figure_svg(page.figure) + page.lead;
      for (const FaceFile& file : page.files) *text += file.bytes;
    } catch (const Error& e) {
      *text = e.what();
    }
  }
  EXPECT_EQ(said[0], said[1]);
}

INSTANTIATE_TEST_SUITE_P(Faces, EveryFace, ::testing::ValuesIn(faces().begin(), faces().end()),
                         [](const auto& info) {
                           std::string name = info.param.name;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST(Faces, AreFoundByName) {
  EXPECT_STREQ(face("segments").name, "segments");
  EXPECT_STREQ(face("chatila-laumond").name, "segments");
  EXPECT_STREQ(face("moravec-elfes").name, "occupancy");
  EXPECT_STREQ(face("kuipers-mataric").name, "rooms");
  EXPECT_THROW(face(""), Error);
  try {
    face("nose");
    FAIL();
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), HasSubstr("no face nose; there are sensor, occupancy"));
  }
}

TEST(Faces, ThePageHoldsEveryFaceAndWhyOneIsMissing) {
  const Face& segments = face("segments");
  MadeFace good{.face = &segments, .page = segments.make(room(60), {}), .seconds = 0.25};
  MadeFace bad{.face = &face("occupancy"), .error = "no scan <has> a pose"};
  const MadeFace made[] = {good, bad};
  const std::string html = faces_html("hall", made);
  EXPECT_THAT(html, HasSubstr("<td>0.25 s</td>"));
  EXPECT_THAT(html, HasSubstr("no scan &lt;has&gt; a pose"));
  EXPECT_THAT(html, HasSubstr("data:image/svg+xml;base64,"));
  EXPECT_EQ(html.find("<script>const"), std::string::npos);
}

TEST(CellsPicture, HasAPixelACell) {
  const auto picture = cells_picture({-2, 5, 3, 2}, 0.5, [](int ix, int iy) {
    return ix == 0 && iy == 6 ? ink::black : ink::white;
  });
  ASSERT_TRUE(picture);
  EXPECT_EQ(picture->low, (Point{-1, 2.5}));
  EXPECT_EQ(picture->pixel, 0.5);
  EXPECT_EQ(picture->image.row(0)[6], ink::black.r);
  EXPECT_EQ(picture->image.row(1)[6], 255);
  EXPECT_FALSE(cells_picture({}, 0.5, [](int, int) { return ink::black; }));
}

TEST(CellsPicture, KeepsThinWallsOfLargeMaps) {
  const auto picture = cells_picture(
      {0, 0, 5000, 4000}, 0.05, [](int ix, int) { return ix == 1234 ? ink::black : ink::white; });
  ASSERT_TRUE(picture);
  EXPECT_LE(picture->image.width * picture->image.height, 1 << 22);
  const auto* row = picture->image.row(7);
  int dark = 0;
  for (int x = 0; x < picture->image.width; ++x) dark += row[3 * x] == ink::black.r;
  EXPECT_EQ(dark, 1);
}

TEST(MapSheet, IsAsHighAsThePlaceAsks) {
  const Figure wide = map_sheet("w", {Polyline{{{0, 0}, {50, 1}}}});
  const Figure high = map_sheet("h", {Polyline{{{0, 0}, {1, 50}}}});
  const Figure square = map_sheet("s", {Polyline{{{0, 0}, {10, 10}}}});
  EXPECT_EQ(wide.height, 350);
  EXPECT_EQ(high.height, 1600);
  EXPECT_NEAR(square.height, 1022, 1);
  EXPECT_EQ(map_sheet("nothing", {}).height, 350);
}

}  // namespace
}  // namespace majak::draw
