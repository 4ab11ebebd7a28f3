// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "majak/core/error.hpp"
#include "majak/draw/face.hpp"
#include "majak/draw/report_page.hpp"

namespace majak::draw {
namespace {

constexpr Face kFaces[] = {
    {"sensor", "", "what the laser saw: every return where the robot's pose puts it", sensor_face},
    {"occupancy", "moravec-elfes", "occupied and free cells, each on its own (log-odds)",
     occupancy_face},
    {"forward", "", "the one map under which all beams together are likeliest", forward_face},
    {"intensity", "", "how bright surfaces are, whatever the distance", intensity_face},
    {"inflated", "", "where the robot's middle may not go", inflated_face},
    {"dynamics", "", "cells that stay, cells where something passed, doors and when they opened",
     dynamics_face},
    {"objects", "", "things that stood elsewhere on another visit, each with its shape",
     objects_face},
    {"segments", "chatila-laumond", "walls as straight pieces, each once", segments_face},
    {"relations", "", "which walls are parallel, square, in line, meet, or leave an opening",
     relations_face},
    {"rooms", "kuipers-mataric", "rooms, corridors and the doors between them", rooms_face},
    {"walls-3d", "", "the walls raised to a height, on the free floor", raised_face},
    {"solid", "", "planes and what is not flat, by a second laser out of the plane", solid_face},
    {"elevation", "", "how high and how steep the ground is, by such a laser", elevation_face},
};

std::string size_text(std::size_t bytes) {
  const auto b = static_cast<double>(bytes);
  if (b < 1e3) return fmt::format("{} B", bytes);
  return b < 1e6 ? number(b / 1e3, 1) + " kB" : number(b / 1e6, 1) + " MB";
}

std::string figures_list(const FacePage& page) {
  std::vector<std::vector<std::string>> rows;
  for (const auto& [name, value] : page.figures) rows.push_back({name, number(value, 3)});
  return table({}, rows);
}

std::string body_of(const MadeFace& made) {
  const std::string shows = fmt::format("<p class=\"soft\">{}</p>\n", escape(made.face->shows));
  if (!made.error.empty()) return shows + fmt::format("<p>{}</p>\n", escape(made.error));
  return shows + fmt::format("<p>{}</p>\n", escape(made.page.lead)) +
         figure_in_page(made.page.figure, made.face->name) + figures_list(made.page);
}

std::string overview(std::span<const MadeFace> made) {
  std::string rows;
  for (const MadeFace& m : made)
    rows += fmt::format(
        "<tr><td class=\"l\"><a href=\"#{0}\">{0}</a></td><td class=\"l\">{1}</td><td>{2}</td>"
        "<td>{3} s</td></tr>\n",
        m.face->name, escape(m.error.empty() ? m.face->shows : m.error),
        m.error.empty() ? size_text(m.page.bytes) : "", number(m.seconds, 2));
  return "<table><thead><tr><th class=\"l\">face</th><th class=\"l\">shows</th><th>takes</th>"
         "<th>made in</th></tr></thead><tbody>\n" +
         rows + "</tbody></table>\n";
}

}  // namespace

void describe(OptionFields& fields, FaceOptions& o) {
  map::describe(fields, o.grid);
  map::describe(fields, o.segments);
  map::describe(fields, o.relations);
  fields.add("robot.radius", o.robot.radius, {"m", "of the robot as a disc", 0, 100});
  map::describe(fields, o.inflation);
  map::describe(fields, o.forward);
  map::describe(fields, o.intensity);
  map::describe(fields, o.rooms);
  map::describe(fields, o.raise);
  map::describe(fields, o.planes);
  map::describe(fields, o.solid);
  map::describe(fields, o.elevation);
  map::describe(fields, o.dynamics);
  fields.add("map_at.time", o.map_at.time,
             {"s", "the dynamics' face shows the map as it was then; -1: cells by kind", -1, 1e9});
  fields.add("map_at.hindsight", o.map_at.hindsight, {"", "false: what was believed then"});
  map::describe(fields, o.doors);
  map::describe(fields, o.visits);
  map::describe(fields, o.objects);
}

std::span<const Face> faces() { return kFaces; }

const Face& face(std::string_view name) {
  const auto* found = std::find_if(std::begin(kFaces), std::end(kFaces), [&](const Face& f) {
    return name == f.name || (*f.after && name == f.after);
  });
  if (found != std::end(kFaces)) return *found;
  std::string names;
  for (const Face& f : kFaces) names += fmt::format("{}{}", names.empty() ? "" : ", ", f.name);
  throw Error(fmt::format("no face {}; there are {}", name, names));
}

std::string faces_html(const std::string& name, std::span<const MadeFace> made) {
  std::string body = section("Faces", overview(made));
  for (const MadeFace& m : made)
    body += fmt::format("<a id=\"{}\"></a>\n", m.face->name) + section(m.face->name, body_of(m));
  return page(name, "One place, looked at in many ways.", body, "made by majak faces");
}

}  // namespace majak::draw
