// SPDX-License-Identifier: Apache-2.0
#include "majak/map/forward_cells.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "majak/map/forward_grid.hpp"

namespace majak::map {
namespace {

constexpr int kTileBits = ForwardCells::kTileBits;
constexpr int kMask = ForwardCells::kTileSize - 1;

std::uint64_t tile_key(int tx, int ty) {
  return (std::uint64_t{static_cast<std::uint32_t>(tx)} << 32) | static_cast<std::uint32_t>(ty);
}

std::uint32_t cell_in_tile(int ix, int iy) {
  return static_cast<std::uint32_t>(((iy & kMask) << kTileBits) | (ix & kMask));
}

/// Calls visit(ix, iy) for the cell under the middle of each step. In fixed point: floor() costs
/// more than the rest.
template <class Visit>
void for_each_step(const BeamLine& line, int steps, Visit visit) {
  const auto fixed = [](double cells) {
    return static_cast<std::int64_t>(std::llround(cells * 0x1p32));
  };
  std::int64_t x = fixed(line.from.x() + 0.5 * line.step.x()),
               y = fixed(line.from.y() + 0.5 * line.step.y());
  const std::int64_t dx = fixed(line.step.x()), dy = fixed(line.step.y());
  for (int k = 0; k < steps; ++k, x += dx, y += dy)
    visit(static_cast<int>(x >> 32), static_cast<int>(y >> 32));
}

/// Sum over the first `steps` cells, in four strands that need not wait for each other.
double log_passed(const double* log_pass, const std::uint32_t* path, int steps) {
  double a = 0, b = 0, c = 0, d = 0;
  int k = 0;
  for (; k + 4 <= steps; k += 4) {
    a += log_pass[path[k]];
    b += log_pass[path[k + 1]];
    c += log_pass[path[k + 2]];
    d += log_pass[path[k + 3]];
  }
  for (; k < steps; ++k) a += log_pass[path[k]];
  return (a + b) + (c + d);
}

}  // namespace

std::uint32_t ForwardCells::tile(int tx, int ty) const {
  const auto found = first.find(tile_key(tx, ty));
  return found == first.end() ? 0 : found->second;
}

void ForwardCells::add_tile(int tx, int ty) {
  if (!first.try_emplace(tile_key(tx, ty), static_cast<std::uint32_t>(stop.size())).second) return;
  places.push_back({tx, ty});
  stop.resize(stop.size() + kTileCells, stop[0]);
  log_pass.resize(log_pass.size() + kTileCells, log_pass[0]);
}

std::uint32_t ForwardCells::index(int ix, int iy) const {
  const std::uint32_t base = tile(ix >> kTileBits, iy >> kTileBits);
  return base == 0 ? 0 : base + cell_in_tile(ix, iy);
}

void ForwardCells::set(std::size_t cell, double stop_probability) {
  stop[cell] = stop_probability;
  log_pass[cell] = std::log1p(-stop_probability);
}

void cells_on(const ForwardCells& cells, const BeamLine& line, int steps, std::uint32_t* path,
              std::size_t pitch) {
  int tx = 0, ty = 0;
  std::uint32_t base = 0, inside = 0;
  bool begun = false;
  for_each_step(line, steps, [&](int ix, int iy) {
    if (!begun || ix >> kTileBits != tx || iy >> kTileBits != ty) {
      begun = true;
      tx = ix >> kTileBits;
      ty = iy >> kTileBits;
      base = cells.tile(tx, ty);
      inside = base == 0 ? 0 : ~std::uint32_t{0};
    }
    *path = base + (cell_in_tile(ix, iy) & inside);
    path += pitch;
  });
}

void tiles_on(const BeamLine& line, int steps, std::vector<ForwardCells::Place>& tiles) {
  for_each_step(line, steps, [&](int ix, int iy) {
    const ForwardCells::Place place{ix >> kTileBits, iy >> kTileBits};
    if (tiles.empty() || !(tiles.back() == place)) tiles.push_back(place);
  });
}

BeamReading read_beam(double range, bool stopped, double step, double window) {
  BeamReading reading{range, stopped};
  if (!stopped) {
    reading.before = reading.steps = static_cast<int>(std::floor(range / step + 0.5));
    return reading;
  }
  // Step k has its middle at (k + 1/2) step.
  reading.before = std::max(0, static_cast<int>(std::ceil((range - window) / step - 0.5)));
  reading.steps = static_cast<int>(std::floor((range + window) / step - 0.5)) + 1;
  return reading;
}

BeamCause explain(const ForwardCells& cells, const ForwardModel& model, const BeamReading& reading,
                  double max_range, const std::vector<std::uint32_t>& path,
                  std::vector<double>& stops) {
  const double mapped = 1 - model.random - model.none;
  const double arrives =
      std::exp(log_passed(cells.log_pass.data(), path.data(), reading.before * reading.rays));
  BeamCause cause;
  if (!reading.stopped) {  // (17.3)
    const double p = mapped * arrives + model.none;
    cause.log_likelihood = std::log(p);
    cause.seen = mapped * arrives / p;
    return cause;
  }
  // (17.2). The normal density from step to step: its ratio changes by a constant factor.
  const double step = cells.step(), per_variance = 1 / (model.sigma * model.sigma);
  const double off = reading.range - (reading.before + 0.5) * step;
  double density =
      std::exp(-0.5 * off * off * per_variance) / (model.sigma * std::sqrt(2 * std::numbers::pi));
  double ratio = std::exp((off - 0.5 * step) * step * per_variance);
  const double change = std::exp(-step * step * per_variance);
  double left = mapped * arrives, sum = 0, squares = 0, miss = off;
  const auto rays = static_cast<std::size_t>(reading.rays);
  stops.resize(static_cast<std::size_t>(reading.steps - reading.before) * rays);
  const std::uint32_t* cell = path.data() + static_cast<std::size_t>(reading.before) * rays;
  for (std::size_t k = 0; k < stops.size();) {
    for (const std::size_t next = k + rays; k < next; ++k) {
      const double stop = cells.stop[cell[k]];
      stops[k] = left * stop * density;
      sum += stops[k];
      squares += stops[k] * miss * miss;
      left *= 1 - stop;
    }
    density *= ratio;
    ratio *= change;
    miss -= step;
  }
  const double p = sum + model.random / max_range;
  for (double& s : stops) s /= p;
  return {std::log(p), sum / p, squares / p};
}

}  // namespace majak::map
