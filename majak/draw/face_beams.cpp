// SPDX-License-Identifier: Apache-2.0
// Faces that take a beam for what it is: the forward model, and how bright its echo was.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "majak/draw/face.hpp"
#include "majak/draw/face_figure.hpp"
#include "majak/io/map_files.hpp"

namespace majak::draw {
namespace {

/// Mean of stop_sigma() over the cells that rather stop a beam than not.
double mean_sigma(const map::ForwardGrid& grid) {
  const map::CellBox box = grid.bounds();
  double sum = 0, cells = 0;
  for (int iy = box.y0; iy < box.y0 + box.height; ++iy)
    for (int ix = box.x0; ix < box.x0 + box.width; ++ix)
      if (grid.known(ix, iy) && grid.stop(ix, iy) > 0.5) sum += grid.stop_sigma(ix, iy), ++cells;
  return sum / std::max(cells, 1.0);
}

/// From blue (an eighth of the mean brightness and darker) by grey to red (eight times).
Colour warmth_of(double brightness) {
  const double at = std::clamp(std::log2(std::max(brightness, 1e-9)) / 3, -1.0, 1.0);
  const Colour end = at < 0 ? ink::blue : ink::red, middle{190, 190, 190};
  const auto mix = [&](std::uint8_t a, std::uint8_t b) {
    return static_cast<std::uint8_t>(std::lround(a + (b - a) * std::abs(at)));
  };
  return {mix(middle.r, end.r), mix(middle.g, end.g), mix(middle.b, end.b)};
}

}  // namespace

FacePage forward_face(const Site& site, const FaceOptions& o) {
  const map::ForwardGrid forward = map::build_forward_grid(site, o.forward, o.threads);
  const map::OccupancyGrid grid = forward.log_odds();
  const io::MapFrame frame = io::frame_of(grid);
  FacePage page;
  page.lead =
      "The darker, the likelier a beam ends there; unknown is grey. All cells together are the map "
      "under which all that was measured is likeliest: a return is explained by one cell, and "
      "takes "
      "nothing from the free ones beside it.";
  page.bytes = forward.bytes();
  page.figures = {{"cell_m", forward.resolution()},
                  {"known_area_m2", forward.known_area()},
                  {"scans_drawn", static_cast<double>(forward.scans_drawn())},
                  {"rounds", static_cast<double>(forward.posterior().size())},
                  {"log_likelihood_of_a_beam_nat",
                   forward.score().log_likelihood /
                       static_cast<double>(std::max<std::size_t>(forward.score().beams, 1))},
                  {"range_sigma_m", forward.model().sigma},
                  {"astray_share", forward.model().random},
                  {"stop_sigma_of_walls", mean_sigma(forward)}};
  page.figure = map_sheet("Forward model", {grid_picture(grid)});
  page.files = {{"forward.pgm", io::pgm_text(io::trinary_map(grid, frame))},
                {"forward.yaml", io::map_yaml(frame, "forward.pgm")}};
  return page;
}

FacePage intensity_face(const Site& site, const FaceOptions& o) {
  const map::EchoResponse response = map::learn_echo_response(site, o.intensity);
  const map::IntensityMap layer = map::build_intensity_map(site, response, o.intensity);
  double cells = 0, spread = 0;
  std::string table = "x_m,y_m,brightness,sigma,echoes\n";
  layer.cells().for_each([&](int ix, int iy, const map::IntensityMap::Cell& cell) {
    if (!(cell.echoes > 0)) return;
    ++cells, spread += layer.sigma(ix, iy) / std::max(layer.mean(ix, iy), 1e-12);
    table += fmt::format("{:.3f},{:.3f},{:.4g},{:.4g},{}\n", (ix + 0.5) * layer.resolution(),
                         (iy + 0.5) * layer.resolution(), layer.mean(ix, iy), layer.sigma(ix, iy),
                         cell.echoes);
  });
  FacePage page;
  page.lead =
      "Blue surfaces are dark, red ones bright; grey is the mean of this log. What fades with "
      "range "
      "and slant is taken out, as the log itself shows it.";
  page.bytes = layer.bytes();
  page.figures = {{"cell_m", layer.resolution()},
                  {"cells", cells},
                  {"mean_sigma_over_mean", spread / std::max(cells, 1.0)}};
  std::vector<Mark> marks;
  if (auto picture = cells_picture(layer.bounds(), layer.resolution(), [&](int ix, int iy) {
        return layer.known(ix, iy) ? warmth_of(layer.mean(ix, iy)) : ink::white;
      }))
    marks.emplace_back(std::move(*picture));
  page.figure =
      map_sheet("Brightness", std::move(marks),
                {{"an eighth of the mean", {}, ink::blue}, {"eight times", {}, ink::red}});
  page.files = {{"intensity.csv", table}};
  return page;
}

}  // namespace majak::draw
