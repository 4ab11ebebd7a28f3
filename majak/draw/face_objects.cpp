// SPDX-License-Identifier: Apache-2.0
// Movable objects: what stays in black, and each object in a colour of its own wherever it stood.
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/draw/face.hpp"
#include "majak/draw/face_figure.hpp"
#include "majak/draw/report_page.hpp"
#include "majak/draw/sketch.hpp"
#include "majak/io/map_files.hpp"

namespace majak::draw {
namespace {

constexpr Colour kColours[] = {ink::blue, ink::red, ink::green, ink::orange, ink::purple, ink::sky};

std::string sightings_table(const map::ObjectMap& found) {
  std::string text = "object,visit,x_m,y_m,theta_rad,probability\n";
  for (const map::ObjectSighting& s : found.sightings)
    text += fmt::format("{},{},{:.3f},{:.3f},{:.4f},{:.3f}\n", s.object + 1,
                        found.pieces[s.piece].snapshot + 1, s.T_map_object.x, s.T_map_object.y,
                        s.T_map_object.theta, s.probability);
  return text;
}

/// Objects that were seen on two visits or more.
std::size_t seen_again(const map::ObjectMap& found) {
  std::vector<std::size_t> times(found.objects.size());
  for (const map::ObjectSighting& s : found.sightings) ++times[s.object];
  return static_cast<std::size_t>(
      std::count_if(times.begin(), times.end(), [](std::size_t n) { return n >= 2; }));
}

}  // namespace

FacePage objects_face(const Site& site, const FaceOptions& o) {
  const std::vector<map::Visit> visits = map::split_visits(site, o.visits);
  if (visits.size() < 2)
    throw Error(
        "the run is one visit, and nothing can be seen to have moved; a shorter "
        "visits.longest cuts it");
  const auto maps = map::visit_maps(site, visits, o.grid, o.threads);
  const map::ObjectMap found = map::find_objects(maps, o.objects, o.threads);
  FacePage page;
  const std::size_t again = seen_again(found);
  page.lead = fmt::format("{} visits, by gaps and in parts of {} s at most. ", visits.size(),
                          number(o.visits.longest));
  if (found.pieces.empty())
    page.lead += "Nothing stood anywhere that was free on another visit: no object has moved.";
  else if (again == 0)
    page.lead += fmt::format(
        "{} pieces stood where another visit saw free floor, but no two of them are the same "
        "object: no object is seen to have moved. Pieces that are no object are grey.",
        found.pieces.size());
  else
    page.lead += fmt::format(
        "{} of the {} objects were seen on two visits or more, and so have moved. Pieces that are "
        "no object are grey. People who stood, and doors, can be among them.",
        again, found.objects.size());
  if (found.left_out > 0)
    page.lead +=
        fmt::format(" {} smaller pieces are left out (objects.most_pieces).", found.left_out);
  std::vector<Mark> marks{Picture{
      io::trinary_map(found.still), {found.still.x0, found.still.y0}, found.still.resolution}};
  std::vector<int> object(found.pieces.size(), -1);
  for (const map::ObjectSighting& s : found.sightings) object[s.piece] = static_cast<int>(s.object);
  for (std::size_t k = 0; k < found.pieces.size(); ++k) {
    Dots dots{{}, 1.2, ink::grey};
    if (object[k] >= 0)
      dots.colour = kColours[static_cast<std::size_t>(object[k]) % std::size(kColours)];
    for (const Vec2& p : found.pieces[k].points) dots.at.push_back(point(p));
    marks.emplace_back(std::move(dots));
  }
  for (const map::ObjectSighting& s : found.sightings)
    marks.emplace_back(Label{.at = point(s.T_map_object * found.objects[s.object].middle()),
                             .text = std::to_string(s.object + 1),
                             .anchor = Anchor::middle});
  page.figure = map_sheet("Objects that moved", std::move(marks));
  std::size_t bytes = found.still.cells.size();
  for (const map::ObjectShape& shape : found.objects)
    bytes += 3 * sizeof(float) *
             static_cast<std::size_t>((2 * shape.half() + 1) * (2 * shape.half() + 1));
  page.bytes = bytes;
  page.figures = {{"visits", static_cast<double>(visits.size())},
                  {"pieces", static_cast<double>(found.pieces.size())},
                  {"objects", static_cast<double>(found.objects.size())},
                  {"objects_seen_again", static_cast<double>(again)}};
  page.files = {{"objects.csv", sightings_table(found)}};
  return page;
}

}  // namespace majak::draw
