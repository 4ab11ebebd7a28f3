// SPDX-License-Identifier: Apache-2.0
#include "majak/io/known_map_files.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "majak/core/error.hpp"
#include "majak/io/map_files.hpp"

namespace majak::io {
namespace {

namespace fs = std::filesystem;
using map::CellState;

class KnownMapFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(::testing::TempDir()) /
              ("known_map_" +
               std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }
  std::string error_of(const fs::path& path, double resolution = 0) const {
    try {
      read_map(path, resolution);
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  }
  fs::path folder_;
};

const std::string kPicture = "P2\n# two rows\n3 2\n255\n0 254 205\n254 0 0\n";
const std::string kYaml =
    "image: a.pgm\nresolution: 0.1  # m\norigin: [-1.5, 2, 0]\nnegate: 0\n"
    "occupied_thresh: 0.65\nfree_thresh: 0.196\n";

TEST_F(KnownMapFiles, ThePictureLiesOnItsOriginWithTheLastRowBelow) {
  write("a.pgm", kPicture);
  const MapInput input = read_map(write("a.yaml", kYaml));
  ASSERT_TRUE(input.known);
  const auto& map = *input.known;
  EXPECT_EQ(map.width, 3);
  EXPECT_EQ(map.height, 2);
  EXPECT_DOUBLE_EQ(map.resolution, 0.1);
  EXPECT_EQ(map.cells, (std::vector{CellState::free, CellState::occupied, CellState::occupied,
                                    CellState::occupied, CellState::free, CellState::unknown}));
  EXPECT_EQ(map.at(Vec2(-1.45, 2.05)), CellState::free);
  EXPECT_EQ(map.at(Vec2(-1.45, 2.15)), CellState::occupied);
  EXPECT_EQ(input.T_world_map, Pose2{});
}

TEST_F(KnownMapFiles, ATurnedOriginIsAFrame) {
  write("a.pgm", kPicture);
  const MapInput input =
      read_map(write("a.yaml", "image: a.pgm\nresolution: 0.1\norigin:\n- 1\n- 2\n- 0.5\n"));
  EXPECT_EQ(input.known->x0, 0);
  EXPECT_EQ(input.T_world_map, (Pose2{1, 2, 0.5}));
}

TEST_F(KnownMapFiles, WhatARunWritesComesBack) {
  map::OccupancyGrid grid(0.05);
  for (int x = -20; x < 30; ++x)
    for (int y = -10; y < 15; ++y)
      grid.set_log_odds(x, y, x == -20 || y == 14 ? 3.0F : x > 20 ? 0.1F : -2.0F);
  write_map_files(folder_, grid);
  const map::KnownMap direct = map::known_map(grid);
  for (const char* name : {"", "map.yaml", "map.pgm"}) {
    const MapInput input = read_map(folder_ / name);
    for (int iy = -2; iy < direct.height + 2; ++iy)
      for (int ix = -2; ix < direct.width + 2; ++ix)
        ASSERT_EQ(input.known->at(direct.centre(ix, iy)), direct.at(ix, iy)) << ix << ' ' << iy;
  }
}

TEST_F(KnownMapFiles, ABarePictureNeedsItsScale) {
  const fs::path path = write("a.pgm", kPicture);
  EXPECT_NE(error_of(path).find("--map-resolution"), std::string::npos);
  EXPECT_DOUBLE_EQ(read_map(path, 0.2).known->resolution, 0.2);
  EXPECT_NE(error_of(path, 1000).find("0.001 ... 10 m"), std::string::npos);
}

TEST_F(KnownMapFiles, PngGreyAlphaAndPgmAreOne) {
  Image image(3, 2, 4);
  const int values[6] = {0, 254, 205, 254, 0, 0};
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t c = 0; c < 4; ++c)
      image.pixels[4 * i + c] = static_cast<std::uint8_t>(c < 3 ? values[i] : 255);
  image.pixels[4 * 2] = image.pixels[4 * 2 + 1] = image.pixels[4 * 2 + 2] = 0;
  image.pixels[4 * 2 + 3] = 0;  // transparent: unknown
  EXPECT_EQ(decode_grey_png(encode_png(image), "a").pixels, decode_pgm(kPicture, "b").pixels);
}

TEST_F(KnownMapFiles, PgmOfManyKinds) {
  EXPECT_EQ(decode_pgm("P5 2 1 255\n\x01\xfe", "a").pixels, (std::vector<std::uint8_t>{1, 254}));
  EXPECT_EQ(decode_pgm(std::string("P5\n2 1\n65535\n\xff\xff\x00\x00", 17), "a").pixels,
            (std::vector<std::uint8_t>{255, 0}));
  EXPECT_EQ(decode_pgm("P2 2 1 # comment 9\n 10\n 10 5", "a").pixels,
            (std::vector<std::uint8_t>{255, 128}));
}

TEST_F(KnownMapFiles, NegatedAndRawValues) {
  Image image(3, 1, 1);
  image.pixels = {0, 100, 255};
  MapKey key;
  key.negate = true;
  EXPECT_EQ(known_map(image, key).cells[0], CellState::free);
  EXPECT_EQ(known_map(image, key).cells[2], CellState::occupied);
  key = {};
  key.percent = true;
  EXPECT_EQ(known_map(image, key).cells,
            (std::vector{CellState::free, CellState::occupied, CellState::unknown}));
}

TEST_F(KnownMapFiles, BadInputIsSaid) {
  const auto says = [&](const std::string& yaml, const std::string& what) {
    const std::string error = error_of(write("b.yaml", yaml));
    EXPECT_NE(error.find(what), std::string::npos) << error;
    EXPECT_NE(error.find("b.yaml"), std::string::npos) << error;
  };
  says("resolution: 0.1\n", "names no image");
  says("image: a.pgm\n", "says no resolution");
  says("image: a.pgm\nresolution: five\n", "b.yaml:2: five is no number");
  says("image: a.pgm\nresolution: 0\n", "is no map");
  says("image: a.pgm\nresolution: 0.1\norigin: 1 2 3\n", "written [x, y, yaw]");
  says(
      "\x7f"
      "ELF",
      "key: value");
  EXPECT_NE(error_of(write("c.yaml", "image: none.pgm\nresolution: 1\n")).find("none.pgm"),
            std::string::npos);
  const auto fails = [&](const std::string& picture, const std::string& what) {
    const std::string error = error_of(write("p.pgm", picture), 0.1);
    EXPECT_NE(error.find(what), std::string::npos) << error;
  };
  fails("", "neither a PGM nor a PNG");
  fails("P5 3 3 255\n123", "ends early");
  fails("P5 0 3 255\n", "empty");
  fails("P5 16000000 16000000 255\n", "too many pixels");
  fails("P5 99999999999 1 255\n", "out of range");
  fails("P2 3 3 255\n1 2 3 4 x 6 7 8 9", "a number is missing");
  fails("\x89PNG\r\n\x1a\nrubbish", "no readable PNG");
  EXPECT_NE(error_of(folder_ / "nothing").find("nothing"), std::string::npos);
  fs::create_directories(folder_ / "empty");
  EXPECT_NE(error_of(folder_ / "empty").find("neither site.majak nor map.yaml"), std::string::npos);
}

}  // namespace
}  // namespace majak::io
