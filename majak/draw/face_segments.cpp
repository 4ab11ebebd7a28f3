// SPDX-License-Identifier: Apache-2.0
// Walls as straight pieces.
#include <algorithm>
#include <cmath>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/draw/face.hpp"
#include "majak/draw/face_figure.hpp"
#include "majak/draw/sketch.hpp"
#include "majak/io/segment_files.hpp"
#include "majak/map/edits.hpp"

namespace majak::draw {

FacePage segments_page(const std::vector<map::Segment>& walls,
                       const std::vector<std::vector<Vec2>>& forbidden) {
  if (walls.empty())
    throw Error("no straight piece has returns enough; try --set refinement.min_returns=20");
  double length = 0;
  std::vector<Mark> marks;
  std::vector<Point> ends;
  std::vector<double> sigmas;
  for (const map::Segment& wall : walls) {
    marks.emplace_back(Polyline{{point(wall.a), point(wall.b)}, {ink::blue, 1.6}});
    ends.push_back(point(wall.a)), ends.push_back(point(wall.b));
    length += wall.length();
    sigmas.push_back(std::sqrt(wall.covariance(0, 0)));
  }
  for (const std::vector<Vec2>& zone : forbidden) {
    std::vector<Point> outline;
    for (const Vec2& p : zone) outline.push_back(point(p));
    marks.emplace_back(Polyline{std::move(outline), {ink::red, 1.2}, true});
  }
  marks.emplace_back(Dots{ends, 1.8, ink::red});
  std::nth_element(sigmas.begin(), sigmas.begin() + static_cast<std::ptrdiff_t>(sigmas.size() / 2),
                   sigmas.end());
  FacePage page;
  page.lead = "Each straight surface once, however often it was seen, with its covariance.";
  page.bytes = walls.size() * 4 * sizeof(double);
  page.figures = {{"segments", static_cast<double>(walls.size())},
                  {"length_m", length},
                  {"sigma_offset_median_m", sigmas[sigmas.size() / 2]}};
  page.figure = map_sheet("Segments", std::move(marks));
  page.files = {{"walls.dxf", io::segments_dxf(walls, forbidden)},
                {"walls.svg", io::segments_svg(walls, forbidden)},
                {"walls.geojson", io::segments_geojson(walls, forbidden)},
                {"walls.wkt", io::segments_wkt(walls, forbidden)}};
  return page;
}

FacePage segments_face(const Site& site, const FaceOptions& o) {
  return segments_page(map::build_segments(site, o.segments, nullptr, o.known_walls).walls(),
                       map::shapes_in_map(site, EditKind::forbidden));
}

FacePage contours_page(const map::KnownMap& map, const Pose2& T_world_map) {
  std::vector<map::Segment> walls = map::contour_segments(map);
  const map::ConversionError error = map::conversion_error(map, walls);
  for (map::Segment& wall : walls) wall = map::moved(T_world_map, wall);
  FacePage page = segments_page(walls);
  page.figures.emplace_back("cells_missed_percent", 100 * error.missed);
  page.figures.emplace_back("cells_added_percent", 100 * error.added);
  return page;
}

}  // namespace majak::draw
