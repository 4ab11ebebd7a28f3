// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <iterator>

#include "majak/io/solid_files.hpp"

namespace majak::io {
namespace {

template <class... Args>
void append(std::string& out, fmt::format_string<Args...> format, Args&&... args) {
  fmt::format_to(std::back_inserter(out), format, std::forward<Args>(args)...);
}

/// With 0.1 mm, no zeros at the end, never "-0".
void append_number(std::string& out, double value) {
  append(out, "{:.4f}", std::round(value * 1e4) / 1e4 + 0.0);
  out.erase(out.find_last_not_of('0') + 1);
  if (out.back() == '.') out.pop_back();
}

void append_vector(std::string& out, const Eigen::Vector3f& v) {
  for (int i = 0; i < 3; ++i) {
    if (i > 0) out += ' ';
    append_number(out, static_cast<double>(v[i]));
  }
  out += '\n';
}

void append_vectors(std::string& out, const char* head, const std::vector<Eigen::Vector3f>& list) {
  out += head;
  for (const Eigen::Vector3f& v : list) append_vector(out, v);
  out += "] }\n";
}

void append_colours(std::string& out, const std::vector<map::Rgb>& colours) {
  out += "color Color { color [\n";
  for (const map::Rgb& c : colours)
    append(out, "{:.3g} {:.3g} {:.3g}\n", c.r / 255.0, c.g / 255.0, c.b / 255.0);
  out += "] }\n";
}

template <class Faces>
void append_faces(std::string& out, const Faces& faces) {
  for (const auto& face : faces) {
    for (const std::uint32_t vertex : face) append(out, "{} ", vertex);
    out += "-1\n";
  }
}

/// Letters, digits and '_', with the part's number, so that no two are alike.
std::string node_name(const std::string& name, std::size_t number) {
  std::string id = "part_" + std::to_string(number) + "_";
  for (const char c : name) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    id += plain ? c : '_';
  }
  return id;
}

void append_part(std::string& out, const map::SolidPart& part, std::size_t number) {
  append(out, "DEF {} Shape {{\n", node_name(part.name, number));
  if (part.cloud()) {
    out += "geometry PointSet {\n";
  } else {
    out += "appearance Appearance { material Material { } }\n";
    out += "geometry IndexedFaceSet {\nsolid FALSE\n";
  }
  append_vectors(out, "coord Coordinate { point [\n", part.vertices);
  append_colours(out, part.colours);
  if (!part.cloud()) {
    append_vectors(out, "normal Normal { vector [\n", part.normals);
    out += "coordIndex [\n";
    append_faces(out, part.quads);
    append_faces(out, part.triangles);
    out += "]\n";
  }
  out += "}\n}\n";
}

}  // namespace

std::string solid_vrml(const map::Solid& solid) {
  std::string out =
      "#VRML V2.0 utf8\n"
      "WorldInfo { info [ \"metres; the map's z up is turned to y up\" ] }\n"
      "Transform {\nrotation 1 0 0 -1.5707963\nchildren [\n";
  for (std::size_t i = 0; i < solid.parts.size(); ++i)
    if (!solid.parts[i].vertices.empty()) append_part(out, solid.parts[i], i + 1);
  return out + "]\n}\n";
}

}  // namespace majak::io
