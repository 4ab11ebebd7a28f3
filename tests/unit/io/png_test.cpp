// SPDX-License-Identifier: Apache-2.0
// The encoder against libpng, which reads what it wrote.
#include "majak/io/png.hpp"

#include <gtest/gtest.h>
#include <png.h>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"

namespace majak::io {
namespace {

Image decode(const std::string& bytes, int channels) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  if (!png_image_begin_read_from_memory(&png, bytes.data(), bytes.size())) throw Error(png.message);
  const std::uint32_t stored = png.format;
  png.format = channels == 1 ? PNG_FORMAT_GRAY : channels == 3 ? PNG_FORMAT_RGB : PNG_FORMAT_RGBA;
  EXPECT_EQ(stored & ~PNG_FORMAT_FLAG_COLORMAP, png.format);
  Image image(static_cast<int>(png.width), static_cast<int>(png.height), channels);
  if (!png_image_finish_read(&png, nullptr, image.pixels.data(), 0, nullptr))
    throw Error(png.message);
  return image;
}

TEST(Png, ReadsBackInLibpng) {
  RandomStream random(3);
  for (const auto& [width, height] : {std::pair(1, 1), std::pair(7, 3), std::pair(300, 200)}) {
    for (const int channels : {1, 3, 4}) {
      Image image(width, height, channels);
      for (auto& pixel : image.pixels) pixel = static_cast<std::uint8_t>(random.below(256));
      for (std::size_t i = 3; channels == 4 && i < image.pixels.size(); i += 4)
        image.pixels[i] = 255;
      const Image back = decode(encode_png(image), channels);
      EXPECT_EQ(back.width, width);
      EXPECT_EQ(back.height, height);
      EXPECT_EQ(back.pixels, image.pixels);
    }
  }
}

TEST(Png, PacksFlatPicturesWell) { EXPECT_LT(encode_png(Image(1000, 1000, 1, 205)).size(), 8000U); }

TEST(Png, RefusesPixelsThatDoNotFit) {
  EXPECT_THROW(encode_png(Image{}), Error);
  EXPECT_THROW(encode_png(Image(0, 5, 1)), Error);
  EXPECT_THROW(encode_png(Image(2, 2, 2)), Error);
  Image image(3, 3, 1);
  image.pixels.pop_back();
  EXPECT_THROW(encode_png(image), Error);
}

}  // namespace
}  // namespace majak::io
