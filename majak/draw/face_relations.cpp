// SPDX-License-Identifier: Apache-2.0
// How walls lie to each other: corners, openings, what is in line, parallel or square.
#include <fmt/format.h>

#include <array>
#include <string>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/draw/face.hpp"
#include "majak/draw/face_figure.hpp"
#include "majak/draw/sketch.hpp"

namespace majak::draw {
namespace {

using map::RelationKind;

constexpr RelationKind kKinds[] = {RelationKind::parallel, RelationKind::perpendicular,
                                   RelationKind::collinear, RelationKind::corner,
                                   RelationKind::opening};

std::string json_of(const std::vector<map::Segment>& walls,
                    const std::vector<map::Relation>& relations) {
  std::string out = "{\"segments\": [";
  const char* comma = "\n";
  for (const map::Segment& s : walls) {
    out += fmt::format("{}[{:.4f}, {:.4f}, {:.4f}, {:.4f}]", comma, s.a.x(), s.a.y(), s.b.x(),
                       s.b.y());
    comma = ",\n";
  }
  out += "\n], \"relations\": [";
  comma = "\n";
  for (const map::Relation& r : relations) {
    out += fmt::format(
        "{}{{\"kind\": \"{}\", \"first\": {}, \"second\": {}, \"value\": {:.4f}, \"sigma\": "
        "{:.4f}, \"x\": {:.4f}, \"y\": {:.4f}}}",
        comma, map::name_of(r.kind), r.first, r.second, r.value, r.sigma, r.place.x(), r.place.y());
    comma = ",\n";
  }
  return out + "\n]}\n";
}

/// From the middle of one segment to that of the other.
void add_edges(std::vector<Mark>& marks, const std::vector<map::Segment>& walls,
               const std::vector<map::Relation>& relations, RelationKind kind, const Pen& pen) {
  for (const map::Relation& r : relations)
    if (r.kind == kind)
      marks.emplace_back(
          Polyline{{point(walls[r.first].middle()), point(walls[r.second].middle())}, pen});
}

}  // namespace

FacePage relations_face(const Site& site, const FaceOptions& o) {
  const std::vector<map::Segment> walls = map::build_segments(site, o.segments).walls();
  if (walls.empty()) throw Error("no walls, so that nothing lies to anything");
  const std::vector<map::Relation> relations = map::relations(walls, o.relations);
  FacePage page;
  page.lead =
      "Each wall and how it lies to its neighbours: corners are red, openings that one can pass "
      "are "
      "green, walls on one line are joined in orange. Parallel and square ones are in the file.";
  std::vector<Mark> marks;
  for (const map::Segment& wall : walls)
    marks.emplace_back(Polyline{{point(wall.a), point(wall.b)}, {ink::blue, 1.6}});
  add_edges(marks, walls, relations, RelationKind::collinear, {ink::orange, 1});
  Dots corners{{}, 3, ink::red}, openings{{}, 5, ink::green};
  std::array<std::size_t, std::size(kKinds)> counts{};
  for (const map::Relation& r : relations) {
    ++counts[static_cast<std::size_t>(r.kind)];
    if (r.kind == RelationKind::corner) corners.at.push_back(point(r.place));
    if (r.kind == RelationKind::opening) openings.at.push_back(point(r.place));
  }
  marks.emplace_back(std::move(corners));
  marks.emplace_back(std::move(openings));
  page.bytes = relations.size() * sizeof(map::Relation);
  page.figures.emplace_back("segments", static_cast<double>(walls.size()));
  for (const RelationKind kind : kKinds)
    page.figures.emplace_back(map::name_of(kind),
                              static_cast<double>(counts[static_cast<std::size_t>(kind)]));
  page.figure = map_sheet("Relations between walls", std::move(marks),
                          {{"corner", {}, ink::red},
                           {"opening", {}, ink::green},
                           {"on one line", Pen{ink::orange, 1}}});
  page.files = {{"relations.json", json_of(walls, relations)}};
  return page;
}

}  // namespace majak::draw
