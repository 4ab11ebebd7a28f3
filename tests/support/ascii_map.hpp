// SPDX-License-Identifier: Apache-2.0
// A known map that one can see: '#' occupied, ' ' unknown, all else free; the first line is the
// highest row. Lines may be of different lengths.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "majak/map/known_map.hpp"

namespace majak::fixture {

/// Each cell as `times` x `times` of them.
inline std::vector<std::string> finer(const std::vector<std::string>& lines, int times) {
  std::vector<std::string> fine;
  for (const std::string& line : lines) {
    std::string wide;
    for (const char c : line) wide += std::string(static_cast<std::size_t>(times), c);
    for (int k = 0; k < times; ++k) fine.push_back(wide);
  }
  return fine;
}

inline map::KnownMap ascii_map(const std::vector<std::string>& lines, double resolution = 1) {
  map::KnownMap map;
  map.resolution = resolution;
  map.height = static_cast<int>(lines.size());
  for (const std::string& line : lines)
    map.width = std::max(map.width, static_cast<int>(line.size()));
  map.cells.assign(static_cast<std::size_t>(map.width * map.height), map::CellState::unknown);
  for (int row = 0; row < map.height; ++row)
    for (std::size_t x = 0; x < lines[row].size(); ++x)
      map.cells[map.index(static_cast<int>(x), map.height - 1 - row)] =
          lines[row][x] == '#'   ? map::CellState::occupied
          : lines[row][x] == ' ' ? map::CellState::unknown
                                 : map::CellState::free;
  return map;
}

}  // namespace majak::fixture
