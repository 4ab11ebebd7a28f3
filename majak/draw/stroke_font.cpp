// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/stroke_font.hpp"

#include <algorithm>
#include <cstdint>
#include <map>

namespace majak::draw {
namespace {

// A glyph is a list of lines. A point is a digit (x) and a letter (y: 'c' the baseline, 'i' the
// height of x, 'k' that of capitals, 'a' the depth of g). '~' before a line bends it, '@' bends and
// closes it: corners are cut (Chaikin 1974), so the middle of each side stays where it is.
const std::map<std::uint32_t, const char*> kGlyphs = {
    {' ', ""},
    {'!', "0k0f 0c0c"},
    {'"', "0k0i 2k2i"},
    {'%', "0c6k @0k2k2h0h @4f6f6c4c"},
    {'&', "~6c1h1k4k4i0f0c4c5f"},
    {'\'', "0k0i"},
    {'(', "~2l0i0d2b"},
    {')', "~0l2i2d0b"},
    {'*', "2k2g 0j4h 0h4j"},
    {'+', "0f6f 3c3i"},
    {',', "1c0a"},
    {'-', "0f3f"},
    {'.', "0c0c"},
    {'/', "0b4l"},
    {'0', "@0k5k5c0c"},
    {'1', "0i2k2c"},
    {'2', "~0i0k5k5g0c 0c5c"},
    {'3', "~0j0k5k5g2g ~2g5g5c0c0d"},
    {'4', "4c4k0e5e"},
    {'5', "5k1k0g ~0g1h5h5c0c0d"},
    {'6', "~5j5k0k0e @0g5g5c0c"},
    {'7', "0k5k1c"},
    {'8', "@0k5k5g0g @0g5g5c0c"},
    {'9', "@0k5k5f0f ~5i5c0c0d"},
    {':', "0c0c 0h0h"},
    {';', "1c0a 1h1h"},
    {'<', "4i0f4c"},
    {'=', "0g5g 0e5e"},
    {'>', "0i4f0c"},
    {'?', "~0j0k4k4h2g2f 2c2c"},
    {'A', "0c3k6c 1f5f"},
    {'B', "0k0c ~0k5k5g0g ~0g6g6c0c"},
    {'C', "~6i6k0k0c6c6e"},
    {'D', "0c0k ~0k6k6c0c"},
    {'E', "5k0k0c5c 0g4g"},
    {'F', "5k0k0c 0g4g"},
    {'G', "~6i6k0k0c6c6f 6f4f"},
    {'H', "0c0k 6c6k 0g6g"},
    {'I', "0c0k"},
    {'J', "~4k4c0c0e"},
    {'K', "0c0k 5k0f 2h6c"},
    {'L', "0k0c5c"},
    {'M', "0c0k3e6k6c"},
    {'N', "0c0k6c6k"},
    {'O', "@0k6k6c0c"},
    {'P', "0c0k ~0k6k6g0g"},
    {'Q', "@0k6k6c0c 4e6b"},
    {'R', "0c0k ~0k6k6g0g 3g6c"},
    {'S', "~6j6k0k0g6g6c0c0d"},
    {'T', "0k6k 3k3c"},
    {'U', "0k0f ~0f0c6c6f 6f6k"},
    {'V', "0k3c6k"},
    {'W', "0k2c4k6c8k"},
    {'X', "0c6k 0k6c"},
    {'Y', "0k3g6k 3g3c"},
    {'Z', "0k6k0c6c"},
    {'[', "2l0l0b2b"},
    {']', "0l2l2b0b"},
    {'_', "0b5b"},
    {'a', "@0i5i5c0c 5i5c"},
    {'b', "0k0c @0i5i5c0c"},
    {'c', "~5h5i0i0c5c5d"},
    {'d', "5k5c @0i5i5c0c"},
    {'e', "0f5f ~5f5i0i0c5c5d"},
    {'f', "~4k1k1i 1i1c 0i3i"},
    {'g', "@0i5i5c0c ~5i5a0a0b"},
    {'h', "0k0c ~0f0i5i5f 5f5c"},
    {'i', "0i0c 0k0k"},
    {'j', "~2i2a0a 2k2k"},
    {'k', "0k0c 4i0e 1f5c"},
    {'l', "0k0e ~0e0c2c"},
    {'m', "0i0c ~0f0i4i4f 4f4c ~4f4i8i8f 8f8c"},
    {'n', "0i0c ~0f0i5i5f 5f5c"},
    {'o', "@0i5i5c0c"},
    {'p', "0i0a @0i5i5c0c"},
    {'q', "5i5a @0i5i5c0c"},
    {'r', "0i0c ~0e0i3i"},
    {'s', "~4h4i0i0f4f4c0c0d"},
    {'t', "1k1e ~1e1c3c 0i3i"},
    {'u', "0i0f ~0f0c5c5f 5i5c"},
    {'v', "0i2c4i"},
    {'w', "0i2c4i6c8i"},
    {'x', "0i4c 0c4i"},
    {'y', "0i2c 4i1a"},
    {'z', "0i4i0c4c"},
    {'|', "0l0b"},
    {0xB0, "@0k2k2h0h"},                    // degree
    {0xB1, "0g4g 2e2i 0c4c"},               // plus-minus
    {0xB2, "~0j0k2k2j0h 0h2h"},             // squared
    {0xB7, "0f0f"},                         // times, as a dot
    {0xD7, "0d4h 0h4d"},                    // times
    {0x394, "0c3k6c0c"},                    // Delta
    {0x3A3, "6k0k3g0c6c"},                  // Sigma
    {0x3B1, "~6i4c0c0i4i6c"},               // alpha
    {0x3B2, "0a0i ~0i0k4k4g1g ~1g5g5c0c"},  // beta
    {0x3B4, "@0i5i5c0c ~4k1k1i4g"},         // delta
    {0x3B8, "@0k5k5c0c 0g5g"},              // theta
    {0x3BB, "0k1k5c 3g0c"},                 // lambda
    {0x3BC, "0a0i 0f0e ~0e0c4c4f 4i4c"},    // mu
    {0x3C0, "0i6i 1i1c 5i5c"},              // pi
    {0x3C1, "0a0f ~0f0i5i5c0c0f"},          // rho
    {0x3C3, "@0i5i5c0c 2i6i"},              // sigma
    {0x3C6, "@0i6i6c0c 3k3a"},              // phi
    {0x3C7, "0i5a 5i0a"},                   // chi
    {0x3C9, "~1i0i0c3c3f ~3f3c6c6i5i"},     // omega
    {0x2013, "0f4f"},                       // dash
    {0x2080, "@0e2e2a0a"},                  // digits below the line
    {0x2081, "0d1e1a"},
    {0x2082, "~0d0e2e2c0a 0a2a"},
    {0x2083, "~0d0e2e2c1c ~1c2c2a0a0b"},
    {0x2192, "0f7f 5h7f5d"},  // arrow
    {0x2212, "0f5f"},         // minus
    {0x221A, "0f1f2c4l8l"},   // root
};
constexpr const char* kUnknown = "0c0k4k4c0c";
constexpr double kUnit = 0.09, kNarrow = 0.92;  // ems a step of the grid; across
constexpr double kGap = 1.9, kBlank = 3.2;      // steps between letters, width of a blank

/// The next code point; a broken byte counts as itself.
std::uint32_t next_letter(std::string_view& text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const std::size_t length = byte(0) < 0x80 ? 1 : byte(0) >= 0xE0 ? 3 : byte(0) >= 0xC0 ? 2 : 1;
  std::uint32_t letter = byte(0);
  if (length > 1 && text.size() >= length) {
    letter &= length == 2 ? 0x1F : 0x0F;
    for (std::size_t i = 1; i < length; ++i) letter = letter << 6 | (byte(i) & 0x3F);
  }
  text.remove_prefix(std::min(length, text.size()));
  return letter;
}

std::vector<Point> cut_corners(const std::vector<Point>& points, bool closed) {
  std::vector<Point> cut;
  const std::size_t n = points.size();
  if (!closed) cut.push_back(points.front());
  for (std::size_t i = 0; i + (closed ? 0 : 1) < n; ++i) {
    const Point a = points[i], b = points[(i + 1) % n];
    if (closed || i > 0) cut.push_back({0.75 * a.x + 0.25 * b.x, 0.75 * a.y + 0.25 * b.y});
    if (closed || i + 2 < n) cut.push_back({0.25 * a.x + 0.75 * b.x, 0.25 * a.y + 0.75 * b.y});
  }
  if (!closed) cut.push_back(points.back());
  return cut;
}

std::vector<std::vector<Point>> lines_of(std::string_view glyph) {
  std::vector<std::vector<Point>> lines;
  while (!glyph.empty()) {
    const std::string_view word = glyph.substr(0, glyph.find(' '));
    glyph.remove_prefix(std::min(glyph.size(), word.size() + 1));
    const bool closed = word[0] == '@', bent = closed || word[0] == '~';
    std::vector<Point> line;
    for (std::size_t i = bent ? 1 : 0; i + 1 < word.size(); i += 2)
      line.push_back({double(word[i] - '0'), double(word[i + 1] - 'c')});
    for (int round = 0; bent && round < 4; ++round) line = cut_corners(line, closed);
    if (closed) line.push_back(line.front());
    lines.push_back(std::move(line));
  }
  return lines;
}

const char* glyph_of(std::uint32_t letter) {
  const auto found = kGlyphs.find(letter);
  return found == kGlyphs.end() ? kUnknown : found->second;
}

/// Both for the strokes and for their width: `draw` gets the lines and where the letter begins.
template <class Draw>
double set(std::string_view text, Draw&& draw) {
  double x = 0, end = 0;
  while (!text.empty()) {
    const std::string_view glyph = glyph_of(next_letter(text));
    double wide = 0;
    for (std::size_t i = 0; i < glyph.size(); ++i)
      if (glyph[i] >= '0' && glyph[i] <= '9') wide = std::max(wide, double(glyph[i] - '0'));
    draw(glyph, x);
    if (!glyph.empty()) end = x + wide;
    x += glyph.empty() ? kBlank : wide + kGap;
  }
  return end;
}

}  // namespace

std::vector<std::vector<Point>> letter_strokes(std::string_view text, double size) {
  std::vector<std::vector<Point>> all;
  const double across = kUnit * kNarrow * size, up = kUnit * size;
  set(text, [&](std::string_view glyph, double x) {
    for (std::vector<Point>& line : lines_of(glyph)) {
      for (Point& p : line) p = {(p.x + x) * across, -p.y * up};
      all.push_back(std::move(line));
    }
  });
  return all;
}

double text_width(std::string_view text, double size) {
  return kUnit * kNarrow * size * set(text, [](std::string_view, double) {});
}

}  // namespace majak::draw
