// SPDX-License-Identifier: Apache-2.0
#include "majak/io/segment_reader.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <string_view>

#include "majak/core/error.hpp"
#include "majak/io/number.hpp"

namespace majak::io {
namespace {

using Lines = std::vector<map::Segment>;

void add(Lines& lines, const Vec2& a, const Vec2& b) {
  if (!a.allFinite() || !b.allFinite() || !((b - a).norm() > 0)) return;
  map::Segment s;
  s.a = a, s.b = b;
  lines.push_back(s);
}

/// The number at text[at]; moves behind it. `text` is a whole std::string's.
std::optional<double> number(std::string_view text, std::size_t& at) {
  double value = 0;
  const char* const end = parse_decimal(text.data() + at, text.data() + text.size(), value);
  if (end == nullptr) return std::nullopt;
  at = static_cast<std::size_t>(end - text.data());
  return value;
}

bool begins_number(char c) { return is_digit(c) || c == '-' || c == '+' || c == '.'; }

/// Points of numbers, of which the first two count; a list of them ends where a bracket closes
/// twice (GeoJSON: a point is a bracket of its own) or once (WKT: points are parted by commas).
class Polyline {
 public:
  explicit Polyline(Lines& lines) : lines_(lines) {}
  void coordinate(double value) {
    if (count_ < 2) point_[count_] = value;
    ++count_;
  }
  void end_point() {
    if (count_ >= 2) {
      if (last_) add(lines_, *last_, point_);
      last_ = point_;
    }
    count_ = 0;
  }
  void end_line() {
    end_point();
    last_.reset();
  }

 private:
  Lines& lines_;
  Vec2 point_ = Vec2::Zero();
  int count_ = 0;
  std::optional<Vec2> last_;
};

/// Nested brackets from text[at] on, as they follow a "coordinates".
void coordinates(std::string_view text, std::size_t& at, Polyline& line) {
  int depth = 0;
  bool in_point = false;
  for (; at < text.size();) {
    const char c = text[at];
    if (begins_number(c) && depth > 0) {
      const auto value = number(text, at);
      if (!value) return;
      line.coordinate(*value);
      in_point = true;
      continue;
    }
    ++at;
    if (c == '[') ++depth;
    if (c != ']') continue;
    in_point ? line.end_point() : line.end_line();
    in_point = false;
    if (--depth <= 0) break;
  }
  line.end_line();
}

Lines from_geojson(std::string_view text) {
  Lines lines;
  Polyline line(lines);
  Lines zones;
  Polyline zone(zones);
  constexpr std::string_view kKey = "\"coordinates\"";
  std::size_t before = 0;
  for (std::size_t at = text.find(kKey); at != std::string_view::npos; at = text.find(kKey, at)) {
    const std::string_view said = text.substr(before, at - before);
    at += kKey.size();
    coordinates(text, at, said.find("\"forbidden\"") == std::string_view::npos ? line : zone);
    before = at;
  }
  return lines;
}

/// Polygons beside lines are zones and not walls.
Lines from_wkt(std::string_view text) {
  constexpr std::string_view kZone = "POLYGON";
  const bool has_lines = text.find("LINESTRING") != std::string_view::npos;
  Lines lines;
  Polyline line(lines);
  int depth = 0;
  for (std::size_t at = 0; at < text.size();) {
    const char c = text[at];
    if (depth > 0 && begins_number(c)) {
      const auto value = number(text, at);
      if (!value) break;
      line.coordinate(*value);
      continue;
    }
    if (has_lines && text.substr(at, kZone.size()) == kZone) {
      at = std::min(text.find("))", at), text.size());
      continue;
    }
    ++at;
    if (c == '(') ++depth;
    if (c == ',') line.end_point();
    if (c == ')') line.end_line(), --depth;
  }
  return lines;
}

std::string_view next_line(std::string_view text, std::size_t& at) {
  const std::size_t end = std::min(text.find('\n', at), text.size());
  std::string_view line = text.substr(at, end - at);
  at = end + 1;
  while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
  while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
  return line;
}

/// Groups of a code and a value, a line each; of entities only LINE is a wall.
Lines from_dxf(std::string_view text) {
  Lines lines;
  Vec2 a = Vec2::Zero(), b = Vec2::Zero();
  bool in_line = false;
  for (std::size_t at = 0; at < text.size();) {
    const std::string_view code = next_line(text, at);
    if (at >= text.size()) break;
    std::size_t value_at = at;
    const std::string_view value = next_line(text, at);
    if (code == "0") {
      if (in_line) add(lines, a, b);
      in_line = value == "LINE";
      a = b = Vec2::Zero();
      continue;
    }
    double* const part = code == "10"   ? &a.x()
                         : code == "20" ? &a.y()
                         : code == "11" ? &b.x()
                         : code == "21" ? &b.y()
                                        : nullptr;
    if (!in_line || part == nullptr) continue;
    while (value_at < text.size() && is_blank(text[value_at])) ++value_at;
    *part = number(text, value_at).value_or(std::numeric_limits<double>::quiet_NaN());
  }
  return lines;
}

/// y is down in a drawing and up in a map.
Lines from_svg(std::string_view text) {
  Lines lines;
  for (std::size_t at = text.find("<line"); at != std::string_view::npos;
       at = text.find("<line", at + 1)) {
    const std::size_t end = std::min(text.find('>', at), text.size());
    double v[4];
    bool whole = true;
    const char* const keys[4] = {" x1=\"", " y1=\"", " x2=\"", " y2=\""};
    for (int i = 0; i < 4; ++i) {
      std::size_t key = text.find(keys[i], at);
      whole = whole && key < end;
      if (!whole) break;
      key += 5;
      const auto value = number(text, key);
      whole = value.has_value();
      v[i] = value.value_or(0);
    }
    if (whole) add(lines, {v[0], -v[1]}, {v[2], -v[3]});
  }
  return lines;
}

}  // namespace

bool is_segment_file(const std::filesystem::path& path) {
  const std::string kind = path.extension().string();
  return kind == ".geojson" || kind == ".json" || kind == ".wkt" || kind == ".dxf" ||
         kind == ".svg";
}

std::vector<map::Segment> parse_segments(const std::string& text, const std::string& kind,
                                         const std::string& name) {
  Lines lines = kind == ".wkt"   ? from_wkt(text)
                : kind == ".dxf" ? from_dxf(text)
                : kind == ".svg" ? from_svg(text)
                                 : from_geojson(text);
  if (lines.empty()) throw Error(name + ": no straight line with a length in it");
  return lines;
}

}  // namespace majak::io
