// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/raster.hpp"

#include <algorithm>
#include <cmath>

namespace majak::draw {
namespace {

constexpr int kRows = 5;  // in which a pixel is cut to find how much of it an area covers

/// The picture's pixels along one axis whose middles lie in [from, to), or the one that holds the
/// middle of it.
struct PixelSpan {
  int first, last;  // half open
  PixelSpan(double from, double to, int size)
      : first(std::clamp(int(std::ceil(from - 0.5)), 0, size)),
        last(std::clamp(int(std::ceil(to - 0.5)), 0, size)) {
    if (first < last) return;
    first = std::clamp(int(std::floor((from + to) / 2)), 0, size - 1);
    last = first + 1;
  }
};

struct Ink {
  double r = 0, g = 0, b = 0, alpha = 0;  // each times alpha, 0 ... 255
};
Ink mean_ink(const io::Image& picture, const PixelSpan& xs, const PixelSpan& ys) {
  const int channels = picture.channels;
  Ink sum;
  for (int y = ys.first; y < ys.last; ++y) {
    const std::uint8_t* p = picture.row(y) + xs.first * channels;
    for (int x = xs.first; x < xs.last; ++x, p += channels) {
      const bool grey = channels == 1;
      const double alpha = channels == 4 ? p[3] / 255.0 : 1;
      sum.r += alpha * p[0], sum.g += alpha * p[grey ? 0 : 1], sum.b += alpha * p[grey ? 0 : 2];
      sum.alpha += alpha;
    }
  }
  const double share = 1.0 / ((xs.last - xs.first) * (ys.last - ys.first));
  return {sum.r * share, sum.g * share, sum.b * share, sum.alpha * share};
}

}  // namespace

Raster::Raster(int width, int height)
    : image_(width, height, 3, 255),
      covered_(image_.pixels.size() / 3, 0.0F),
      clip_{0, 0, double(width), double(height)} {}

Raster::Region Raster::region(std::span<const Point> points, double margin) const {
  double x0 = 1e9, y0 = 1e9, x1 = -1e9, y1 = -1e9;
  for (const Point& p : points) {
    x0 = std::min(x0, p.x), x1 = std::max(x1, p.x);
    y0 = std::min(y0, p.y), y1 = std::max(y1, p.y);
  }
  const double right = std::min(clip_.left + clip_.width, double(image_.width));
  const double bottom = std::min(clip_.top + clip_.height, double(image_.height));
  const double left = std::max(clip_.left, 0.0), top = std::max(clip_.top, 0.0);
  const auto low = [&](double v, double least, double most) {
    return int(std::floor(std::clamp(v - margin, least, std::max(least, most))));
  };
  const auto high = [&](double v, double least, double most) {
    return int(std::ceil(std::clamp(v + margin, std::min(least, most), most)));
  };
  return {low(x0, left, right), low(y0, top, bottom), high(x1, left, right), high(y1, top, bottom)};
}

void Raster::cover_segment(const Point& a, const Point& b, double half) {
  const Point ends[] = {a, b};
  const Region r = region(ends, half + 1);
  const double dx = b.x - a.x, dy = b.y - a.y, length2 = dx * dx + dy * dy;
  for (int y = r.y0; y < r.y1; ++y) {
    for (int x = r.x0; x < r.x1; ++x) {
      const double px = x + 0.5 - a.x, py = y + 0.5 - a.y;
      const double t = length2 > 0 ? std::clamp((px * dx + py * dy) / length2, 0.0, 1.0) : 0.0;
      const double beyond = std::hypot(px - t * dx, py - t * dy) - half;
      float& c = covered(x, y);
      c = std::max(c, float(std::clamp(0.5 - beyond, 0.0, 1.0)));
    }
  }
}

void Raster::line(std::span<const Point> points, double width, const Colour& colour) {
  if (points.empty()) return;
  // What is thinner than a pixel covers as much of it as it is wide.
  const double thin = std::min(width, 1.0), half = std::max(width, 1.0) / 2;
  if (points.size() == 1) cover_segment(points[0], points[0], half);
  for (std::size_t i = 1; i < points.size(); ++i) cover_segment(points[i - 1], points[i], half);
  paint(region(points, half + 1), colour.faint(thin));
}

void Raster::cover_span(double x0, double x1, int y, float share, const Region& r) {
  x0 = std::max(x0, double(r.x0)), x1 = std::min(x1, double(r.x1));
  for (int x = int(std::floor(x0)); x < x1; ++x) {
    const double part = std::min(x1, x + 1.0) - std::max(x0, double(x));
    if (part > 0) covered(x, y) += share * float(part);
  }
}

void Raster::area(std::span<const Point> points, const Colour& colour) {
  if (points.size() < 3) return;
  const Region r = region(points, 1);
  std::vector<double> crossings;
  for (int row = r.y0 * kRows; row < r.y1 * kRows; ++row) {
    const double y = (row + 0.5) / kRows;
    crossings.clear();
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Point &a = points[i], &b = points[(i + 1) % points.size()];
      if ((a.y <= y) == (b.y <= y)) continue;
      crossings.push_back(a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x));
    }
    std::sort(crossings.begin(), crossings.end());
    for (std::size_t i = 0; i + 1 < crossings.size(); i += 2)
      cover_span(crossings[i], crossings[i + 1], row / kRows, 1.0F / kRows, r);
  }
  paint(r, colour);
}

void Raster::picture(const io::Image& picture, const Box& place) {
  if (picture.pixels.empty() || !(place.width > 0 && place.height > 0)) return;
  const double across = picture.width / place.width, down = picture.height / place.height;
  const Point corners[] = {{place.left, place.top},
                           {place.left + place.width, place.top + place.height}};
  const Region r = region(corners, -0.5);  // pixels whose middles lie in it
  for (int y = r.y0; y < r.y1; ++y) {
    const PixelSpan ys((y - place.top) * down, (y + 1 - place.top) * down, picture.height);
    std::uint8_t* pixel = image_.row(y) + 3 * r.x0;
    for (int x = r.x0; x < r.x1; ++x, pixel += 3) {
      const PixelSpan xs((x - place.left) * across, (x + 1 - place.left) * across, picture.width);
      const Ink ink = mean_ink(picture, xs, ys);
      const double under = 1 - ink.alpha;
      pixel[0] = std::uint8_t(std::lround(under * pixel[0] + ink.r));
      pixel[1] = std::uint8_t(std::lround(under * pixel[1] + ink.g));
      pixel[2] = std::uint8_t(std::lround(under * pixel[2] + ink.b));
    }
  }
}

void Raster::paint(const Region& r, const Colour& colour) {
  const double ink[3] = {double(colour.r), double(colour.g), double(colour.b)};
  for (int y = r.y0; y < r.y1; ++y) {
    std::uint8_t* pixel = image_.row(y) + 3 * r.x0;
    for (int x = r.x0; x < r.x1; ++x, pixel += 3) {
      float& c = covered(x, y);
      const double share = colour.alpha * std::min(1.0, double(c));
      for (int k = 0; k < 3; ++k)
        pixel[k] = std::uint8_t(std::lround(pixel[k] + share * (ink[k] - pixel[k])));
      c = 0;
    }
  }
}

}  // namespace majak::draw
