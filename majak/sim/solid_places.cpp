// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "majak/sim/solid_simulator.hpp"

namespace majak::sim {
namespace {

constexpr double kWall = 0.15, kHeight = 2.5, kLintel = 2.0;  // m
constexpr double kRise = 10;                                  // degrees, of the ramp

/// The plan and what stands on it grow together.
struct Builder {
  SolidRooms place;

  void outline(const Vec2& low, const Vec2& high, double reflectivity) {
    const Vec2 p[4] = {low, {high.x(), low.y()}, high, {low.x(), high.y()}};
    for (int i = 0; i < 4; ++i) place.plan.segments.push_back({p[i], p[(i + 1) % 4], reflectivity});
  }
  /// A thing that the first laser sees, too.
  void box(const char* name, const Vec3& low, const Vec3& high, double reflectivity) {
    outline(low.head<2>(), high.head<2>(), reflectivity);
    add_box(place.solid, name, low, high, reflectivity);
  }
  void wall(const Vec2& low, const Vec2& high) {
    box("wall", {low.x(), low.y(), 0}, {high.x(), high.y(), kHeight}, 0.6);
  }
  void lintel(const Vec2& low, const Vec2& high) {
    add_box(place.solid, "lintel", {low.x(), low.y(), kLintel}, {high.x(), high.y(), kHeight}, 0.6);
  }
  void post(const char* name, const Vec2& centre, double radius, double high) {
    place.plan.discs.push_back({centre, radius, 0.4});
    place.solid.pillars.push_back({name, centre, radius, 0, high, 0.4});
  }
  void flat(const char* name, const Vec3& corner, const Vec3& u, const Vec3& v, double reflects) {
    place.solid.patches.push_back({name, corner, u, v, reflects});
  }
};

void add_table(Builder& b, const Vec2& low, const Vec2& high) {
  add_box(b.place.solid, "table", {low.x(), low.y(), 0.72}, {high.x(), high.y(), 0.75}, 0.15);
  for (const double x : {low.x() + 0.05, high.x() - 0.05})
    for (const double y : {low.y() + 0.05, high.y() - 0.05}) b.post("leg", {x, y}, 0.03, 0.72);
}

}  // namespace

SolidRooms solid_rooms() {
  Builder b;
  constexpr double t = kWall / 2;
  // Around, then between corridor (below) and rooms, then between the rooms.
  b.wall({-t, -t}, {12 + t, t});
  b.wall({-t, 8 - t}, {12 + t, 8 + t});
  b.wall({-t, t}, {t, 8 - t});
  b.wall({12 - t, t}, {12 + t, 8 - t});
  b.wall({t, 2.2 - t}, {2.5, 2.2 + t});
  b.wall({3.5, 2.2 - t}, {8.5, 2.2 + t});
  b.wall({9.5, 2.2 - t}, {12 - t, 2.2 + t});
  b.wall({6 - t, 2.2 + t}, {6 + t, 8 - t});
  b.lintel({2.5, 2.2 - t}, {3.5, 2.2 + t});
  b.lintel({8.5, 2.2 - t}, {9.5, 2.2 + t});
  b.flat("floor", {0, 0, 0}, {12, 0, 0}, {0, 8, 0}, 0.3);
  b.flat("ceiling", {0, 0, kHeight}, {0, 8, 0}, {12, 0, 0}, 0.8);
  add_table(b, {1.2, 5.6}, {2.8, 6.6});
  b.box("cupboard", {9.8, 7.3, 0}, {11.4, 7.9, 1.8}, 0.25);
  b.post("pillar", {7.8, 5.2}, 0.25, kHeight);
  b.place.plan.name = "solid_rooms";
  b.place.plan.start = {0.8, 1.1, 0};
  b.place.plan.tour = {{3, 1.1},   {3, 3.6},    {5.2, 4.0},  {4.8, 7.2}, {3.6, 6.6},
                       {3.4, 4.2}, {3, 3.2},    {3, 1.1},    {9, 1.1},   {9, 3.4},
                       {11.2, 4},  {11.2, 6.6}, {9, 6.6},    {6.8, 7},   {6.8, 3.4},
                       {9, 3.4},   {9, 1.1},    {11.2, 1.1}, {6, 1.1},   {0.8, 1.1}};
  b.place.plan.short_tour = b.place.plan.tour;
  return b.place;
}

SolidRooms solid_yard() {
  Builder b;
  const double rise = 4 * std::tan(radians(kRise));
  // The first laser, 0.3 m up, sees the ramp where it is that high.
  const double seen = 12 + 0.3 / std::tan(radians(kRise));
  b.outline({seen, 3}, {22, 7}, 0.4);
  b.flat("ramp", {12, 3, 0}, {4, 0, rise}, {0, 4, 0}, 0.4);
  b.flat("terrace", {16, 3, rise}, {6, 0, 0}, {0, 4, 0}, 0.4);
  b.flat("flank", {16, 3, 0}, {6, 0, 0}, {0, 0, rise}, 0.4);
  b.flat("flank", {16, 7, 0}, {0, 0, rise}, {6, 0, 0}, 0.4);
  b.flat("ground", {0, 0, 0}, {24, 0, 0}, {0, 14, 0}, 0.2);
  add_box(b.place.solid, "step", {4, 9.5, 0}, {8, 11.5, 0.15}, 0.5);
  add_box(b.place.solid, "kerb", {14, 9.5, 0}, {18, 11.5, 0.06}, 0.5);
  add_box(b.place.solid, "beam", {1.5, 2, 1.2}, {1.7, 6, 1.4}, 0.5);
  const Vec2 p[4] = {{0, 0}, {24, 0}, {24, 14}, {0, 14}};
  for (int i = 0; i < 4; ++i) {
    const Vec2 along = p[(i + 1) % 4] - p[i];
    b.place.plan.segments.push_back({p[i], p[(i + 1) % 4], 0.5});
    b.flat("fence", {p[i].x(), p[i].y(), 0}, {0, 0, 1}, {along.x(), along.y(), 0}, 0.5);
  }
  b.place.plan.name = "solid_yard";
  b.place.plan.start = {6, 5, 0};
  b.place.plan.tour = {{10.5, 5}, {10, 8.2}, {4, 8.2},   {2.8, 8},   {2.8, 12.6}, {11, 12.6},
                       {11, 10},  {20, 8.4}, {21, 12.4}, {11, 12.6}, {10, 6},     {4, 4}};
  b.place.plan.short_tour = b.place.plan.tour;
  return b.place;
}

}  // namespace majak::sim
