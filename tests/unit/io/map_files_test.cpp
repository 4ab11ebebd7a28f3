// SPDX-License-Identifier: Apache-2.0
#include "majak/io/map_files.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/io/known_map_files.hpp"
#include "majak/map/edits.hpp"

namespace majak::io {
namespace {

namespace fs = std::filesystem;
using map::OccupancyGrid;

/// '#' occupied, '.' free, '?' seen but undecided, ' ' unknown; the first line is the highest row,
/// the last one row y0.
OccupancyGrid grid_from(const std::vector<std::string>& lines, int x0, int y0, double resolution) {
  OccupancyGrid grid(resolution);
  for (std::size_t row = 0; row < lines.size(); ++row) {
    for (std::size_t x = 0; x < lines[row].size(); ++x) {
      const char c = lines[row][x];
      if (c == ' ') continue;
      grid.set_log_odds(x0 + static_cast<int>(x), y0 + static_cast<int>(lines.size() - 1 - row),
                        c == '#'   ? 3.0F
                        : c == '.' ? -3.0F
                                   : 0.1F);
    }
  }
  return grid;
}

std::string text_of(const Image& image) {
  std::string text;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const int value = image.row(y)[x];
      text += value < 50 ? '#' : value > 230 ? '.' : ' ';
    }
    text += '\n';
  }
  return text;
}

/// Without the margin of unknown cells.
std::string inner(const Image& image, const MapFrame& frame, const map::CellBox& box) {
  std::string text, whole = text_of(image);
  const int left = box.x0 - frame.box.x0,
            top = frame.box.y0 + frame.box.height - box.y0 - box.height;
  for (int y = 0; y < box.height; ++y) {
    text += whole.substr(static_cast<std::size_t>((top + y) * (image.width + 1) + left),
                         static_cast<std::size_t>(box.width)) +
            '\n';
  }
  return text;
}

const std::vector<std::string> kRoom = {"#####", "#..?#", "#.  #", "## ##"};

TEST(MapFiles, ShowHighRowsAtTheTop) {
  const OccupancyGrid grid = grid_from(kRoom, -3, 70, 0.05);
  const MapFrame frame = frame_of(grid);
  for (const Image& image : {shaded_map(grid, frame), trinary_map(grid, frame)}) {
    EXPECT_EQ(inner(image, frame, grid.bounds()),
              "#####\n"
              "#.. #\n"
              "#.  #\n"
              "## ##\n");
  }
}

TEST(MapFiles, UseTheThreeValuesOfMapServer) {
  const OccupancyGrid grid = grid_from(kRoom, 0, 0, 0.05);
  for (const std::uint8_t value : trinary_map(grid, frame_of(grid)).pixels) {
    EXPECT_TRUE(value == 0 || value == 205 || value == 254) << int{value};
    // What a reader makes of it with the thresholds of map.yaml.
    const double p = (255 - value) / 255.0;
    EXPECT_EQ(p > 0.65, value == 0);
    EXPECT_EQ(p < 0.196, value == 254);
  }
}

TEST(MapFiles, ShadeFollowsTheLogOdds) {
  OccupancyGrid grid(1);
  for (int i = 0; i <= 120; ++i) grid.set_log_odds(i, 0, static_cast<float>(i - 60) / 10);
  const MapFrame frame = frame_of(grid);
  const Image image = shaded_map(grid, frame);
  const std::uint8_t* row = image.row(frame.box.y0 + frame.box.height - 1) - frame.box.x0;
  EXPECT_EQ(row[0], 255);
  EXPECT_EQ(row[60], 205);
  EXPECT_EQ(row[120], 0);
  for (int i = 0; i < 120; ++i) EXPECT_GE(row[i], row[i + 1]) << i;
}

TEST(MapFiles, YamlNamesTheLowerLeftCorner) {
  const OccupancyGrid grid = grid_from(kRoom, -3, 70, 0.05);
  const MapFrame frame = frame_of(grid);
  EXPECT_EQ(frame.box, (map::CellBox{-11, 62, 21, 20}));
  EXPECT_EQ(map_yaml(frame, "map.pgm"),
            "image: map.pgm\n"
            "resolution: 0.05\n"
            "origin: [-0.55, 3.1, 0]\n"
            "negate: 0\n"
            "occupied_thresh: 0.65\n"
            "free_thresh: 0.196\n");
}

TEST(MapFiles, PgmIsBinaryAndWhole) {
  Image image(3, 2, 1);
  image.pixels = {0, 1, 2, 253, 254, 255};
  EXPECT_EQ(pgm_text(image), std::string("P5\n3 2\n255\n\x00\x01\x02\xfd\xfe\xff", 17));
}

TEST(MapFiles, MakeLargeMapsCoarserWithoutLosingWalls) {
  OccupancyGrid grid(0.05);
  for (int i = 0; i < 400; ++i) {
    for (int j = 0; j < 300; ++j) grid.set_log_odds(i, j, -2);
    grid.set_log_odds(i, 150, 4);  // a wall one cell thick
  }
  const MapFrame frame = frame_of(grid, 10'000);
  EXPECT_GT(frame.cells_per_pixel, 1);
  EXPECT_LE(frame.width * frame.height, 10'000);
  EXPECT_NEAR(frame.pixel, 0.05 * frame.cells_per_pixel, 1e-12);
  EXPECT_GE(frame.width * frame.cells_per_pixel, 400);
  const Image image = shaded_map(grid, frame);
  for (int x = frame.width / 4; x < frame.width / 2; ++x) {
    int walls = 0;
    for (int y = 0; y < frame.height; ++y) walls += image.row(y)[x] == 0;
    EXPECT_EQ(walls, 1) << x;
  }
}

TEST(MapFiles, EveryPixelIsTheMostOccupiedOfItsCells) {
  OccupancyGrid grid(0.1);
  RandomStream random(5);
  for (int i = 0; i < 400; ++i) {  // a few tiles, most of the ground unknown
    const int x = static_cast<int>(random.below(900)) - 500,
              y = static_cast<int>(random.below(500));
    grid.set_log_odds(x, y - 300, random.uniform() < 0.5 ? -1.0F : 4.0F);
  }
  for (const std::size_t most : {std::size_t{1} << 20, std::size_t{50'000}, std::size_t{900}}) {
    const MapFrame f = frame_of(grid, most);
    const Image image = trinary_map(grid, f);
    for (int py = 0; py < f.height; ++py) {
      for (int px = 0; px < f.width; ++px) {
        int expected = 205;
        for (int i = 0; i < f.cells_per_pixel * f.cells_per_pixel; ++i) {
          const int x = f.box.x0 + px * f.cells_per_pixel + i % f.cells_per_pixel;
          const int y = f.box.y0 + py * f.cells_per_pixel + i / f.cells_per_pixel;
          if (grid.known(x, y) && expected != 0) expected = grid.log_odds(x, y) > 0 ? 0 : 254;
        }
        ASSERT_EQ(image.row(f.height - 1 - py)[px], expected) << px << ' ' << py;
      }
    }
  }
}

TEST(MapFiles, EmptyGroundBetweenFarPlacesCostsNothing) {
  OccupancyGrid grid(0.05);
  grid.set_log_odds(0, 0, 4);
  grid.set_log_odds(200'000, 200'000, 4);  // 10 km off: 4e10 cells between them
  const MapFrame frame = frame_of(grid, 10'000);
  const Image image = trinary_map(grid, frame);
  EXPECT_EQ(std::count(image.pixels.begin(), image.pixels.end(), 0), 2);
}

TEST(MapFiles, OfAnEmptyMapAreSmallAndUnknown) {
  const OccupancyGrid grid(0.05);
  const Image image = trinary_map(grid, frame_of(grid));
  EXPECT_GT(image.width * image.height, 0);
  for (const std::uint8_t value : image.pixels) EXPECT_EQ(value, 205);
}

TEST(MapFiles, AreWrittenIntoTheFolder) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "majak_map_files";
  std::filesystem::create_directories(folder);
  write_map_files(folder, grid_from(kRoom, 0, 0, 0.05));
  for (const auto& [name, magic] : {std::pair("map.png", "\x89PNG"), std::pair("map.pgm", "P5\n"),
                                    std::pair("map.yaml", "image: map.pgm\n")}) {
    std::ifstream in(folder / name, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    EXPECT_EQ(text.substr(0, std::string(magic).size()), magic);
  }
  std::filesystem::remove_all(folder);
  EXPECT_THROW(write_map_files(folder, OccupancyGrid(1)), Error);
}

TEST(KeepoutFiles, AreBlackInTheZonesAndGoWithThem) {
  const fs::path folder = fs::path(testing::TempDir()) / "majak_keepout";
  fs::create_directories(folder);
  const OccupancyGrid grid = grid_from({"....", ".##.", "...."}, -2, -1, 0.5);
  Site site;
  site.scans.resize(1);
  site.scans[0].estimate.T_map_robot = {0.2, 0.1, 0.4};
  const std::vector<Vec2> zone = {{0.01, 0.01}, {0.49, 0.01}, {0.49, 0.49}, {0.01, 0.49}};
  map::add_edit(site, map::anchored(site, EditKind::forbidden, zone));
  write_keepout_files(folder, grid, site);
  const MapFrame frame = frame_of(grid);
  std::ifstream in(folder / "keepout.pgm", std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  const Image mask = decode_pgm(bytes, "keepout.pgm");
  ASSERT_EQ(mask.width, frame.width);
  ASSERT_EQ(mask.height, frame.height);
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      const bool in_zone = x == 0 - frame.box.x0 && mask.height - 1 - y == 0 - frame.box.y0;
      EXPECT_EQ(mask.row(y)[x], in_zone ? 0 : 254) << x << " " << y;
    }
  std::ifstream yaml(folder / "keepout.yaml");
  const std::string text{std::istreambuf_iterator<char>(yaml), {}};
  EXPECT_EQ(text, map_yaml(frame, "keepout.pgm"));
  map::undo_edit(site);
  write_keepout_files(folder, grid, site);
  EXPECT_TRUE(fs::is_empty(folder));
  fs::remove_all(folder);
}

}  // namespace
}  // namespace majak::io
