// SPDX-License-Identifier: Apache-2.0
#include "majak/map/intensity.hpp"

#include <algorithm>
#include <cmath>

#include "majak/core/error.hpp"
#include "majak/map/scan_choice.hpp"

namespace majak::map {
namespace {

Vec2 end_of(const Scan& scan, std::size_t beam) {
  const double angle = scan.angle(beam);
  return static_cast<double>(scan.ranges[beam]) * Vec2(std::cos(angle), std::sin(angle));
}

bool measured(const Scan& scan, std::size_t beam, const IntensityOptions& o) {
  const double r = scan.ranges[beam];
  return r >= o.min_range && r <= o.max_range && scan.intensities[beam] > 0 &&
         std::isfinite(scan.intensities[beam]);
}

/// Piecewise linear between values at even or given knots, level outside.
double between_knots(const std::vector<double>& values, double position) {
  const double last = static_cast<double>(values.size() - 1);
  const double at = std::clamp(position, 0.0, last);
  const auto i = std::min(static_cast<std::size_t>(at), values.size() - 2);
  const double share = at - static_cast<double>(i);
  return values[i] * (1 - share) + values[i + 1] * share;
}

}  // namespace

void describe(OptionFields& fields, IntensityOptions& o) {
  fields.add("intensity.resolution", o.resolution, {"m", "side of a cell", 0.005, 10});
  fields.add("intensity.min_range", o.min_range, {"m", "nearer returns are left out", 0, 100});
  fields.add("intensity.max_range", o.max_range, {"m", "farther returns are left out", 0.1, 1000});
  fields.add("intensity.steepest", o.steepest,
             {"rad", "surfaces met flatter than this are left out", 0.1, 1.57});
  fields.add("intensity.surface_gap", o.surface_gap,
             {"m", "between neighbouring returns of one surface at most", 0.001, 10});
  fields.add("intensity.cell_sigma", o.cell_sigma,
             {"1", "of the surfaces' log-brightness", 0.01, 10});
  fields.add("intensity.echo_sigma", o.echo_sigma, {"1", "of an echo's log-strength", 0.001, 10});
  fields.add("intensity.smoothness", o.smoothness, {"1", "weight of a bend of a curve", 1e-6, 1e6});
  fields.add("intensity.scan_spacing", o.scan_spacing,
             {"m", "a scan nearer to the last one taken is left out unless it turned", 0, 100});
  fields.add("intensity.scan_turn", o.scan_turn,
             {"rad", "a scan turned less is left out unless it moved", 0, 4});
}

double EchoResponse::normalized(double intensity, double range, double cos_slant) const {
  const double per_knot = range_knots[1] - range_knots[0];
  const double away = between_knots(by_range, (std::log(range) - range_knots[0]) / per_knot) +
                      between_knots(by_slant, cos_slant * static_cast<double>(by_slant.size() - 1));
  return std::exp(std::log(intensity) - away - brightness);
}

std::vector<SurfaceEcho> surface_echoes(const Scan& scan, const IntensityOptions& options) {
  std::vector<SurfaceEcho> echoes;
  if (scan.intensities.size() != scan.ranges.size() || scan.ranges.size() < 3) return echoes;
  const double flattest = std::cos(options.steepest);
  for (std::size_t i = 1; i + 1 < scan.ranges.size(); ++i) {
    if (!measured(scan, i - 1, options) || !measured(scan, i, options) ||
        !measured(scan, i + 1, options))
      continue;
    const Vec2 here = end_of(scan, i), way = end_of(scan, i + 1) - end_of(scan, i - 1);
    const Vec2 back = here - end_of(scan, i - 1), on = end_of(scan, i + 1) - here;
    if (std::max(back.norm(), on.norm()) > options.surface_gap || way.norm() < 1e-9) continue;
    const Vec2 u = here.normalized();
    const double cos_slant = std::abs(u.x() * way.y() - u.y() * way.x()) / way.norm();
    if (cos_slant >= flattest)
      echoes.push_back({i, static_cast<double>(scan.ranges[i]), cos_slant,
                        static_cast<double>(scan.intensities[i])});
  }
  return echoes;
}

double IntensityMap::sigma(int ix, int iy) const {
  const Cell& cell = cells_(ix, iy);
  return cell.echoes > 1 ? std::sqrt(double{cell.squares} / (double{cell.echoes} - 1)) : 0;
}

CellBox IntensityMap::bounds() const {
  return cells_.bounds([](const Cell& c) { return c.echoes > 0; });
}

IntensityMap build_intensity_map(const Site& site, const EchoResponse& response,
                                 const IntensityOptions& options) {
  IntensityMap map;
  map.resolution_ = options.resolution;
  for (const std::size_t s : scans_to_draw(site, {options.resolution, options.max_range,
                                                  options.scan_spacing, options.scan_turn})) {
    const Scan& scan = site.scans[s].scan;
    const Pose2 T_map_laser = site.scans[s].estimate.T_map_robot * scan.T_robot_laser;
    for (const SurfaceEcho& echo : surface_echoes(scan, options)) {
      const Vec2 p = T_map_laser * end_of(scan, echo.beam) / options.resolution;
      IntensityMap::Cell& cell =
          map.cells_(static_cast<int>(std::floor(p.x())), static_cast<int>(std::floor(p.y())));
      const double value = response.normalized(echo.intensity, echo.range, echo.cos_slant);
      const double off = value - double{cell.mean};  // Welford
      cell.echoes += 1;
      const double mean = double{cell.mean} + off / double{cell.echoes};
      cell.squares += static_cast<float>(off * (value - mean));
      cell.mean = static_cast<float>(mean);
    }
  }
  return map;
}

std::vector<BrightnessEdge> find_brightness_edges(const Scan& scan, const EchoResponse& response,
                                                  const IntensityOptions& options, double ratio,
                                                  int beams) {
  const std::vector<SurfaceEcho> echoes = surface_echoes(scan, options);
  const auto side = static_cast<std::size_t>(std::max(beams, 1));
  std::vector<double> logs(echoes.size()), steps(echoes.size(), 0);
  for (std::size_t i = 0; i < echoes.size(); ++i)
    logs[i] =
        std::log(response.normalized(echoes[i].intensity, echoes[i].range, echoes[i].cos_slant));
  // steps[i]: from the echoes up to i to those after it, where all are neighbours.
  for (std::size_t i = side - 1; i + side < echoes.size(); ++i) {
    if (echoes[i + side].beam - echoes[i + 1 - side].beam != 2 * side - 1) continue;
    for (std::size_t k = 0; k < side; ++k) steps[i] += logs[i + 1 + k] - logs[i - k];
    steps[i] /= static_cast<double>(side);
  }
  std::vector<BrightnessEdge> edges;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (std::abs(steps[i]) < std::log(ratio)) continue;
    const std::size_t low = i < side ? 0 : i - side, high = std::min(i + side, steps.size() - 1);
    bool sharpest = true;
    for (std::size_t k = low; k <= high; ++k)
      sharpest &= k == i || (k < i ? std::abs(steps[k]) < std::abs(steps[i])
                                   : std::abs(steps[k]) <= std::abs(steps[i]));
    if (!sharpest) continue;
    edges.push_back({static_cast<double>(echoes[i].beam) + 0.5,
                     0.5 * (end_of(scan, echoes[i].beam) + end_of(scan, echoes[i + 1].beam)),
                     std::exp(steps[i])});
  }
  return edges;
}

}  // namespace majak::map
