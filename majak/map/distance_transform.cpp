// SPDX-License-Identifier: Apache-2.0
#include "majak/map/distance_transform.hpp"

#include <algorithm>

#include "majak/core/error.hpp"

namespace majak::map {
namespace {

constexpr int kLongestSide = 32767;  // twice its square fits 32 bits
constexpr int kStripe = 256;         // columns that a thread goes down together, side by side
constexpr int kRows = 16;            // rows of one piece of work

// row = min(row, next + 1)
void take_nearer(std::uint16_t* row, const std::uint16_t* next, int n) {
  for (int x = 0; x < n; ++x) {
    const auto by_next = static_cast<std::uint16_t>(next[x] + 1);
    row[x] = by_next < row[x] ? by_next : row[x];
  }
}

// Columns [begin, end): down, then up.
void go_along_columns(const CellMask& marked, int begin, int end, std::uint16_t cap,
                      std::uint16_t* out) {
  for (int y = 0; y < marked.height; ++y) {
    const std::uint8_t* mark = marked.cells.data() + marked.index(0, y);
    std::uint16_t* row = out + marked.index(0, y);
    for (int x = begin; x < end; ++x) row[x] = mark[x] != 0 ? std::uint16_t{0} : cap;
    if (y > 0) take_nearer(row + begin, row + begin - marked.width, end - begin);
  }
  for (int y = marked.height - 2; y >= 0; --y) {
    std::uint16_t* row = out + marked.index(0, y) + begin;
    take_nearer(row, row + marked.width, end - begin);
  }
}

// The parabola over x, height + (x - its x)^2.
struct Parabola {
  std::int64_t x, height;
  std::int64_t at(std::int64_t where) const { return height + (where - x) * (where - x); }
};

// Does v lie nowhere below both u, left of it, and w, right of it?
bool hidden(const Parabola& u, const Parabola& v, const Parabola& w) {
  const std::int64_t a = v.x - u.x, b = w.x - v.x, c = a + b;
  return c * v.height - b * u.height - a * w.height >= a * b * c;
}

// Lower envelope of the parabolas over a row whose columns say `column`, `far` for none.
void envelope(const std::uint16_t* column, int width, int far, std::vector<Parabola>& scratch,
              std::int32_t* out) {
  Parabola* p = scratch.data();
  int n = 0;
  for (int x = 0; x < width; ++x) {
    if (column[x] == far) continue;
    const Parabola next{x, std::int64_t{column[x]} * column[x]};
    while (n >= 2 && hidden(p[n - 2], p[n - 1], next)) --n;
    p[n++] = next;
  }
  if (n == 0) {
    std::fill(out, out + width, kNoneMarked);
    return;
  }
  int i = 0;
  for (int x = 0; x < width; ++x) {
    while (i + 1 < n && p[i + 1].at(x) <= p[i].at(x)) ++i;
    out[x] = static_cast<std::int32_t>(p[i].at(x));
  }
}

}  // namespace

void require_valid(const CellMask& mask) {
  if (mask.width < 0 || mask.height < 0 || std::max(mask.width, mask.height) > kLongestSide)
    throw Error("grid: its sides must be 0 to 32767 cells");
  if (mask.cells.size() != mask.index(0, mask.height))
    throw Error("grid: as many cells as width x height are needed");
}

std::unique_ptr<std::uint16_t[]> column_distances(const CellMask& marked, int cap,
                                                  Threads threads) {
  require_valid(marked);
  // Left unfilled: the threads are the first to touch it.
  auto out = std::make_unique_for_overwrite<std::uint16_t[]>(marked.cells.size());
  const auto most = static_cast<std::uint16_t>(std::clamp(cap, 0, kLongestSide));
  const int stripes = (marked.width + kStripe - 1) / kStripe;
  parallel_for(threads, static_cast<std::size_t>(stripes), [&](std::size_t k) {
    const int begin = static_cast<int>(k) * kStripe;
    go_along_columns(marked, begin, std::min(begin + kStripe, marked.width), most, out.get());
  });
  return out;
}

std::vector<std::int32_t> squared_distances(const CellMask& marked, Threads threads) {
  // No two cells of a column are as far apart as it is high.
  const auto columns = column_distances(marked, marked.height, threads);
  std::vector<std::int32_t> out(marked.cells.size());
  const int pieces = (marked.height + kRows - 1) / kRows;
  parallel_for(threads, static_cast<std::size_t>(pieces), [&](std::size_t k) {
    std::vector<Parabola> scratch(static_cast<std::size_t>(marked.width));
    const int begin = static_cast<int>(k) * kRows;
    for (int y = begin; y < std::min(begin + kRows, marked.height); ++y)
      envelope(columns.get() + marked.index(0, y), marked.width, marked.height, scratch,
               out.data() + marked.index(0, y));
  });
  return out;
}

}  // namespace majak::map
