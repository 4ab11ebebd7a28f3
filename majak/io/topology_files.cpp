// SPDX-License-Identifier: Apache-2.0
#include "majak/io/topology_files.hpp"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "majak/core/error.hpp"
#include "majak/io/atomic_file.hpp"

namespace majak::io {
namespace {

using Json = nlohmann::ordered_json;

std::string xml(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        if (static_cast<unsigned char>(c) >= 0x20) out += c;  // XML 1.0 has no others
    }
  }
  return out;
}

/// To 0.1 mm, never -0.
double metres(double value) { return std::round(value * 1e4) / 1e4 + 0.0; }

void key(std::string& out, const char* of, const char* name, const char* type) {
  out += fmt::format("  <key id=\"{0}_{1}\" for=\"{0}\" attr.name=\"{1}\" attr.type=\"{2}\"/>\n",
                     of, name, type);
}
void data(std::string& out, const char* of, const char* name, const std::string& value) {
  out += fmt::format("      <data key=\"{}_{}\">{}</data>\n", of, name, value);
}
void data(std::string& out, const char* of, const char* name, double value) {
  data(out, of, name, fmt::format("{:.4f}", metres(value)));
}

Json point(const Vec2& p) { return Json::array({metres(p.x()), metres(p.y())}); }

/// Cells as runs [row, first column, how many].
Json runs(const map::Topology& t, const map::Room& room) {
  Json rows = Json::array();
  const auto w = static_cast<std::uint32_t>(t.width);
  for (std::size_t i = 0; i < room.cells.size();) {
    std::size_t end = i + 1;
    while (end < room.cells.size() && room.cells[end] == room.cells[end - 1] + 1 &&
           room.cells[end] / w == room.cells[i] / w)
      ++end;
    rows.push_back(Json::array({room.cells[i] / w, room.cells[i] % w, end - i}));
    i = end;
  }
  return rows;
}

Vec2 read_point(const Json& json) { return {json.at(0).get<double>(), json.at(1).get<double>()}; }

}  // namespace

std::string topology_graphml(const map::Topology& t, std::span<const std::string> names) {
  std::string out =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<graphml xmlns=\"http://graphml.graphdrawing.org/xmlns\">\n";
  for (const char* name : {"name", "kind", "evidence"}) key(out, "node", name, "string");
  for (const char* name : {"x", "y", "area", "clearance"}) key(out, "node", name, "double");
  key(out, "edge", "kind", "string");
  for (const char* name : {"x", "y", "width", "direction", "length"})
    key(out, "edge", name, "double");
  out += "  <graph id=\"rooms\" edgedefault=\"undirected\">\n";
  for (std::size_t i = 0; i < t.rooms.size(); ++i) {
    const map::Room& room = t.rooms[i];
    out += fmt::format("    <node id=\"r{}\">\n", i);
    data(out, "node", "name", xml(names[i]));
    data(out, "node", "kind", name_of(room.kind));
    data(out, "node", "evidence", xml(evidence_of(room)));
    data(out, "node", "x", room.widest_spot.x());
    data(out, "node", "y", room.widest_spot.y());
    data(out, "node", "area", room.area);
    data(out, "node", "clearance", room.clearance);
    out += "    </node>\n";
  }
  for (std::size_t i = 0; i < t.doors.size(); ++i) {
    const map::Doorway& d = t.doors[i];
    out += fmt::format("    <edge id=\"d{}\" source=\"r{}\" target=\"r{}\">\n", i, d.from, d.to);
    data(out, "edge", "kind", d.opening ? "opening" : "door");
    data(out, "edge", "x", d.centre.x());
    data(out, "edge", "y", d.centre.y());
    data(out, "edge", "width", d.width);
    data(out, "edge", "direction", std::atan2(d.along.y(), d.along.x()));
    data(out, "edge", "length",
         (d.centre - t.rooms[d.from].widest_spot).norm() +
             (d.centre - t.rooms[d.to].widest_spot).norm());
    out += "    </edge>\n";
  }
  return out + "  </graph>\n</graphml>\n";
}

std::string topology_json(const map::Topology& t, std::span<const std::string> names) {
  Json json = {{"unit", "m"},
               {"grid",
                {{"resolution", t.resolution},
                 {"x0", metres(t.x0)},
                 {"y0", metres(t.y0)},
                 {"width", t.width},
                 {"height", t.height}}}};
  json["rooms"] = json["doors"] = json["furniture"] = Json::array();
  for (std::size_t i = 0; i < t.rooms.size(); ++i) {
    const map::Room& room = t.rooms[i];
    Json outline = Json::array();
    for (const Vec2& p : room.outline) outline.push_back(point(p));
    json["rooms"].push_back({{"id", i},
                             {"name", names[i]},
                             {"kind", name_of(room.kind)},
                             {"evidence", evidence_of(room)},
                             {"area", metres(room.area)},
                             {"centroid", point(room.centroid)},
                             {"widest_spot", point(room.widest_spot)},
                             {"clearance", metres(room.clearance)},
                             {"outline", outline},
                             {"cells", runs(t, room)}});
  }
  for (std::size_t i = 0; i < t.doors.size(); ++i) {
    const map::Doorway& d = t.doors[i];
    json["doors"].push_back({{"id", i},
                             {"kind", d.opening ? "opening" : "door"},
                             {"centre", point(d.centre)},
                             {"along", point(d.along)},
                             {"width", metres(d.width)},
                             {"rooms", Json::array({d.from, d.to})}});
  }
  for (const map::Furniture& f : t.furniture)
    json["furniture"].push_back(
        {{"centre", point(f.centre)}, {"size", point(f.size)}, {"room", f.room}});
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::vector<map::RoomLabel> read_labels(const std::filesystem::path& path) {
  std::vector<map::RoomLabel> labels;
  std::ifstream file(path);
  if (!file) {
    if (std::filesystem::exists(path)) throw Error(path.string() + ": cannot be read");
    return labels;
  }
  try {
    const Json json = Json::parse(file);
    for (const Json& entry : json.at("labels")) {
      map::RoomLabel label{entry.at("text").get<std::string>(), read_point(entry.at("at")), {}};
      const Json outline = entry.value("outline", Json::array());
      for (const Json& p : outline) label.outline.push_back(read_point(p));
      labels.push_back(std::move(label));
    }
  } catch (const nlohmann::json::exception& e) {
    throw Error(path.string() + ": no file of labels: " + e.what());
  }
  return labels;
}

void write_labels(const std::filesystem::path& path, std::span<const map::RoomLabel> labels) {
  Json json = {{"unit", "m"}, {"labels", Json::array()}};
  for (const map::RoomLabel& label : labels) {
    Json outline = Json::array();
    for (const Vec2& p : label.outline) outline.push_back(point(p));
    json["labels"].push_back({{"text", label.text}, {"at", point(label.at)}, {"outline", outline}});
  }
  write_file_atomically(path, json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace majak::io
