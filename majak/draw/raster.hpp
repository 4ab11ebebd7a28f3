// SPDX-License-Identifier: Apache-2.0
// Raster: lines, areas and discs into pixels, each pixel by the share of it that is covered.
// Coordinates are pixels, y downwards; pixel (0, 0) reaches from 0 to 1.
#pragma once

#include <span>
#include <vector>

#include "majak/draw/figure.hpp"

namespace majak::draw {

class Raster {
 public:
  /// White.
  Raster(int width, int height);

  /// Nothing is drawn outside from now on.
  void clip(const Box& box) { clip_ = box; }
  /// A line with round ends and joints; where it crosses itself it is not darker. One point: a dot.
  void line(std::span<const Point> points, double width, const Colour& colour);
  /// The inside, by the even-odd rule.
  void area(std::span<const Point> points, const Colour& colour);

  /// Each pixel in the colour of the picture's pixel that it lies in. Where the picture is finer
  /// than that, in the mean of them.
  void picture(const io::Image& picture, const Box& place);

  io::Image image() && { return std::move(image_); }

 private:
  struct Region {
    int x0, y0, x1, y1;  // half open
  };
  Region region(std::span<const Point> points, double margin) const;
  void cover_segment(const Point& a, const Point& b, double half);
  void cover_span(double x0, double x1, int y, float share, const Region& r);
  void paint(const Region& r, const Colour& colour);
  float& covered(int x, int y) {
    return covered_[static_cast<std::size_t>(y) * static_cast<std::size_t>(image_.width) +
                    static_cast<std::size_t>(x)];
  }

  io::Image image_;
  std::vector<float> covered_;  // by the shape at hand; zero between shapes
  Box clip_;
};

}  // namespace majak::draw
