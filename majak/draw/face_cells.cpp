// SPDX-License-Identifier: Apache-2.0
// Faces made of cells: the returns themselves, the occupancy grid, the grid that a planner wants.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "majak/draw/face.hpp"
#include "majak/draw/face_figure.hpp"
#include "majak/io/map_files.hpp"
#include "majak/map/edits.hpp"
#include "majak/map/known_map.hpp"
#include "majak/map/returns.hpp"

namespace majak::draw {
namespace {

std::size_t bytes_of(const Site& site) {
  std::size_t bytes = site.scans.size() * sizeof(PosedScan);
  for (const PosedScan& posed : site.scans)
    bytes += (posed.scan.ranges.size() + posed.scan.intensities.size()) * sizeof(float);
  return bytes;
}

/// Of one box of cells around everything.
double dense_bytes(const map::CellBox& box) {
  return static_cast<double>(box.width) * static_cast<double>(box.height) * sizeof(std::int16_t);
}

/// White for none, black from kMany on; each doubling is as much darker.
Colour shade_of(std::uint16_t count) {
  constexpr double kMany = 64;
  const double share = std::min(1.0, std::log2(1.0 + count) / std::log2(1 + kMany));
  const auto value = static_cast<std::uint8_t>(std::lround(255 * (1 - share)));
  return {value, value, value};
}

}  // namespace

FacePage sensor_face(const Site& site, const FaceOptions& o) {
  const map::ReturnCounts counts = map::count_returns(site, o.grid.resolution, o.grid.max_range);
  FacePage page;
  page.lead =
      "All returns of all scans at their final poses; nothing is fused and nothing is left out. "
      "The darker, the more.";
  page.bytes = bytes_of(site);
  page.figures = {{"scans", static_cast<double>(site.scans.size())},
                  {"returns", static_cast<double>(counts.returns)},
                  {"beams_without_return", static_cast<double>(counts.no_returns)},
                  {"beams_unknown", static_cast<double>(counts.unknown)}};
  std::vector<Mark> marks;
  const auto box = counts.cells.bounds([](std::uint16_t n) { return n > 0; });
  if (auto picture = cells_picture(box, counts.resolution,
                                   [&](int ix, int iy) { return shade_of(counts.cells(ix, iy)); }))
    marks.emplace_back(std::move(*picture));
  page.figure = map_sheet("Returns", std::move(marks));
  return page;
}

FacePage occupancy_face(const Site& site, const FaceOptions& o) {
  const map::OccupancyGrid grid = map::build_occupancy_grid(site, o.grid, o.threads);
  const io::MapFrame frame = io::frame_of(grid);
  FacePage page;
  page.lead =
      "Black is occupied, white free, grey unknown; between them cells that are not sure. Every "
      "cell is judged on its own: one beam that grazes a door post can close a narrow door.";
  page.bytes = grid.bytes();
  page.figures = {{"cell_m", grid.resolution()},
                  {"known_area_m2", grid.known_area()},
                  {"scans_drawn", static_cast<double>(grid.scans_drawn())},
                  {"dense_B", dense_bytes(grid.bounds())},
                  {"cells_twice_as_wide_B", static_cast<double>(coarser(grid, 2).bytes())},
                  {"cells_four_times_as_wide_B", static_cast<double>(coarser(grid, 4).bytes())}};
  page.figure = map_sheet("Occupancy grid", {grid_picture(grid)});
  page.files = {{"occupancy.pgm", io::pgm_text(io::trinary_map(grid, frame))},
                {"occupancy.yaml", io::map_yaml(frame, "occupancy.pgm")}};
  return page;
}

FacePage inflated_face(const Site& site, const FaceOptions& o) {
  map::KnownMap known = map::known_map(map::build_occupancy_grid(site, o.grid, o.threads));
  const double free_before = known.area(map::CellState::free);
  map::forbid(known, site, map::CellState::occupied);
  const map::CellMask blocked =
      map::inflate(known, map::Disc{o.robot.radius}, o.inflation, o.threads);
  for (std::size_t i = 0; i < known.cells.size(); ++i)
    if (blocked.cells[i] != 0) known.cells[i] = map::CellState::occupied;
  FacePage page;
  page.lead = fmt::format(
      "Black is where the middle of a robot of {} m radius would meet an obstacle: a planner may "
      "take the robot for a point.",
      number(o.robot.radius));
  page.bytes = blocked.cells.size();
  page.figures = {{"robot_radius_m", o.robot.radius},
                  {"free_area_m2", known.area(map::CellState::free)},
                  {"free_area_before_m2", free_before}};
  io::Image picture = io::trinary_map(known);
  page.files = {{"inflated.pgm", io::pgm_text(picture)},
                {"inflated.yaml", io::map_yaml(known, "inflated.pgm")}};
  page.figure = map_sheet("Inflated obstacles",
                          {Picture{std::move(picture), {known.x0, known.y0}, known.resolution}});
  return page;
}

}  // namespace majak::draw
