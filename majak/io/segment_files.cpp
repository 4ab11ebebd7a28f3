// SPDX-License-Identifier: Apache-2.0
#include "majak/io/segment_files.hpp"

#include <fmt/format.h>

#include <cmath>

namespace majak::io {
namespace {

/// m with 0.1 mm, never "-0.0000".
std::string metres(double value) {
  return fmt::format("{:.4f}", std::round(value * 1e4) / 1e4 + 0.0);
}

struct Box {
  Vec2 low = Vec2::Zero(), high = Vec2::Zero();
};

Box box_of(std::span<const map::Segment> segments) {
  if (segments.empty()) return {};
  Box box{segments[0].a, segments[0].a};
  for (const map::Segment& s : segments) {
    box.low = box.low.cwiseMin(s.a.cwiseMin(s.b));
    box.high = box.high.cwiseMax(s.a.cwiseMax(s.b));
  }
  return box;
}

/// A group of DXF: its code, right-aligned as AutoCAD does it, and its value.
void group(std::string& out, int code, const std::string& value) {
  out += fmt::format("{:>3}\n{}\n", code, value);
}

void point(std::string& out, int first_code, const Vec2& p) {
  group(out, first_code, metres(p.x()));
  group(out, first_code + 10, metres(p.y()));
  group(out, first_code + 20, metres(0));
}

void section(std::string& out, const char* name) {
  group(out, 0, "SECTION");
  group(out, 2, name);
}

void dxf_header(std::string& out, const Box& box) {
  section(out, "HEADER");
  group(out, 9, "$ACADVER");
  group(out, 1, "AC1009");
  group(out, 9, "$EXTMIN");
  point(out, 10, box.low);
  group(out, 9, "$EXTMAX");
  point(out, 10, box.high);
  group(out, 0, "ENDSEC");
}

void dxf_tables(std::string& out) {
  section(out, "TABLES");
  group(out, 0, "TABLE");
  group(out, 2, "LTYPE");
  group(out, 70, "1");
  group(out, 0, "LTYPE");
  group(out, 2, "CONTINUOUS");
  group(out, 70, "0");
  group(out, 3, "Solid line");
  group(out, 72, "65");
  group(out, 73, "0");
  group(out, 40, "0.0");
  group(out, 0, "ENDTAB");
  group(out, 0, "TABLE");
  group(out, 2, "LAYER");
  group(out, 70, "1");
  group(out, 0, "LAYER");
  group(out, 2, "WALLS");
  group(out, 70, "0");
  group(out, 62, "7");
  group(out, 6, "CONTINUOUS");
  group(out, 0, "ENDTAB");
  group(out, 0, "ENDSEC");
}

}  // namespace

std::string segments_svg(std::span<const map::Segment> segments) {
  const auto [low, high] = box_of(segments);
  const Vec2 size = high - low + Vec2(2, 2);
  std::string out = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}cm\" height=\"{1}cm\" "
      "viewBox=\"{2} {3} {0} {1}\">\n"
      "<g stroke=\"black\" stroke-width=\"0.04\" stroke-linecap=\"round\">\n",
      metres(size.x()), metres(size.y()), metres(low.x() - 1), metres(-high.y() - 1));
  for (const map::Segment& s : segments)
    out += fmt::format("<line x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\"/>\n", metres(s.a.x()),
                       metres(-s.a.y()), metres(s.b.x()), metres(-s.b.y()));
  return out + "</g>\n</svg>\n";
}

std::string segments_dxf(std::span<const map::Segment> segments) {
  std::string out;
  dxf_header(out, box_of(segments));
  dxf_tables(out);
  section(out, "ENTITIES");
  for (const map::Segment& s : segments) {
    group(out, 0, "LINE");
    group(out, 8, "WALLS");
    point(out, 10, s.a);
    point(out, 11, s.b);
  }
  group(out, 0, "ENDSEC");
  group(out, 0, "EOF");
  return out;
}

std::string segments_geojson(std::span<const map::Segment> segments) {
  std::string out = "{\"type\": \"FeatureCollection\", \"features\": [";
  const char* comma = "\n";
  for (const map::Segment& s : segments) {
    out += fmt::format(
        "{}{{\"type\": \"Feature\", \"geometry\": {{\"type\": \"LineString\", \"coordinates\": "
        "[[{}, {}], [{}, {}]]}}, \"properties\": {{\"length\": {}, \"points\": {}, \"scans\": {}, "
        "\"sigma_offset\": {:.3g}, \"sigma_angle\": {:.3g}, \"sigma_a\": {:.3g}, \"sigma_b\": "
        "{:.3g}}}}}",
        comma, metres(s.a.x()), metres(s.a.y()), metres(s.b.x()), metres(s.b.y()),
        metres(s.length()), s.points, s.scans, std::sqrt(s.covariance(0, 0)),
        std::sqrt(s.covariance(1, 1)), s.sigma_a, s.sigma_b);
    comma = ",\n";
  }
  return out + "\n]}\n";
}

std::string segments_wkt(std::span<const map::Segment> segments) {
  if (segments.empty()) return "MULTILINESTRING EMPTY\n";
  std::string out = "MULTILINESTRING (";
  const char* comma = "";
  for (const map::Segment& s : segments) {
    out += fmt::format("{}({} {}, {} {})", comma, metres(s.a.x()), metres(s.a.y()), metres(s.b.x()),
                       metres(s.b.y()));
    comma = ", ";
  }
  return out + ")\n";
}

}  // namespace majak::io
