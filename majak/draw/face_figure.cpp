// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/face_figure.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "majak/io/map_files.hpp"

namespace majak::draw {
namespace {

constexpr double kWide = 1000, kLow = 350, kHigh = 1600;  // points
constexpr double kAroundX = 84, kAroundY = 66 + 40;       // points around a panel's inside
constexpr std::size_t kMaxPicture = std::size_t{1} << 22;

struct Extent {
  Point low{1e300, 1e300}, high{-1e300, -1e300};
  void add(const Point& p) {
    if (!std::isfinite(p.x) || !std::isfinite(p.y)) return;
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
};

Extent extent_of(const std::vector<Mark>& marks) {
  Extent extent;
  for (const Mark& mark : marks)
    for (const Point& p : points_of(mark)) extent.add(p);
  return extent;
}

int luminance(const Colour& c) { return 2 * c.r + 5 * c.g + c.b; }

}  // namespace

Figure map_sheet(std::string title, std::vector<Mark> marks, std::vector<LegendEntry> legend) {
  const Extent e = extent_of(marks);
  const double width = e.high.x - e.low.x, height = e.high.y - e.low.y;
  const double high = width > 0 ? (kWide - kAroundX) * height / width + kAroundY : kLow;
  Figure figure{.width = kWide,
                .height = std::round(std::clamp(high, kLow, kHigh)),
                .title = std::move(title)};
  Panel panel{.place = figure.whole(), .x = {"x (m)"}, .y = {"y (m)"}};
  panel.marks = std::move(marks);
  panel.legend = std::move(legend);
  figure.panels.push_back(std::move(panel));
  return figure;
}

std::optional<Picture> cells_picture(const map::CellBox& box, double resolution,
                                     const std::function<Colour(int ix, int iy)>& colour) {
  if (box.width <= 0 || box.height <= 0) return {};
  int n = 1;  // cells along a pixel
  while (static_cast<std::size_t>(box.width / n + 1) *
             static_cast<std::size_t>(box.height / n + 1) >
         kMaxPicture)
    ++n;
  io::Image image((box.width + n - 1) / n, (box.height + n - 1) / n, 3);
  const int right = box.x0 + box.width, top = box.y0 + box.height;
  for (int y = 0; y < image.height; ++y) {
    std::uint8_t* pixel = image.row(image.height - 1 - y);
    for (int x = 0; x < image.width; ++x, pixel += 3) {
      Colour darkest = ink::white;
      for (int iy = box.y0 + y * n; iy < std::min(box.y0 + (y + 1) * n, top); ++iy)
        for (int ix = box.x0 + x * n; ix < std::min(box.x0 + (x + 1) * n, right); ++ix)
          if (const Colour c = colour(ix, iy); luminance(c) < luminance(darkest)) darkest = c;
      pixel[0] = darkest.r, pixel[1] = darkest.g, pixel[2] = darkest.b;
    }
  }
  return Picture{std::move(image), {box.x0 * resolution, box.y0 * resolution}, n * resolution};
}

Picture grid_picture(const map::OccupancyGrid& grid) {
  const io::MapFrame frame = io::frame_of(grid, kMaxPicture);
  return {io::shaded_map(grid, frame), {frame.x0, frame.y0}, frame.pixel};
}

}  // namespace majak::draw
