// SPDX-License-Identifier: Apache-2.0
#include "majak/sim/plan.hpp"

#include <gmock/gmock.h>
#include <png.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <functional>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"

namespace majak::sim {
namespace {

using testing::HasSubstr;

constexpr const char* kRoom =
    "##########\n"
    "#........#\n"
    "#.1..o...#\n"
    "#...^..2.#\n"
    "##########\n";

std::string message_of(const std::function<void()>& body) {
  try {
    body();
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

TEST(TextPlan, CellsBecomeMetresAndRowsCountFromTheTop) {
  const Scene scene = parse_plan(kRoom, "room", 0.5);
  // Outer and inner border, nothing twice: four lines each.
  EXPECT_EQ(scene.segments.size(), 8u);
  ASSERT_EQ(scene.discs.size(), 1u);
  EXPECT_EQ(scene.discs[0].centre, Vec2(2.75, 1.25));
  EXPECT_EQ(scene.start, (Pose2{2.25, 0.75, kPi / 2}));
  ASSERT_EQ(scene.tour.size(), 2u);
  EXPECT_EQ(scene.tour[0], Vec2(1.25, 1.25));
  EXPECT_EQ(scene.tour[1], Vec2(3.75, 0.75));
}

TEST(TextPlan, LaserSeesTheDrawnWalls) {
  const World world(parse_plan(kRoom, "room", 0.5));
  EXPECT_NEAR(world.cast({2.25, 0.75}, 0, 80).range, 2.25, 1e-12);        // right
  EXPECT_NEAR(world.cast({2.25, 0.75}, kPi, 80).range, 1.75, 1e-12);      // left
  EXPECT_NEAR(world.cast({2.25, 0.75}, kPi / 2, 80).range, 1.25, 1e-12);  // up
  EXPECT_NEAR(world.cast({2.25, 0.75}, -kPi / 2, 80).range, 0.25, 1e-12);
}

TEST(TextPlan, SizeOfACellComesFromTheCallTheFileOrTheDefault) {
  const std::string text = std::string("; a room\n; cell 0.25\n") + kRoom;
  EXPECT_NEAR(parse_plan(text, "room").start.x, 4.5 * 0.25, 1e-12);
  EXPECT_NEAR(parse_plan(text, "room", 1).start.x, 4.5, 1e-12);
  EXPECT_NEAR(parse_plan(kRoom, "room").start.x, 4.5 * kTextCell, 1e-12);
}

TEST(TextPlan, FourWaysToFaceAndWindowsLineEnds) {
  const std::pair<char, double> ways[] = {
      {'>', 0}, {'S', 0}, {'^', kPi / 2}, {'<', kPi}, {'v', -kPi / 2}};
  for (const auto& [mark, theta] : ways) {
    const std::string text = std::string("####\r\n#") + mark + " #\r\n####\r\n";
    const Scene scene = parse_plan(text, "plan", 1);
    EXPECT_EQ(scene.start, (Pose2{1.5, 1.5, theta}));
    EXPECT_EQ(scene.segments.size(), 8u);
  }
}

TEST(TextPlan, WithoutAMarkTheStartIsTheMiddleOfTheLargestEnclosedFloor) {
  const Scene scene = parse_plan(
      "                    \n"
      "   ####  #########  \n"
      "   #  #  #       #  \n"
      "   ####  #       #  \n"
      "         #       #  \n"
      "         #########  \n"
      "                    \n",
      "plan", 1);
  EXPECT_TRUE(scene.start.x > 10 && scene.start.x < 17) << scene.start.x;
  EXPECT_EQ(scene.start.y, 3.5);  // the middle row of the large room
}

TEST(TextPlan, ErrorsSayWhere) {
  EXPECT_THAT(message_of([] { parse_plan("###\n#?#\n###\n", "a.txt"); }), HasSubstr("a.txt:2:2: "));
  EXPECT_THAT(message_of([] { parse_plan("; c\n###\n#.#\n##!\n", "a.txt"); }),
              HasSubstr("a.txt:4:3: "));
  const std::string nul("###\n#\0#\n###\n", 12);
  EXPECT_THAT(message_of([&] { parse_plan(nul, "a.txt"); }), HasSubstr("a.txt:2:2: "));
  EXPECT_THAT(message_of([] { parse_plan("; cell nan\n###\n", "a.txt"); }),
              HasSubstr("size of a cell"));
  EXPECT_THAT(message_of([] { parse_plan("", "a.txt"); }), HasSubstr("no wall"));
  EXPECT_THAT(message_of([] { parse_plan("...\n", "a.txt"); }), HasSubstr("no wall"));
  EXPECT_THAT(message_of([] { parse_plan("###\n###\n", "a.txt"); }), HasSubstr("no floor"));
  EXPECT_THAT(message_of([] { parse_plan("; cell -1\n###\n", "a.txt"); }),
              HasSubstr("size of a cell"));
}

/// '#' black, '.' white, '-' transparent.
std::string picture(const std::vector<std::string>& rows) {
  png_image image;
  std::memset(&image, 0, sizeof image);
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(rows[0].size());
  image.height = static_cast<png_uint_32>(rows.size());
  image.format = PNG_FORMAT_RGBA;
  std::vector<png_byte> pixels;
  for (const std::string& row : rows) {
    for (const char c : row) {
      const png_byte grey = c == '.' ? 255 : 0;
      pixels.insert(pixels.end(), {grey, grey, grey, static_cast<png_byte>(c == '-' ? 0 : 255)});
    }
  }
  std::string bytes(10000, '\0');
  png_alloc_size_t size = bytes.size();
  png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels.data(), 0, nullptr);
  bytes.resize(size);
  return bytes;
}

TEST(PicturePlan, DarkIsWallAndTransparentIsPaper) {
  const std::string png = picture({"--------",  //
                                   "-######-",  //
                                   "-#....#-",  //
                                   "-#....#-",  //
                                   "-######-"});
  const Scene scene = parse_picture(png, "p.png", 1);
  EXPECT_EQ(scene.segments.size(), 8u);
  const World world(scene);
  EXPECT_NEAR(world.cast({3.3, 2.2}, 0, 80).range, 2.7, 1e-12);
  EXPECT_NEAR(world.cast({3.3, 2.2}, -kPi / 2, 80).range, 1.2, 1e-12);
  EXPECT_TRUE(scene.start.x > 2 && scene.start.x < 6 && scene.start.y > 1 && scene.start.y < 3);
}

TEST(PicturePlan, ErrorsNameThePicture) {
  EXPECT_THAT(message_of([] { parse_picture("\x89PNG broken", "p.png"); }), HasSubstr("p.png: "));
  const std::string white = picture({"...", "..."});
  EXPECT_THAT(message_of([&] { parse_picture(white, "p.png"); }), HasSubstr("dark"));
  const std::string whole = picture({"###", "#.#", "###"});
  EXPECT_THAT(message_of([&] { parse_picture(whole.substr(0, whole.size() / 2), "p.png"); }),
              HasSubstr("p.png: "));
}

TEST(TextPlan, RandomBytesAreAnErrorOrAPlan) {
  RandomStream r(1);
  const std::string alphabet = "##..  o>v1Z;\n\n\r\x80?";
  for (int i = 0; i < 3000; ++i) {
    std::string text;
    for (std::uint64_t k = r.below(60); k > 0; --k)
      text += alphabet[r.below(alphabet.size() - (i % 2) * 2)];
    try {
      const Scene scene = parse_plan(text, "plan");
      EXPECT_FALSE(scene.segments.empty());
      EXPECT_TRUE(scene.start.finite());
    } catch (const Error& e) {
      EXPECT_TRUE(std::string(e.what()).starts_with("plan:")) << e.what();
    }
  }
}

TEST(Plan, FileIsToldApartByItsContent) {
  std::string name = (std::filesystem::temp_directory_path() / "majak-plan-XXXXXX").string();
  const std::filesystem::path folder = ::mkdtemp(name.data());
  std::ofstream(folder / "text.png") << kRoom;
  std::ofstream(folder / "picture.txt", std::ios::binary) << picture({"###", "#.#", "###"});
  EXPECT_EQ(read_plan(folder / "text.png").tour.size(), 2u);
  EXPECT_EQ(read_plan(folder / "picture.txt", 1).start, (Pose2{1.5, 1.5, 0}));
  EXPECT_THAT(message_of([&] { read_plan(folder / "nothing"); }), HasSubstr("nothing: "));
  EXPECT_THAT(message_of([&] { read_plan(folder); }), HasSubstr("folder"));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace majak::sim
