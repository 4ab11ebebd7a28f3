// SPDX-License-Identifier: Apache-2.0
// Intensity layer: how bright surfaces are, not how much light came back. Received energy falls
// with range and slant, so that a dark thing near by equals a bright one far off; how it falls is
// learnt from the log itself, by surfaces seen from more than one place (docs/MATH.md 18).
//
//   const EchoResponse response = learn_echo_response(site);
//   const IntensityMap layer = build_intensity_map(site, response);
//   for (const BrightnessEdge& e : find_brightness_edges(scan, response)) ...   // ends of strips
#pragma once

#include <cstddef>
#include <vector>

#include "majak/core/options.hpp"
#include "majak/core/site.hpp"
#include "majak/map/tiles.hpp"

namespace majak::map {

struct IntensityOptions {
  double resolution = 0.05;    ///< m, side of a cell
  double min_range = 0.2;      ///< m, nearer returns are left out
  double max_range = 30.0;     ///< m
  double steepest = 1.3;       ///< rad, returns from surfaces met flatter than this are left out
  double surface_gap = 0.3;    ///< m, along the surface between neighbours of one surface
  double cell_sigma = 0.7;     ///< of the surfaces' log-brightness about their mean
  double echo_sigma = 0.1;     ///< of one echo's log-strength; a Huber loss from twice of it on
  double smoothness = 1.0;     ///< weight of a bend of the curves, in squared log per echo
  double scan_spacing = 0.15;  ///< m, as for occupancy grids
  double scan_turn = 0.15;     ///< rad
};
void describe(OptionFields& fields, IntensityOptions& options);

/// How the strength of an echo hangs on range and slant: log-strength = log-brightness +
/// by_range(log r) + by_slant(cos). Both run straight between knots.
struct EchoResponse {
  std::vector<double> range_knots;  ///< log of m, ascending
  std::vector<double> by_range;     ///< nats; 0 in the mean over the echoes it was learnt from
  std::vector<double> by_slant;     ///< nats, at cosines from 0 to 1 in even steps; 0 at 1
  double brightness = 0;            ///< nats, mean of the log-brightness of all surfaces

  /// Brightness of a surface: 1 is what the log's surfaces have in the (geometric) mean.
  double normalized(double intensity, double range, double cos_slant) const;
};

/// An echo on a surface that its neighbours show as well.
struct SurfaceEcho {
  std::size_t beam = 0;
  double range = 0, cos_slant = 1, intensity = 0;
};
/// Those of one scan, by beam. None where it has no intensities.
std::vector<SurfaceEcho> surface_echoes(const Scan& scan, const IntensityOptions& options = {});

/// Throws Error when no scan has intensities, or an option is out of its range.
EchoResponse learn_echo_response(const Site& site, const IntensityOptions& options = {});

class IntensityMap {
 public:
  struct Cell {
    float echoes = 0;
    float mean = 0;     ///< brightness, 1: as the log's surfaces in the mean
    float squares = 0;  ///< sum of squared deviations from the mean
  };

  double resolution() const { return resolution_; }
  bool known(int ix, int iy) const { return cells_(ix, iy).echoes > 0; }
  /// Of the brightness of the echoes from the cell; 0 where there are none.
  double mean(int ix, int iy) const { return cells_(ix, iy).mean; }
  /// Standard deviation of a single echo; 0 where there are fewer than two.
  double sigma(int ix, int iy) const;
  double echoes(int ix, int iy) const { return cells_(ix, iy).echoes; }
  CellBox bounds() const;
  std::size_t bytes() const { return sizeof(*this) + cells_.bytes(); }
  const Tiles<Cell>& cells() const { return cells_; }

 private:
  friend IntensityMap build_intensity_map(const Site&, const EchoResponse&,
                                          const IntensityOptions&);
  double resolution_ = 0.05;
  Tiles<Cell> cells_;
};

IntensityMap build_intensity_map(const Site& site, const EchoResponse& response,
                                 const IntensityOptions& options = {});

/// Where a surface turns from dark to bright or back.
struct BrightnessEdge {
  double beam = 0;   ///< between two beams: k + 0.5
  Vec2 at;           ///< m, laser's frame: between the echoes of the two
  double ratio = 1;  ///< brightness after over brightness before, in the order of beams
};
/// `ratio`: the least, either way, that counts; `beams`: on either side that are looked at. All of
/// them have to be on one surface.
std::vector<BrightnessEdge> find_brightness_edges(const Scan& scan, const EchoResponse& response,
                                                  const IntensityOptions& options = {},
                                                  double ratio = 1.8, int beams = 3);

}  // namespace majak::map
