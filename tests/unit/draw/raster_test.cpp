// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/raster.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

namespace majak::draw {
namespace {

constexpr Colour kBlack{0, 0, 0};

/// What one sees: '#' dark, '+' half, '.' white.
std::string picture(const io::Image& image) {
  std::string text;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const int value = image.row(y)[3 * x];
      text += value < 64 ? '#' : value < 192 ? '+' : '.';
    }
    text += '\n';
  }
  return text;
}

/// Ink on the sheet, in pixels.
double ink_of(const io::Image& image) {
  double sum = 0;
  for (const auto value : image.pixels) sum += (255 - value) / 255.0 / 3;
  return sum;
}

TEST(Raster, ABoxOfWholePixels) {
  Raster raster(6, 5);
  raster.area(std::vector<Point>{{1, 1}, {5, 1}, {5, 4}, {1, 4}}, kBlack);
  EXPECT_EQ(picture(std::move(raster).image()),
            "......\n"
            ".####.\n"
            ".####.\n"
            ".####.\n"
            "......\n");
}

TEST(Raster, HalfPixelsAreGrey) {
  Raster raster(6, 4);
  raster.area(std::vector<Point>{{1.5, 1}, {4.5, 1}, {4.5, 3}, {1.5, 3}}, kBlack);
  EXPECT_EQ(picture(std::move(raster).image()),
            "......\n"
            ".+##+.\n"
            ".+##+.\n"
            "......\n");
}

TEST(Raster, LinesLieWhereTheyShould) {
  Raster raster(9, 7);
  raster.line(std::vector<Point>{{1.5, 1.5}, {6.5, 1.5}, {6.5, 5.5}}, 1, kBlack);
  EXPECT_EQ(picture(std::move(raster).image()),
            ".........\n"
            ".######..\n"
            "......#..\n"
            "......#..\n"
            "......#..\n"
            "......#..\n"
            ".........\n");
}

TEST(Raster, OnePointIsADot) {
  Raster raster(7, 7);
  raster.line(std::vector<Point>{{3.5, 3.5}}, 4, kBlack);
  EXPECT_EQ(picture(std::move(raster).image()),
            ".......\n"
            "..+++..\n"
            ".+###+.\n"
            ".+###+.\n"
            ".+###+.\n"
            "..+++..\n"
            ".......\n");
}

TEST(Raster, EvenOddLeavesAHole) {
  Raster raster(6, 6);
  raster.area(
      std::vector<Point>{
          {0, 0}, {6, 0}, {6, 6}, {0, 6}, {0, 0}, {2, 2}, {4, 2}, {4, 4}, {2, 4}, {2, 2}},
      kBlack);
  EXPECT_EQ(picture(std::move(raster).image()),
            "######\n"
            "######\n"
            "##..##\n"
            "##..##\n"
            "######\n"
            "######\n");
}

TEST(Raster, InkIsTheArea) {
  Raster circle(60, 60);
  std::vector<Point> points;
  for (int i = 0; i < 200; ++i)
    points.push_back({30 + 20.3 * std::cos(i * std::numbers::pi / 100),
                      30.4 + 20.3 * std::sin(i * std::numbers::pi / 100)});
  circle.area(points, kBlack);
  EXPECT_NEAR(ink_of(std::move(circle).image()), std::numbers::pi * 20.3 * 20.3, 2);  // seen: 0.6
  Raster line(60, 60);
  line.line(std::vector<Point>{{10, 12}, {50, 41}}, 3, kBlack);
  const double length = std::hypot(40, 29);
  EXPECT_NEAR(ink_of(std::move(line).image()), 3 * length + std::numbers::pi * 1.5 * 1.5, 2);
}

TEST(Raster, ThinLinesAreFaint) {
  Raster raster(20, 3);
  raster.line(std::vector<Point>{{-5, 1.5}, {30, 1.5}}, 0.25, kBlack);
  EXPECT_NEAR(ink_of(std::move(raster).image()), 20 * 0.25, 0.1);
}

TEST(Raster, ALineOverItselfIsNoDarker) {
  const Colour half = kBlack.faint(0.5);
  Raster once(20, 20), twice(20, 20);
  once.line(std::vector<Point>{{3, 10}, {17, 10}}, 3, half);
  twice.line(std::vector<Point>{{3, 10}, {17, 10}, {3, 10}}, 3, half);
  EXPECT_EQ(std::move(once).image().pixels, std::move(twice).image().pixels);
}

TEST(Raster, NothingOutsideTheClip) {
  Raster raster(6, 5);
  raster.clip({2, 1, 3, 2});
  raster.area(std::vector<Point>{{-9, -9}, {90, -9}, {90, 90}, {-9, 90}}, kBlack);
  raster.line(std::vector<Point>{{0, 4.5}, {6, 4.5}}, 1, kBlack);
  EXPECT_EQ(picture(std::move(raster).image()),
            "......\n"
            "..###.\n"
            "..###.\n"
            "......\n"
            "......\n");
}

TEST(Raster, FarPointsAndEmptyShapesAreHarmless) {
  Raster raster(8, 8);
  raster.line(std::vector<Point>{}, 1, kBlack);
  raster.area(std::vector<Point>{{1, 1}, {5, 5}}, kBlack);
  raster.line(std::vector<Point>{{-1e7, -1e7}, {-1e7, 1e7}}, 3, kBlack);
  raster.area(std::vector<Point>{{1e8, 0}, {1e8, 5}, {2e8, 5}}, kBlack);
  EXPECT_EQ(ink_of(std::move(raster).image()), 0);
}

/// '#' black, '+' half, '.' white.
io::Image grey_picture(const std::vector<std::string>& rows) {
  io::Image image(int(rows[0].size()), int(rows.size()), 1);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const char c = rows[std::size_t(y)][std::size_t(x)];
      image.row(y)[x] = c == '#' ? 0 : c == '+' ? 128 : 255;
    }
  return image;
}

TEST(Raster, PicturesKeepSharpEdgesWhenTheyGrow) {
  Raster raster(8, 5);
  raster.picture(grey_picture({"#.#", ".#."}), {1, 0, 6, 4});
  EXPECT_EQ(picture(std::move(raster).image()),
            ".##..##.\n"
            ".##..##.\n"
            "...##...\n"
            "...##...\n"
            "........\n");
}

TEST(Raster, PicturesAreTheMeanWhereTheyShrink) {
  Raster raster(3, 2);
  raster.picture(grey_picture({"##.#..", "##.#..", "######", "......"}), {0, 0, 3, 2});
  const io::Image image = std::move(raster).image();
  EXPECT_EQ(picture(image),
            "#+.\n"
            "+++\n");
  EXPECT_EQ(image.row(0)[3], 128);
  EXPECT_EQ(image.row(1)[0], 128);
}

TEST(Raster, ClearPixelsShowWhatIsUnder) {
  Raster raster(3, 1);
  raster.area(std::vector<Point>{{0, 0}, {2, 0}, {2, 1}, {0, 1}}, kBlack);
  io::Image image(3, 1, 4);
  image.pixels = {255, 0, 0, 255, 255, 0, 0, 0, 0, 0, 255, 51};
  raster.picture(image, {0, 0, 3, 1});
  EXPECT_EQ(std::move(raster).image().pixels,
            (std::vector<std::uint8_t>{255, 0, 0, 0, 0, 0, 204, 204, 255}));
}

TEST(Raster, PicturesStayWithinTheirClip) {
  Raster raster(4, 2);
  raster.clip({1, 0, 2, 2});
  raster.picture(grey_picture({"#"}), {-3, -3, 10, 10});
  EXPECT_EQ(picture(std::move(raster).image()), ".##.\n.##.\n");
}

}  // namespace
}  // namespace majak::draw
