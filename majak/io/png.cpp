// SPDX-License-Identifier: Apache-2.0
#include "majak/io/png.hpp"

#include <png.h>
#include <zlib.h>

#include <fmt/format.h>

#include <cstdint>
#include <string_view>

#include "majak/core/error.hpp"

namespace majak::io {

namespace {

constexpr int kLevel =
    4;  // maps of some megapixels: 3 times faster than level 6, files 10 % larger

void append_u32(std::string& out, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8)
    out.push_back(static_cast<char>(value >> shift & 0xff));
}

const Bytef* bytes_of(const void* p) { return static_cast<const Bytef*>(p); }

void append_chunk(std::string& out, std::string_view type, std::string_view data) {
  append_u32(out, static_cast<std::uint32_t>(data.size()));
  uLong crc = crc32(0, bytes_of(type.data()), static_cast<uInt>(type.size()));
  crc = crc32_z(crc, bytes_of(data.data()), data.size());
  out += type;
  out += data;
  append_u32(out, static_cast<std::uint32_t>(crc));
}

std::string header(const Image& image) {
  std::string data;
  append_u32(data, static_cast<std::uint32_t>(image.width));
  append_u32(data, static_cast<std::uint32_t>(image.height));
  const int colour_type = image.channels == 1 ? 0 : image.channels == 3 ? 2 : 6;
  for (const int byte : {8, colour_type, 0, 0, 0}) data.push_back(static_cast<char>(byte));
  return data;
}

/// Each row with its filter type (0: none) before it.
std::string deflate_rows(const Image& image) {
  const std::size_t stride =
      static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.channels);
  std::string raw;
  raw.reserve((stride + 1) * static_cast<std::size_t>(image.height));
  for (int y = 0; y < image.height; ++y) {
    raw.push_back('\0');
    raw.append(reinterpret_cast<const char*>(image.row(y)), stride);
  }
  uLongf size = compressBound(raw.size());
  std::string packed(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(packed.data()), &size, bytes_of(raw.data()), raw.size(),
                kLevel) != Z_OK) {
    throw Error("picture: cannot be compressed: not enough memory");
  }
  packed.resize(size);
  return packed;
}

}  // namespace

std::string encode_png(const Image& image) {
  const std::size_t expected = static_cast<std::size_t>(image.width) *
                               static_cast<std::size_t>(image.height) *
                               static_cast<std::size_t>(image.channels);
  const bool known = image.channels == 1 || image.channels == 3 || image.channels == 4;
  if (image.width <= 0 || image.height <= 0 || !known || image.pixels.size() != expected) {
    throw Error("picture: width, height and channels do not fit its pixels");
  }
  std::string out("\x89PNG\r\n\x1a\n", 8);
  append_chunk(out, "IHDR", header(image));
  append_chunk(out, "IDAT", deflate_rows(image));
  append_chunk(out, "IEND", "");
  return out;
}

Image decode_grey_png(const std::string& bytes, const std::string& name, std::uint8_t under) {
  constexpr png_uint_32 kMostSide = 1U << 24;
  constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 28;
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  const auto fail = [&](const char* why) {
    const std::string text = fmt::format("{}: no readable PNG: {}", name, why);
    png_image_free(&png);
    throw Error(text);
  };
  if (png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()) == 0) fail(png.message);
  if (png.width > kMostSide || png.height > kMostSide ||
      std::uint64_t{png.width} * png.height > kMostPixels)
    fail("too many pixels");
  png.format = PNG_FORMAT_GA;
  Image both(static_cast<int>(png.width), static_cast<int>(png.height), 2);
  if (png_image_finish_read(&png, nullptr, both.pixels.data(), 0, nullptr) == 0) fail(png.message);
  Image grey(both.width, both.height, 1);
  for (std::size_t i = 0; i < grey.pixels.size(); ++i)
    grey.pixels[i] = both.pixels[2 * i + 1] < 128 ? under : both.pixels[2 * i];
  return grey;
}

}  // namespace majak::io
