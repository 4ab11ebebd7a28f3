// SPDX-License-Identifier: Apache-2.0
#include "majak/match/cell_attributes.hpp"

#include <cassert>
#include <cmath>
#include <cstddef>

namespace majak::match {

float CellAttributes::at(const Vec2& p_map) const {
  const double column = std::floor((p_map.x() - x0) / resolution),
               row = std::floor((p_map.y() - y0) / resolution);
  if (!(column >= 0 && column < width && row >= 0 && row < height)) return kNoAttribute;
  return values[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                static_cast<std::size_t>(column)];
}

double ClassSense::operator()(int told, float there) const {
  assert(told >= 0 && told < classes);
  const auto given = [&](int is) {
    return p[static_cast<std::size_t>(is) * static_cast<std::size_t>(classes) +
             static_cast<std::size_t>(told)];
  };
  if (there >= 0 && there < static_cast<float>(classes)) return given(static_cast<int>(there));
  double sum = 0;
  for (int is = 0; is < classes; ++is) sum += given(is);
  return sum / classes;
}

double NumberSense::operator()(double told, float there) const {
  if (std::isnan(there)) return 1 / range;
  const double off = (told - static_cast<double>(there)) / sigma;
  return (1 - random) * std::exp(-off * off / 2) / (std::sqrt(2 * kPi) * sigma) + random / range;
}

}  // namespace majak::match
