// SPDX-License-Identifier: Apache-2.0
#include "majak/sim/buildings.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <optional>
#include <string_view>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/sim/floor_plans.hpp"
#include "majak/sim/park.hpp"

namespace majak::sim {

namespace {

constexpr double kWall = 0.15;  // m, thickness
constexpr double kDoor = 1.0;   // m, clear width

/// Collects rectangles and discs; walls are rectangles, so that both their faces are real.
struct Builder {
  Scene scene;

  void box(double x0, double y0, double x1, double y1, double reflectivity) {
    const Vec2 p[4] = {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
    for (int i = 0; i < 4; ++i) scene.segments.push_back({p[i], p[(i + 1) % 4], reflectivity});
  }

  /// A box turned by `angle` about its centre: furniture is seldom square to the wall.
  void furniture(const Vec2& centre, double length, double width, double angle) {
    const Pose2 T_world_box{centre.x(), centre.y(), angle};
    const double l = length / 2, w = width / 2;
    const Vec2 p[4] = {{-l, -w}, {l, -w}, {l, w}, {-l, w}};
    for (int i = 0; i < 4; ++i) {
      scene.segments.push_back({T_world_box * p[i], T_world_box * p[(i + 1) % 4], 0.35});
    }
  }

  void disc(double x, double y, double radius) { scene.discs.push_back({{x, y}, radius, 0.4}); }

  /// A wall along y from x0 to x1, with doors whose centres are given.
  void wall_x(double y, double x0, double x1, std::vector<double> doors = {}) {
    double from = x0 - kWall / 2;
    doors.push_back(x1 + kWall / 2 + kDoor / 2);
    for (const double door : doors) {
      box(from, y - kWall / 2, door - kDoor / 2, y + kWall / 2, 0.6);
      from = door + kDoor / 2;
      if (from < x1) scene.doorways.push_back({{from - kDoor, y}, {from, y}, 0.5});
    }
  }

  void wall_y(double x, double y0, double y1, std::vector<double> doors = {}) {
    double from = y0 - kWall / 2;
    doors.push_back(y1 + kWall / 2 + kDoor / 2);
    for (const double door : doors) {
      box(x - kWall / 2, from, x + kWall / 2, door - kDoor / 2, 0.6);
      from = door + kDoor / 2;
      if (from < y1) scene.doorways.push_back({{x, from - kDoor}, {x, from}, 0.5});
    }
  }
};

//   25 +------+---------+-------+------+--------+---------+------+
//      |  W3  .   N1    |  N2   | niche|   N3   |   N4    .  E3  |
//   19 |      +---. .---+--. .--+      +--. .---+--. .----+      |
//      +------.             north corridor                .------+
//   17 |  W2  .  +---------------+    +-------+----.--+   .  E2  |
//      +------+  |     hall      .mid .   A   .   B   .   +------+
//    8 |  W1  .  +---------------+    +-------+-------+   .  E1  |
//      |      .             south corridor                .      |
//    6 |      +----. .-----+--. .--+--. .--+----. .-------+      |
//      |      |     S1     |  S2   |  S3   |     S4       |      |
//    0 +------+------------+-------+-------+--------------+------+
//      0      5  7.2     11..     19  21  24      33    35.2    40
void add_walls(Builder& b) {
  b.wall_x(0, 0, 40);
  b.wall_x(25, 0, 40);
  b.wall_y(0, 0, 25);
  b.wall_y(40, 0, 25);
  // The corridors' outer side.
  b.wall_x(6, 5, 35.2, {8.5, 14, 20.5, 29});
  b.wall_x(19.2, 5, 18.5, {9.5, 15});
  b.wall_x(19.2, 22.5, 35.2, {25.5, 31});
  b.wall_y(5, 0, 25, {7.2, 11, 17.8});
  b.wall_y(35.2, 0, 25, {7.1, 12.5, 18.1});
  // Rooms outside.
  b.wall_y(11, 0, 6);
  b.wall_y(17, 0, 6, {3});
  b.wall_y(24, 0, 6);
  b.wall_y(12, 19.2, 25);
  b.wall_y(18.5, 19.2, 25);
  b.wall_y(22.5, 19.2, 25);
  b.wall_y(29, 19.2, 25, {22});
  b.wall_x(9, 0, 5);
  b.wall_x(14, 0, 5);
  b.wall_x(9.5, 35.2, 40);
  b.wall_x(15.5, 35.2, 40);
  // Rooms inside.
  b.wall_x(8.2, 7.2, 19);
  b.wall_x(17, 7.2, 19);
  b.wall_y(7.2, 8.2, 17, {13});
  b.wall_y(19, 8.2, 17, {11});
  b.wall_x(8.2, 21, 33);
  b.wall_x(17, 21, 33, {30});
  b.wall_y(21, 8.2, 17, {14});
  b.wall_y(33, 8.2, 17, {11.5});
  b.wall_y(27, 8.2, 17, {12.5});
}

void add_furniture(Builder& b) {
  // Hall: pillars and a few tables.
  for (const double x : {10.2, 13.1, 16.0}) {
    for (const double y : {10.6, 14.6}) b.disc(x, y, 0.2);
  }
  b.furniture({11.6, 16.2}, 1.6, 0.8, 0.0);
  b.furniture({14.5, 9.1}, 1.8, 0.8, 0.05);
  b.furniture({17.6, 16.1}, 1.4, 0.7, -0.2);
  // Desks and shelves along the walls of the rooms.
  b.furniture({6.2, 1.2}, 1.6, 0.8, kPi / 2);
  b.furniture({10.3, 3.0}, 2.4, 0.5, kPi / 2);
  b.furniture({12.0, 0.7}, 1.6, 0.8, 0.0);
  b.furniture({15.6, 0.9}, 1.4, 0.7, 0.3);
  b.furniture({22.9, 0.8}, 1.6, 0.8, 0.0);
  b.furniture({26.0, 0.9}, 1.6, 0.8, -0.1);
  b.furniture({33.8, 2.2}, 3.0, 0.5, kPi / 2);
  b.furniture({30.5, 0.7}, 2.0, 0.6, 0.0);
  b.furniture({1.0, 2.0}, 2.2, 0.9, kPi / 2);
  b.furniture({3.4, 0.6}, 1.5, 0.6, 0.0);
  b.furniture({0.7, 12.6}, 1.2, 0.6, kPi / 2);
  b.furniture({1.2, 22.8}, 2.0, 1.0, 0.4);
  b.furniture({3.6, 24.3}, 1.5, 0.6, 0.0);
  b.furniture({6.1, 24.2}, 1.6, 0.8, 0.0);
  b.furniture({11.2, 22.5}, 2.0, 0.5, kPi / 2);
  b.furniture({14.0, 24.2}, 2.2, 0.7, 0.0);
  b.furniture({23.4, 23.9}, 1.2, 0.8, 0.7);
  b.furniture({33.9, 23.6}, 1.6, 0.8, kPi / 2);
  b.furniture({38.9, 23.2}, 2.0, 0.9, kPi / 2);
  b.furniture({39.2, 13.8}, 1.4, 0.6, kPi / 2);
  b.furniture({38.6, 1.2}, 1.8, 0.9, 0.2);
  b.furniture({22.0, 16.2}, 1.2, 0.6, 0.0);
  b.furniture({24.6, 9.0}, 2.0, 0.7, 0.0);
  b.furniture({31.6, 15.8}, 1.8, 0.8, kPi / 2);
  b.furniture({29.2, 9.2}, 1.4, 0.9, 0.5);
  // Chairs and bins.
  // clang-format off
  const Vec2 chairs[] = {{7.3, 1.4}, {12.2, 1.7}, {23.1, 1.8}, {25.8, 2.0}, {2.1, 1.9},
                         {2.4, 21.9}, {7.0, 23.2}, {32.9, 23.4}, {37.8, 2.3}, {30.6, 15.4}};
  // clang-format on
  for (const Vec2& p : chairs) b.disc(p.x(), p.y(), 0.22);
  // The corridors are not quite empty: cabinets, bins, a radiator.
  b.box(16.0, 6.075, 17.6, 6.425, 0.35);
  b.box(24.5, 16.725, 25.7, 17.0, 0.5);
  b.box(25.0, 7.85, 26.6, 8.125, 0.35);
  b.disc(33.3, 8.0, 0.18);
  b.disc(7.0, 17.2, 0.18);
  b.disc(20.9, 18.9, 0.2);
  b.box(5.075, 13.0, 5.35, 14.6, 0.5);
  b.box(34.85, 14.0, 35.125, 15.2, 0.35);
}

/// Door frames, cabinets and posters' cases along a wall: put(from, to, how far it stands proud).
template <class Put>
void uneven(double length, RandomStream& random, const Put& put) {
  for (double at = 2.5 + random.uniform(1, 8); at < length - 4; at += random.uniform(1, 8)) {
    const double width = random.uniform(0.4, 1.6);
    put(at, at + width, random.uniform(0.08, 0.35));
    at += width;
  }
}

// Along these corners, each cut by an arc.
std::vector<Vec2> rounded(const std::vector<Vec2>& corners, double radius) {
  constexpr int kParts = 8;
  std::vector<Vec2> way;
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    const Vec2 in = (corners[i] - corners[i - 1]).normalized();
    const Vec2 out = (corners[i + 1] - corners[i]).normalized();
    for (int part = 0; part <= kParts; ++part) {
      const double a = kPi / 2 * part / kParts;
      way.push_back(corners[i] + radius * ((std::sin(a) - 1) * in + (1 - std::cos(a)) * out));
    }
  }
  way.push_back(corners.back());
  return way;
}

}  // namespace

Scene building() {
  Builder b;
  b.scene.name = "building";
  add_walls(b);
  add_furniture(b);
  b.scene.start = {6.1, 7.2, 0};
  const Vec2 sw{6.1, 7.1}, nw{6.1, 18.1}, ne{34.1, 18.1}, se{34.1, 7.1};
  const Vec2 mid_south{20, 7.1}, mid_north{20, 18.1};
  // clang-format off
  b.scene.tour = {
      mid_south, mid_north, nw, sw,              // west loop
      {8.5, 3}, {8.5, 7.1}, {14, 3}, {20.5, 3},  // S1, S2 through to S3
      {20.5, 7.1}, se, ne, mid_north,            // east loop
      {20, 14}, {24, 13}, {29.5, 13}, {34.1, 11.5}, {37.5, 12.5}, {34.1, 12.5},  // A, B, E2
      se, {29, 7.1}, {29, 3}, {29, 7.1}, mid_south,                               // S4
      {20, 11}, {14.5, 12.6}, {6.1, 13}, {2.6, 11}, {6.1, 11},                    // hall, W2
      nw, {2.5, 18.5}, nw, {9.5, 18.1}, {9.5, 21.5}, {9.5, 18.1}, {15, 18.1},     // W3, N1
      mid_north, {25.5, 18.1}, {25.5, 21.8}, {31, 22}, {31, 18.1},                // N3, N4
      {30, 13.5}, {34.1, 11.5}, se, mid_south, sw, {6.1, 13}};                    // B, home
  b.scene.short_tour = {mid_south, {20, 11}, {14.5, 12.6}, {6.1, 13}, nw, mid_north,
                        mid_south, sw, {6.1, 13}, sw, mid_south};
  // clang-format on
  return b.scene;
}

Scene ring() {
  Builder b;
  b.scene.name = "ring";
  b.wall_x(0, 0, 30.4);
  b.wall_x(20.4, 0, 30.4);
  b.wall_y(0, 0, 20.4);
  b.wall_y(30.4, 0, 20.4);
  b.box(2.2, 2.2, 28.2, 18.2, 0.6);
  // Closed doors stand a hand's breadth proud of the wall, at uneven distances.
  for (const double x : {4.0, 9.5, 12.0, 19.3, 25.1}) b.box(x, 0, x + 1, 0.15, 0.4);
  for (const double x : {6.2, 13.0, 21.4}) b.box(x, 18.1, x + 1, 18.3, 0.4);
  for (const double x : {3.1, 10.4, 17.7, 24.0}) b.box(x, 20.2, x + 1, 20.4, 0.4);
  for (const double y : {5.0, 11.2, 14.1}) b.box(0, y, 0.17, y + 1, 0.4);
  for (const double y : {4.1, 9.0}) b.box(30.22, y, 30.4, y + 1, 0.4);
  b.disc(28.6, 18.9, 0.15);
  b.disc(1.9, 2.0, 0.15);
  b.scene.start = {15, 1.1, 0};
  const Vec2 corners[4] = {{29.3, 1.1}, {29.3, 19.3}, {1.1, 19.3}, {1.1, 1.1}};
  for (int lap = 0; lap < 2; ++lap) {
    b.scene.tour.insert(b.scene.tour.end(), corners, corners + 4);
    b.scene.tour.push_back({15, 1.1});
  }
  b.scene.tour.push_back(corners[0]);
  b.scene.short_tour.assign(b.scene.tour.begin(), b.scene.tour.begin() + 5);
  return b.scene;
}

Scene large_ring() {
  constexpr double kLength = 60, kWidth = 40, kWide = 2.2, kHigh = kWidth - kWide,
                   kRight = kLength - kWide;
  Builder b;
  b.scene.name = "large_ring";
  b.wall_x(-kWall / 2, 0, kLength);
  b.wall_x(kWidth + kWall / 2, 0, kLength);
  b.wall_y(-kWall / 2, 0, kWidth);
  b.wall_y(kLength + kWall / 2, 0, kWidth);
  b.box(kWide, kWide, kRight, kHigh, 0.6);
  RandomStream random(1);
  const auto box = [&](double x0, double y0, double x1, double y1) { b.box(x0, y0, x1, y1, 0.4); };
  uneven(kLength, random, [&](double x, double to, double d) { box(x, 0, to, d); });
  uneven(kLength, random, [&](double x, double to, double d) { box(x, kWidth - d, to, kWidth); });
  uneven(kLength, random, [&](double x, double to, double d) { box(x, kWide - d, to, kWide); });
  uneven(kLength, random, [&](double x, double to, double d) { box(x, kHigh, to, kHigh + d); });
  uneven(kWidth, random, [&](double y, double to, double d) { box(0, y, d, to); });
  uneven(kWidth, random, [&](double y, double to, double d) { box(kLength - d, y, kLength, to); });
  uneven(kWidth, random, [&](double y, double to, double d) { box(kWide - d, y, kWide, to); });
  uneven(kWidth, random, [&](double y, double to, double d) { box(kRight, y, kRight + d, to); });
  const double near = kWide / 2, right = kLength - near, high = kWidth - near;
  b.scene.start = {kLength / 2, near, 0};
  const Vec2 lap[] = {{right, near}, {right, high}, {near, high}, {near, near}, {right, near}};
  b.scene.short_tour.assign(std::begin(lap), std::end(lap));
  b.scene.tour = b.scene.short_tour;
  b.scene.tour.insert(b.scene.tour.end(), std::begin(lap) + 1, std::end(lap));
  for (auto* tour : {&b.scene.short_tour, &b.scene.tour}) tour->push_back({right, 16});
  return b.scene;
}

namespace {

constexpr double kRingWide = 2.2, kRingMiddle = kRingWide / 2;  // m

/// Recesses of doors, as deep as their walls, along the north side and the west side.
void add_recesses(Builder& b, double length, double width) {
  constexpr double kDeep = 0.12;
  const double proud[] = {4.1, 6.3, 5.2, 3.4, 7.1, 4.6};  // m of wall between two doors
  double x = 3, y = 3;
  for (int i = 0; x < length - 3; ++i) {
    const double to = std::min(x + proud[i % 6], length - 1.5);
    b.box(x, width - kDeep, to, width, 0.6);
    x = to + kDoor;
  }
  for (int i = 3; y < width - 3; ++i) {
    const double to = std::min(y + proud[i % 6], width - 1.5);
    b.box(0, y, kDeep, to, 0.6);
    y = to + kDoor;
  }
}

void add_outer_walls(Builder& b, double length, double width) {
  b.wall_x(-kWall / 2, 0, length);
  b.wall_x(width + kWall / 2, 0, length);
  b.wall_y(-kWall / 2, 0, width);
  b.wall_y(length + kWall / 2, 0, width);
}

}  // namespace

Scene bare_ring(double length, double width) {
  Builder b;
  b.scene.name = "bare_ring";
  add_outer_walls(b, length, width);
  add_recesses(b, length, width);
  b.box(kRingWide, kRingWide, length - kRingWide, width - kRingWide, 0.6);
  const double near = kRingMiddle, right = length - near, high = width - near;
  b.scene.start = {length - 6, near, 0};
  const Vec2 lap[] = {{right, near}, {right, high}, {near, high}, {near, near}, {right, near}};
  b.scene.short_tour.assign(std::begin(lap), std::end(lap));
  b.scene.tour = b.scene.short_tour;
  b.scene.tour.insert(b.scene.tour.end(), std::begin(lap) + 1, std::end(lap));
  for (auto* tour : {&b.scene.short_tour, &b.scene.tour}) tour->push_back({right, high});
  return b.scene;
}

Scene nested_rings() {
  constexpr double kLength = 60, kWidth = 40, kRight = 18, kHigh = 12;  // of the small ring's block
  Builder b;
  b.scene.name = "nested_rings";
  add_outer_walls(b, kLength, kWidth);
  add_recesses(b, kLength, kWidth);
  b.box(kRingWide, kRingWide, kRight, kHigh, 0.6);
  b.box(kRight + kRingWide, kRingWide, kLength - kRingWide, kWidth - kRingWide, 0.6);
  b.box(kRingWide, kHigh + kRingWide, kRight + kRingWide, kWidth - kRingWide, 0.6);
  const double near = kRingMiddle, x = kRight + near, y = kHigh + near, right = kLength - near,
               high = kWidth - near;
  b.scene.start = {kLength - 6, near, 0};
  b.scene.tour = {{right, near}, {right, high}, {near, high}, {near, y}};
  const Vec2 small[] = {{near, near}, {x, near}, {x, y}, {near, y}};
  for (int lap = 0; lap < 3; ++lap)
    b.scene.tour.insert(b.scene.tour.end(), std::begin(small), std::end(small));
  for (const Vec2& p : {Vec2(near, near), Vec2(right, near), Vec2(right, 16)})
    b.scene.tour.push_back(p);
  b.scene.short_tour = b.scene.tour;
  return b.scene;
}

Scene corridor() {
  Builder b;
  b.scene.name = "corridor";
  b.wall_x(-1.2 - kWall / 2, 0, 60);
  b.wall_x(1.2 + kWall / 2, 0, 60);
  b.wall_y(0, -1.2, 1.2);
  b.wall_y(60, -1.2, 1.2);
  b.scene.start = {10, 0, 0};
  b.scene.tour = {{50, 0}, {10, 0}};
  b.scene.short_tour = {{50, 0}};
  return b.scene;
}

Scene yard() {
  Builder b;
  b.scene.name = "yard";
  b.wall_x(0, 0, 80, {14, 37, 61});
  b.wall_x(50, 0, 80, {22, 48});
  b.wall_y(0, 0, 50, {18});
  b.wall_y(80, 0, 50, {33});
  b.box(19, 18, 33, 32, 0.6);
  b.box(33, 21, 34.5, 25, 0.5);
  b.box(47, 17.5, 60, 28, 0.6);
  b.box(47, 28, 54, 32.5, 0.4);
  b.furniture({8, 44}, 4.5, 1.8, 0.2);
  b.furniture({24, 5}, 4.5, 1.8, -0.1);
  b.furniture({55, 45}, 6, 2.4, 0.05);
  b.furniture({75, 9}, 4.2, 1.7, 1.4);
  const double trees[][3] = {{5, 7, 0.2},   {4, 31, 0.3},   {15, 46, 0.2}, {33, 5.5, 0.25},
                             {36, 45, 0.2}, {46, 5, 0.3},   {66, 46, 0.2}, {75, 25, 0.25},
                             {74, 42, 0.3}, {57, 4.5, 0.2}, {63, 30, 0.2}, {16, 24, 0.2}};
  for (const auto& t : trees) b.disc(t[0], t[1], t[2]);
  b.scene.start = {40, 20, kPi / 2};
  const Vec2 sw{11, 12}, nw{11, 38}, ne{69, 38}, se{69, 12}, north{40, 38}, south{40, 12};
  b.scene.tour =
      rounded({{40, 20}, north, nw, sw, se, ne, north, south, sw, nw, ne, se, south, {40, 30}}, 6);
  b.scene.short_tour = rounded({{40, 20}, north, nw, sw, {55, 12}}, 6);
  return b.scene;
}

std::vector<std::string> built_in_names() {
  return {"building",     "ring",     "large_ring", "bare_ring",
          "nested_rings", "corridor", "yard",       "park"};
}

namespace {

/// The seed of "office-7".
std::optional<std::uint64_t> office_seed(std::string_view name) {
  constexpr std::string_view kOffice = "office-";
  if (!name.starts_with(kOffice)) return std::nullopt;
  name.remove_prefix(kOffice.size());
  std::uint64_t seed = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), seed);
  if (error != std::errc() || end != name.data() + name.size()) return std::nullopt;
  return seed;
}

}  // namespace

Scene built_in(const std::string& name) {
  if (const auto seed = office_seed(name)) return generated_building(*seed).scene;
  if (name == "building") return building();
  if (name == "ring") return ring();
  if (name == "large_ring") return large_ring();
  if (name == "bare_ring") return bare_ring();
  if (name == "nested_rings") return nested_rings();
  if (name == "corridor") return corridor();
  if (name == "yard") return yard();
  if (name == "park") return park();
  throw Error(name +
              ": no such world: choose building, ring, large_ring, bare_ring, nested_rings, "
              "corridor, yard, "
              "park or office-1, office-2 ... (any number), or give a plan file");
}

}  // namespace majak::sim
