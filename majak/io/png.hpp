// SPDX-License-Identifier: Apache-2.0
// Pictures to PNG bytes (ISO/IEC 15948), 8 bits a channel, and back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace majak::io {

/// Row by row from the top, channels beside each other: 1 grey, 3 red green blue, 4 with alpha.
struct Image {
  int width = 0, height = 0, channels = 1;
  std::vector<std::uint8_t> pixels;

  Image() = default;
  Image(int w, int h, int c, std::uint8_t value = 0)
      : width(w),
        height(h),
        channels(c),
        pixels(
            static_cast<std::size_t>(w) * static_cast<std::size_t>(h) * static_cast<std::size_t>(c),
            value) {}
  std::uint8_t* row(int y) {
    return pixels.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width * channels);
  }
  const std::uint8_t* row(int y) const { return const_cast<Image*>(this)->row(y); }
};

/// Flat-coloured pictures pack well without filters, so none are used. Throws Error when the size
/// does not fit the pixels or there are none.
std::string encode_png(const Image& image);

/// Any PNG as grey values; what is transparent comes out as `under`. Throws Error (name, what is
/// wrong).
Image decode_grey_png(const std::string& bytes, const std::string& name, std::uint8_t under = 205);

}  // namespace majak::io
