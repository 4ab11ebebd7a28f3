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

Box box_of(std::span<const map::Segment> segments, const Zones& zones) {
  if (segments.empty() && zones.empty()) return {};
  const Vec2 first = segments.empty() ? zones[0][0] : segments[0].a;
  Box box{first, first};
  for (const std::vector<Vec2>& zone : zones)
    for (const Vec2& p : zone) box.low = box.low.cwiseMin(p), box.high = box.high.cwiseMax(p);
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

void dxf_layer(std::string& out, const char* name, const char* colour) {
  group(out, 0, "LAYER");
  group(out, 2, name);
  group(out, 70, "0");
  group(out, 62, colour);
  group(out, 6, "CONTINUOUS");
}

void dxf_tables(std::string& out, bool zones) {
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
  group(out, 70, zones ? "2" : "1");
  dxf_layer(out, "WALLS", "7");
  if (zones) dxf_layer(out, "FORBIDDEN", "1");
  group(out, 0, "ENDTAB");
  group(out, 0, "ENDSEC");
}

void dxf_polygon(std::string& out, const std::vector<Vec2>& corners) {
  const auto entity = [&](const char* name) {
    group(out, 0, name);
    group(out, 8, "FORBIDDEN");
  };
  entity("POLYLINE");
  group(out, 66, "1");
  point(out, 10, Vec2::Zero());
  group(out, 70, "1");
  for (const Vec2& p : corners) {
    entity("VERTEX");
    point(out, 10, p);
  }
  entity("SEQEND");
}

/// "x y, x y, ..." with what comes between the two and between points; the first corner again at
/// the end.
std::string ring(const std::vector<Vec2>& corners, const char* before, const char* between,
                 const char* after) {
  std::string out;
  for (std::size_t i = 0; i <= corners.size(); ++i) {
    const Vec2& p = corners[i % corners.size()];
    out += fmt::format("{}{}{}{}{}{}", i > 0 ? ", " : "", before, metres(p.x()), between,
                       metres(p.y()), after);
  }
  return out;
}

}  // namespace

std::string segments_svg(std::span<const map::Segment> segments, const Zones& forbidden) {
  const auto [low, high] = box_of(segments, forbidden);
  const Vec2 size = high - low + Vec2(2, 2);
  std::string out = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}cm\" height=\"{1}cm\" "
      "viewBox=\"{2} {3} {0} {1}\">\n"
      "<g stroke=\"black\" stroke-width=\"0.04\" stroke-linecap=\"round\">\n",
      metres(size.x()), metres(size.y()), metres(low.x() - 1), metres(-high.y() - 1));
  for (const map::Segment& s : segments)
    out += fmt::format("<line x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\"/>\n", metres(s.a.x()),
                       metres(-s.a.y()), metres(s.b.x()), metres(-s.b.y()));
  out += "</g>\n";
  for (const std::vector<Vec2>& zone : forbidden) {
    out += "<polygon class=\"forbidden\" fill=\"red\" fill-opacity=\"0.3\" points=\"";
    for (const Vec2& p : zone) out += fmt::format("{},{} ", metres(p.x()), metres(-p.y()));
    out.back() = '"';
    out += "/>\n";
  }
  return out + "</svg>\n";
}

std::string segments_dxf(std::span<const map::Segment> segments, const Zones& forbidden) {
  std::string out;
  dxf_header(out, box_of(segments, forbidden));
  dxf_tables(out, !forbidden.empty());
  section(out, "ENTITIES");
  for (const map::Segment& s : segments) {
    group(out, 0, "LINE");
    group(out, 8, "WALLS");
    point(out, 10, s.a);
    point(out, 11, s.b);
  }
  for (const std::vector<Vec2>& zone : forbidden) dxf_polygon(out, zone);
  group(out, 0, "ENDSEC");
  group(out, 0, "EOF");
  return out;
}

std::string segments_geojson(std::span<const map::Segment> segments, const Zones& forbidden) {
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
  for (const std::vector<Vec2>& zone : forbidden) {
    out += fmt::format(
        "{}{{\"type\": \"Feature\", \"properties\": {{\"kind\": \"forbidden\"}}, \"geometry\": "
        "{{\"type\": \"Polygon\", \"coordinates\": [[{}]]}}}}",
        comma, ring(zone, "[", ", ", "]"));
    comma = ",\n";
  }
  return out + "\n]}\n";
}

std::string segments_wkt(std::span<const map::Segment> segments, const Zones& forbidden) {
  std::string lines = segments_wkt(segments);
  if (forbidden.empty()) return lines;
  lines.pop_back();  // the line's end
  std::string out = "GEOMETRYCOLLECTION (" + lines;
  for (const std::vector<Vec2>& zone : forbidden)
    out += fmt::format(", POLYGON (({}))", ring(zone, "", " ", ""));
  return out + ")\n";
}

std::string segments_svg(std::span<const map::Segment> segments) {
  return segments_svg(segments, {});
}

std::string segments_dxf(std::span<const map::Segment> segments) {
  return segments_dxf(segments, {});
}

std::string segments_geojson(std::span<const map::Segment> segments) {
  return segments_geojson(segments, {});
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
