// SPDX-License-Identifier: Apache-2.0
#include "majak/io/known_map_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string_view>

#include "majak/core/error.hpp"
#include "majak/io/byte_stream.hpp"
#include "majak/io/number.hpp"
#include "majak/io/segment_reader.hpp"
#include "majak/io/site_file.hpp"

namespace majak::io {
namespace {

namespace fs = std::filesystem;
using map::CellState;

constexpr std::size_t kMostBytes = std::size_t{1} << 30;
constexpr std::size_t kMostPixels = std::size_t{1} << 28;
constexpr double kCoarsest = 10, kFinest = 0.001;  // m

std::string whole_file(const fs::path& path) {
  auto bytes = open_bytes(path).bytes;
  std::string text(std::size_t{1} << 16, '\0');
  std::size_t size = 0;
  while (const std::size_t n = bytes->read(text.data() + size, text.size() - size)) {
    size += n;
    if (size == kMostBytes) throw Error(path.string() + ": more than 1 GB is no map");
    if (size == text.size()) text.resize(2 * size);
  }
  text.resize(size);
  return text;
}

bool begins(std::string_view text, std::string_view with) {
  return text.substr(0, with.size()) == with;
}

// ---- YAML ------------------------------------------------------------------------------------

struct MapYaml {
  std::string image;
  MapKey key;
  Pose2 origin;  ///< of the lower left corner
  bool has_resolution = false;
};

std::string_view trimmed(std::string_view s) {
  const auto blank = [](char c) { return is_blank(c); };
  while (!s.empty() && blank(s.front())) s.remove_prefix(1);
  while (!s.empty() && blank(s.back())) s.remove_suffix(1);
  return s;
}

double number(std::string_view text, const std::string& where) {
  const std::string copy(trimmed(text));
  double value = 0;
  const char* const end = copy.data() + copy.size();
  if (parse_decimal(copy.data(), end, value) != end || !std::isfinite(value))
    throw Error(fmt::format("{}{} is no number", where, copy));
  return value;
}

// The few keys that map_server knows; `[a, b, c]` or one `- a` a line.
MapYaml parse_yaml(const std::string& text, const std::string& name) {
  MapYaml yaml;
  std::vector<double> origin;
  std::string_view rest = text;
  bool in_origin = false;
  for (int line = 1; !rest.empty(); ++line) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    std::string_view entry = trimmed(rest.substr(0, std::min(end, rest.substr(0, end).find(" #"))));
    rest.remove_prefix(std::min(end + 1, rest.size()));
    const std::string where = fmt::format("{}:{}: ", name, line);
    if (entry.empty() || entry.front() == '#' || begins(entry, "---")) continue;
    if (in_origin && entry.front() == '-' && origin.size() < 3) {
      origin.push_back(number(entry.substr(1), where));
      continue;
    }
    const std::size_t colon = entry.find(':');
    if (colon == std::string_view::npos) throw Error(where + "a map's YAML is lines `key: value`");
    const std::string_view key = trimmed(entry.substr(0, colon));
    std::string_view value = trimmed(entry.substr(colon + 1));
    if (value.size() >= 2 && (value.front() == '"' || value.front() == '\'') &&
        value.back() == value.front())
      value = value.substr(1, value.size() - 2);
    in_origin = key == "origin";
    if (key == "image") {
      yaml.image = value;
    } else if (key == "resolution") {
      yaml.key.resolution = number(value, where);
      yaml.has_resolution = true;
    } else if (in_origin && !value.empty()) {
      if (value.front() != '[' || value.back() != ']')
        throw Error(where + "the origin is written [x, y, yaw]");
      value = value.substr(1, value.size() - 2);
      while (!value.empty()) {
        const std::size_t comma = std::min(value.find(','), value.size());
        origin.push_back(number(value.substr(0, comma), where));
        value.remove_prefix(std::min(comma + 1, value.size()));
      }
    } else if (key == "negate") {
      yaml.key.negate = value == "true" || value == "1";
    } else if (key == "occupied_thresh") {
      yaml.key.occupied = number(value, where);
    } else if (key == "free_thresh") {
      yaml.key.free = number(value, where);
    } else if (key == "mode") {
      yaml.key.percent = value == "raw";
    }
  }
  if (yaml.image.empty()) throw Error(name + ": names no image; write `image: map.pgm`");
  if (!yaml.has_resolution)
    throw Error(name + ": says no resolution; write `resolution: 0.05` (metres a pixel)");
  if (origin.size() >= 2)
    yaml.origin = {origin[0], origin[1], origin.size() > 2 ? wrap_angle(origin[2]) : 0};
  return yaml;
}

// ---- Pictures --------------------------------------------------------------------------------

/// The numbers of a PGM's head, with comments between them.
class PgmWords {
 public:
  PgmWords(const std::string& bytes, const std::string& name) : bytes_(bytes), name_(name) {}
  std::size_t at() const { return at_; }
  int number(int most) {
    while (at_ < bytes_.size() && (is_blank(bytes_[at_]) || bytes_[at_] == '#')) {
      if (bytes_[at_] == '#')
        at_ = std::min(bytes_.find('\n', at_), bytes_.size());
      else
        ++at_;
    }
    std::int64_t value = 0;
    const std::size_t begin = at_;
    for (; at_ < bytes_.size() && is_digit(bytes_[at_]) && value <= most; ++at_)
      value = 10 * value + (bytes_[at_] - '0');
    if (at_ == begin || value > most)
      throw Error(fmt::format(
          "{}: is no PGM picture: a number is missing or out of range at byte {}", name_, begin));
    return static_cast<int>(value);
  }

 private:
  const std::string& bytes_;
  const std::string& name_;
  std::size_t at_ = 2;  // behind "P5"
};

Image picture(const fs::path& path) {
  const std::string bytes = whole_file(path);
  if (begins(bytes, "\x89PNG")) return decode_grey_png(bytes, path.string());
  if (begins(bytes, "P5") || begins(bytes, "P2")) return decode_pgm(bytes, path.string());
  throw Error(path.string() + ": is neither a PGM nor a PNG picture");
}

void check_resolution(double resolution, const std::string& name) {
  if (!(resolution >= kFinest && resolution <= kCoarsest))
    throw Error(fmt::format("{}: a pixel of {} m is no map; 0.001 ... 10 m is", name, resolution));
}

MapInput read_yaml(const fs::path& path) {
  const MapYaml yaml = parse_yaml(whole_file(path), path.string());
  check_resolution(yaml.key.resolution, path.string());
  const fs::path image = path.parent_path() / yaml.image;  // an absolute path replaces the rest
  MapInput input;
  input.known = known_map(picture(image), yaml.key);
  if (yaml.origin.theta == 0)
    input.known->x0 = yaml.origin.x, input.known->y0 = yaml.origin.y;
  else
    input.T_world_map = yaml.origin;
  return input;
}

}  // namespace

Image decode_pgm(const std::string& bytes, const std::string& name) {
  PgmWords words(bytes, name);
  const int width = words.number(1 << 24), height = words.number(1 << 24),
            white = words.number(65535);
  if (width == 0 || height == 0 || white == 0) throw Error(name + ": is an empty PGM picture");
  const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  if (pixels > kMostPixels) throw Error(name + ": is a picture of too many pixels");
  Image image;
  image.width = width, image.height = height;
  const auto scaled = [&](int value) {
    return static_cast<std::uint8_t>((std::min(value, white) * 255 + white / 2) / white);
  };
  const bool plain = bytes[1] == '2';
  const std::size_t size = white > 255 ? 2 : 1, first = words.at() + 1;
  if (!plain && (bytes.size() < first || (bytes.size() - first) / size < pixels))
    throw Error(fmt::format("{}: ends early: {} x {} pixels want {} bytes", name, width, height,
                            pixels * size));
  if (plain && bytes.size() < pixels) throw Error(name + ": ends early");
  image.pixels.resize(pixels);
  for (std::size_t i = 0; i < pixels; ++i) {
    const auto byte = [&](std::size_t k) { return static_cast<std::uint8_t>(bytes[first + k]); };
    const int value = plain       ? words.number(65535)
                      : size == 1 ? byte(i)
                                  : 256 * byte(2 * i) + byte(2 * i + 1);
    image.pixels[i] =
        white == 255 ? static_cast<std::uint8_t>(std::min(value, 255)) : scaled(value);
  }
  return image;
}

map::KnownMap known_map(const Image& picture, const MapKey& key) {
  map::KnownMap map;
  map.resolution = key.resolution;
  map.width = picture.width, map.height = picture.height;
  map.cells.resize(static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height));
  const auto state = [&](std::uint8_t value) {
    if (key.percent && value > 100) return CellState::unknown;
    const double p = key.percent  ? value / 100.0
                     : key.negate ? value / 255.0
                                  : (255 - value) / 255.0;
    return p > key.occupied ? CellState::occupied
           : p < key.free   ? CellState::free
                            : CellState::unknown;
  };
  for (int row = 0; row < map.height; ++row)
    std::transform(
        picture.row(row), picture.row(row) + picture.width,
        map.cells.begin() + static_cast<std::ptrdiff_t>(map.index(0, map.height - 1 - row)), state);
  return map;
}

MapInput read_map(const fs::path& path, double resolution) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) {
    for (const char* name : {"site.majak", "map.yaml"})
      if (fs::exists(path / name, ignored)) return read_map(path / name, resolution);
    throw Error(path.string() + ": has neither site.majak nor map.yaml; name the map's own file");
  }
  const std::string kind = path.extension().string();
  if (kind == ".majak") return {read_site(path), std::nullopt, {}, {}};
  if (is_segment_file(path))
    return {std::nullopt, std::nullopt, parse_segments(whole_file(path), kind, path.string()), {}};
  if (kind == ".yaml" || kind == ".yml") return read_yaml(path);
  const fs::path beside = fs::path(path).replace_extension(".yaml");
  if (resolution == 0 && fs::exists(beside, ignored)) return read_yaml(beside);
  if (resolution == 0)
    throw Error(
        path.string() +
        ": how large is a pixel? Say --map-resolution 0.05 (metres), or put a YAML beside it");
  check_resolution(resolution, path.string());
  MapKey key;
  key.resolution = resolution;
  return {std::nullopt, known_map(picture(path), key), {}, {}};
}

}  // namespace majak::io
