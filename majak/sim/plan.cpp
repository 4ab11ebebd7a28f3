// SPDX-License-Identifier: Apache-2.0
#include "majak/sim/plan.hpp"

#include <png.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <vector>

#include "majak/core/error.hpp"

namespace majak::sim {

namespace {

constexpr double kMaxCells = 1e8;

/// Walls on a raster, row 0 at the bottom.
struct Raster {
  int columns = 0, rows = 0;
  std::vector<char> wall;

  bool at(int column, int row) const {
    if (column < 0 || row < 0 || column >= columns || row >= rows) return false;
    return wall[static_cast<std::size_t>(row) * columns + column] != 0;
  }
};

/// The border between wall and floor; straight runs become one segment.
void add_borders(const Raster& r, double cell, std::vector<Segment>& out) {
  // Lines along x: between row - 1 and row. The side on which the wall lies ends a run, too.
  for (int row = 0; row <= r.rows; ++row) {
    int begin = 0, kind = 0;
    for (int column = 0; column <= r.columns; ++column) {
      const int here = r.at(column, row) - r.at(column, row - 1);
      if (here == kind && column < r.columns) continue;
      if (kind != 0) out.push_back({cell * Vec2(begin, row), cell * Vec2(column, row)});
      begin = column;
      kind = here;
    }
  }
  for (int column = 0; column <= r.columns; ++column) {
    int begin = 0, kind = 0;
    for (int row = 0; row <= r.rows; ++row) {
      const int here = r.at(column, row) - r.at(column - 1, row);
      if (here == kind && row < r.rows) continue;
      if (kind != 0) out.push_back({cell * Vec2(column, begin), cell * Vec2(column, row)});
      begin = row;
      kind = here;
    }
  }
}

/// Number of steps from each floor cell to the nearest wall, and pieces of floor that hang
/// together.
struct FloorPieces {
  std::vector<int> steps;  ///< 0 in a wall
  std::vector<int> piece;  ///< -1 in a wall
  std::vector<std::size_t> size;
  std::vector<char> open;  ///< reaches the plan's border
};

FloorPieces find_pieces(const Raster& r) {
  const std::size_t count = r.wall.size();
  FloorPieces f{std::vector<int>(count, -1), std::vector<int>(count, -1), {}, {}};
  const int dx[4] = {1, -1, 0, 0}, dy[4] = {0, 0, 1, -1};
  const auto spread = [&](std::vector<int> front, const auto& visit) {
    for (std::size_t i = 0; i < front.size(); ++i) {
      const int column = front[i] % r.columns, row = front[i] / r.columns;
      for (int k = 0; k < 4; ++k) {
        const int x = column + dx[k], y = row + dy[k];
        const bool inside = x >= 0 && y >= 0 && x < r.columns && y < r.rows;
        if (inside && visit(front[i], y * r.columns + x)) front.push_back(y * r.columns + x);
      }
    }
    return front;
  };
  std::vector<int> walls;
  for (std::size_t c = 0; c < count; ++c) {
    if (r.wall[c] != 0) walls.push_back(static_cast<int>(c));
  }
  for (const int c : walls) f.steps[c] = 0;
  spread(walls, [&](int from, int to) {
    if (f.steps[to] >= 0) return false;
    f.steps[to] = f.steps[from] + 1;
    return true;
  });
  for (std::size_t c = 0; c < count; ++c) {
    if (r.wall[c] != 0 || f.piece[c] >= 0) continue;
    const int number = static_cast<int>(f.size.size());
    f.piece[c] = number;
    const auto cells = spread({static_cast<int>(c)}, [&](int, int to) {
      if (r.wall[to] != 0 || f.piece[to] >= 0) return false;
      f.piece[to] = number;
      return true;
    });
    f.size.push_back(cells.size());
    f.open.push_back(std::any_of(cells.begin(), cells.end(), [&](int cell) {
      const int column = cell % r.columns, row = cell / r.columns;
      return column == 0 || row == 0 || column == r.columns - 1 || row == r.rows - 1;
    }));
  }
  return f;
}

/// The widest place of the largest enclosed floor, or of the largest one if none is enclosed.
Vec2 find_start(const Raster& r, double cell, const std::string& name) {
  const FloorPieces f = find_pieces(r);
  if (f.size.empty()) throw Error(name + ": the plan has no floor, only wall");
  std::size_t best = 0;
  for (std::size_t i = 1; i < f.size.size(); ++i) {
    const bool better = f.open[i] != f.open[best] ? !f.open[i] : f.size[i] > f.size[best];
    if (better) best = i;
  }
  std::size_t widest = 0;
  int steps = -1;
  for (std::size_t c = 0; c < r.wall.size(); ++c) {
    if (f.piece[c] == static_cast<int>(best) && f.steps[c] > steps) {
      widest = c;
      steps = f.steps[c];
    }
  }
  const std::size_t column = widest % r.columns, row = widest / r.columns;
  return cell * Vec2(static_cast<double>(column) + 0.5, static_cast<double>(row) + 0.5);
}

void check_cell(double cell, const std::string& name) {
  if (cell >= 0.001 && cell <= 100) return;
  throw Error(name + ": the size of a cell must be 0.001 ... 100 m");
}

[[noreturn]] void refuse(const std::string& name, std::size_t line, std::size_t column, char c) {
  throw Error(name + ":" + std::to_string(line) + ":" + std::to_string(column) +
              ": unknown character '" + std::string(1, c) +
              "' in the plan: '#' is wall, '.' floor, '>' the start");
}

/// What stands in a text plan, before its height is known.
struct Marks {
  std::vector<std::string> lines;
  double cell = 0;
  std::vector<Vec2> posts;      // in cells, y counted from the top
  std::map<char, Vec2> places;  // '1' < '9' < 'A' < 'Z'
  std::optional<Pose2> start;
};

void read_comment(std::string_view line, const std::string& name, Marks& marks) {
  const std::string text(line.substr(1));
  const std::size_t word = text.find_first_not_of(" \t");
  if (word == std::string::npos || text.compare(word, 5, "cell ") != 0) return;
  marks.cell = std::strtod(text.c_str() + word + 5, nullptr);
  check_cell(marks.cell, name);
}

void read_mark(char c, const Vec2& at, Marks& marks) {
  const double quarter = kPi / 2;
  switch (c) {
    case 'o':
      marks.posts.push_back(at);
      return;
    case 'S':
    case '>':
      marks.start = Pose2{at.x(), at.y(), 0};
      return;
    case '^':
      marks.start = Pose2{at.x(), at.y(), quarter};
      return;
    case '<':
      marks.start = Pose2{at.x(), at.y(), kPi};
      return;
    case 'v':
      marks.start = Pose2{at.x(), at.y(), -quarter};
      return;
    default:
      marks.places[c] = at;
  }
}

Marks read_marks(std::string_view text, const std::string& name) {
  Marks marks;
  std::size_t number = 0;
  while (!text.empty()) {
    const std::size_t stop = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, stop);
    text.remove_prefix(std::min(stop + 1, text.size()));
    ++number;
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line.starts_with(';')) {
      read_comment(line, name, marks);
      continue;
    }
    const auto row = static_cast<double>(marks.lines.size());
    for (std::size_t i = 0; i < line.size(); ++i) {
      const char c = line[i];
      if (c == '#' || c == '.' || c == ' ') continue;
      const bool place = (c >= '1' && c <= '9') || (c >= 'A' && c <= 'Z');
      if (!place && std::string_view("o>^<v").find(c) == std::string_view::npos)
        refuse(name, number, i + 1, c);
      read_mark(c, Vec2(static_cast<double>(i) + 0.5, row + 0.5), marks);
    }
    marks.lines.emplace_back(line);
  }
  return marks;
}

}  // namespace

Scene parse_plan(std::string_view text, const std::string& name, double cell) {
  const Marks marks = read_marks(text, name);
  if (cell <= 0) cell = marks.cell > 0 ? marks.cell : kTextCell;
  check_cell(cell, name);
  Raster r;
  r.rows = static_cast<int>(marks.lines.size());
  for (const auto& line : marks.lines)
    r.columns = std::max(r.columns, static_cast<int>(line.size()));
  if (static_cast<double>(r.rows) * r.columns > kMaxCells)
    throw Error(name + ": the plan is too large");
  r.wall.assign(static_cast<std::size_t>(r.columns) * r.rows, 0);
  for (int i = 0; i < r.rows; ++i) {
    for (std::size_t k = 0; k < marks.lines[i].size(); ++k) {
      r.wall[static_cast<std::size_t>(r.rows - 1 - i) * r.columns + k] = marks.lines[i][k] == '#';
    }
  }
  if (std::find(r.wall.begin(), r.wall.end(), 1) == r.wall.end()) {
    throw Error(name + ": the plan has no wall: draw one with '#'");
  }
  const auto metres = [&](const Vec2& p) -> Vec2 { return cell * Vec2(p.x(), r.rows - p.y()); };
  Scene scene;
  scene.name = name;
  add_borders(r, cell, scene.segments);
  for (const Vec2& p : marks.posts) scene.discs.push_back({metres(p), 0.3 * cell});
  for (const auto& [mark, p] : marks.places) scene.tour.push_back(metres(p));
  if (marks.start) {
    const Vec2 p = metres(marks.start->translation());
    scene.start = {p.x(), p.y(), marks.start->theta};
  } else {
    const Vec2 p = find_start(r, cell, name);
    scene.start = {p.x(), p.y(), 0};
  }
  return scene;
}

Scene parse_picture(std::string_view png, const std::string& name, double cell) {
  if (cell <= 0) cell = kPictureCell;
  check_cell(cell, name);
  png_image image;
  std::memset(&image, 0, sizeof image);
  image.version = PNG_IMAGE_VERSION;
  const auto fail = [&]() {
    const std::string why = image.message;
    png_image_free(&image);
    throw Error(name + ": cannot read the picture: " + why);
  };
  if (png_image_begin_read_from_memory(&image, png.data(), png.size()) == 0) fail();
  if (static_cast<double>(image.width) * image.height > kMaxCells) {
    png_image_free(&image);
    throw Error(name + ": the picture is too large: at most 100 million pixels");
  }
  image.format = PNG_FORMAT_GRAY;
  std::vector<png_byte> grey(PNG_IMAGE_SIZE(image));
  const png_color paper{255, 255, 255};  // under what is transparent
  if (png_image_finish_read(&image, &paper, grey.data(), 0, nullptr) == 0) fail();
  Raster r{static_cast<int>(image.width), static_cast<int>(image.height), {}};
  r.wall.resize(grey.size());
  for (int row = 0; row < r.rows; ++row) {
    for (int column = 0; column < r.columns; ++column) {
      const auto from = static_cast<std::size_t>(r.rows - 1 - row) * r.columns + column;
      r.wall[static_cast<std::size_t>(row) * r.columns + column] = grey[from] < 128;
    }
  }
  Scene scene;
  scene.name = name;
  add_borders(r, cell, scene.segments);
  if (scene.segments.empty())
    throw Error(name + ": the picture has no dark pixel: nothing is wall");
  const Vec2 start = find_start(r, cell, name);
  scene.start = {start.x(), start.y(), 0};
  return scene;
}

Scene read_plan(const std::filesystem::path& path, double cell) {
  std::ifstream in(path, std::ios::binary);
  if (!in || std::filesystem::is_directory(path)) {
    throw Error(path.string() + ": cannot read this plan: " +
                (std::filesystem::is_directory(path) ? "it is a folder" : std::strerror(errno)));
  }
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  if (bytes.starts_with("\x89PNG")) return parse_picture(bytes, path.string(), cell);
  return parse_plan(bytes, path.string(), cell);
}

}  // namespace majak::sim
