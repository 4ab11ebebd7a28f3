// SPDX-License-Identifier: Apache-2.0
#include "majak/sim/furnished_room.hpp"

#include <algorithm>
#include <cmath>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/sim/simulator.hpp"
#include "majak/sim/streams.hpp"

namespace majak::sim {
namespace {

constexpr double kWidth = 9, kHeight = 7;          // m
constexpr double kApart = 0.3, kFromStill = 0.15;  // m
constexpr double kFromTour = 0.5;                  // m, things keep from the round's corners
constexpr double kElsewhere = 0.5;                 // m
constexpr double kBinRadius = 0.3;                 // m
constexpr int kAttempts = 2000;
constexpr std::size_t kBin = 1;

using Outline = std::vector<Vec2>;

Outline box(double x0, double y0, double x1, double y1) {
  return {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
}

/// Corners in the thing's own frame; the bin is a disc, here its eight-cornered hull.
const Outline& outline(std::size_t movable) {
  static const std::array<Outline, kMovables> kOutlines = [] {
    std::array<Outline, kMovables> all;
    all[0] = box(-0.45, -0.3, 0.45, 0.3);
    for (int k = 0; k < 8; ++k) {
      const double a = k * kPi / 4, r = kBinRadius / std::cos(kPi / 8);
      all[kBin].push_back({r * std::cos(a), r * std::sin(a)});
    }
    all[2] = {{-0.7, -0.6}, {0.7, -0.6}, {0.7, -0.1}, {-0.2, -0.1}, {-0.2, 0.6}, {-0.7, 0.6}};
    all[3] = box(-0.8, -0.2, 0.8, 0.2);
    return all;
  }();
  return kOutlines[movable];
}

void add(std::vector<Segment>& segments, const Outline& corners, const Pose2& T,
         double reflectivity) {
  for (std::size_t i = 0; i < corners.size(); ++i)
    segments.push_back({T * corners[i], T * corners[(i + 1) % corners.size()], reflectivity});
}

std::vector<Segment> sides(std::size_t movable, const Pose2& T) {
  std::vector<Segment> segments;
  add(segments, outline(movable), T, 0.4);
  return segments;
}

Scene bare_room() {
  Scene room;
  room.name = "furnished room";
  add(room.segments, box(0, 0, kWidth, kHeight), {}, 0.6);
  add(room.segments, box(3.2, kHeight - 0.5, 5.0, kHeight), {}, 0.4);  // cabinet
  add(room.segments, box(0, 2.6, 0.3, 3.4), {}, 0.4);                  // radiator
  room.discs.push_back({{6.4, 3.4}, 0.25, 0.5});                       // pillar
  room.start = {1.2, 1.2, 0};
  room.tour = {
      {kWidth - 1.2, 1.2}, {kWidth - 1.2, kHeight - 1.2}, {1.2, kHeight - 1.2}, {1.2, 1.2}};
  return room;
}

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

bool crosses(const Segment& s, const Segment& t) {
  const Vec2 u = s.b - s.a, v = t.b - t.a;
  return cross(u, t.a - s.a) * cross(u, t.b - s.a) < 0 &&
         cross(v, s.a - t.a) * cross(v, s.b - t.a) < 0;
}

double gap(const Segment& s, const Segment& t) {
  if (crosses(s, t)) return 0;
  return std::min(
      {distance_to(s, t.a), distance_to(s, t.b), distance_to(t, s.a), distance_to(t, s.b)});
}

/// Inside the walls, off the pillar, the corners of the round and everything in `others`.
bool stands_free(std::size_t movable, const Pose2& T, const Scene& room,
                 const std::vector<Segment>& others) {
  for (const Segment& side : sides(movable, T)) {
    for (const Segment& s : room.segments)
      if (gap(side, s) < kFromStill) return false;
    for (const Segment& s : others)
      if (gap(side, s) < kApart) return false;
    for (const Disc& d : room.discs)
      if (distance_to(side, d.centre) < d.radius + kFromStill) return false;
    for (const Vec2& p : room.tour)
      if (distance_to(side, p) < kFromTour) return false;
  }
  return true;
}

std::vector<Segment> all_but(const Furnishing& furnishing, std::size_t left_out) {
  std::vector<Segment> segments;
  for (std::size_t k = 0; k < kMovables; ++k) {
    if (k == left_out || !furnishing[k]) continue;
    const auto more = sides(k, *furnishing[k]);
    segments.insert(segments.end(), more.begin(), more.end());
  }
  return segments;
}

/// A place for one thing among the others; nothing when none was found.
std::optional<Pose2> place(std::size_t movable, const Furnishing& others, RandomStream& random) {
  const Scene room = bare_room();
  const std::vector<Segment> taken = all_but(others, movable);
  for (int i = 0; i < kAttempts; ++i) {
    const Pose2 T{random.uniform(0.5, kWidth - 0.5), random.uniform(0.5, kHeight - 0.5),
                  random.uniform(-kPi, kPi)};
    if (stands_free(movable, T, room, taken)) return T;
  }
  return std::nullopt;
}

Pose2 wrong_by(RandomStream& random, double offset, double turn) {
  return {offset * random.normal(), offset * random.normal(), turn * random.normal()};
}

bool drivable(const Furnishing& furnishing) {
  try {
    plan_tour(World(furnished_room(furnishing)));
    return true;
  } catch (const Error&) {
    return false;
  }
}

}  // namespace

const char* movable_name(std::size_t movable) {
  constexpr const char* kNames[kMovables] = {"box", "bin", "desk", "bench"};
  return kNames[movable];
}

Furnishing furnish(std::uint64_t seed, std::uint64_t visit, double absent) {
  for (std::uint64_t attempt = 0; attempt < kAttempts; ++attempt) {
    RandomStream random(seed, kFurnishing + visit, attempt);
    Furnishing furnishing;
    bool all = true;
    for (std::size_t k = 0; k < kMovables && all; ++k) {
      if (random.uniform() < absent) continue;
      furnishing[k] = place(k, furnishing, random);
      all = furnishing[k].has_value();
    }
    if (all && drivable(furnishing)) return furnishing;
  }
  throw Error("no room for the furniture");
}

Furnishing moved_one(const Furnishing& before, std::size_t movable, std::uint64_t seed) {
  for (std::uint64_t attempt = 0; attempt < kAttempts; ++attempt) {
    RandomStream random(seed, kFurnishing + (std::uint64_t{1} << 32) + movable, attempt);
    Furnishing after = before;
    after[movable] = place(movable, before, random);
    if (!after[movable]) continue;
    const bool elsewhere =
        !before[movable] ||
        (after[movable]->translation() - before[movable]->translation()).norm() >= kElsewhere;
    if (elsewhere && drivable(after)) return after;
  }
  throw Error("no room for the furniture");
}

Scene furnished_room(const Furnishing& furnishing) {
  Scene room = bare_room();
  for (std::size_t k = 0; k < kMovables; ++k) {
    if (!furnishing[k]) continue;
    if (k == kBin) {
      room.discs.push_back({furnishing[k]->translation(), kBinRadius, 0.4});
    } else {
      add(room.segments, outline(k), *furnishing[k], 0.4);
    }
  }
  return room;
}

Site visit_room(const Furnishing& furnishing, std::uint64_t seed, const VisitErrors& errors) {
  const World world(furnished_room(furnishing));
  SimulationOptions options;
  options.seed = static_cast<int>(seed & 0x7fffffff);
  RandomStream random(seed, kFurnishing + (std::uint64_t{2} << 32));
  const Pose2 offset = wrong_by(random, errors.offset, errors.turn);
  Site site;
  for (Event& event : simulate(world, plan_tour(world), options)) {
    if (auto* scan = std::get_if<Scan>(&event)) {
      site.scans.emplace_back();
      site.scans.back().scan = std::move(*scan);
    }
    if (const auto* truth = std::get_if<Truth>(&event))
      site.scans.back().estimate.T_map_robot =
          offset * truth->T_world_robot * wrong_by(random, errors.scan_offset, errors.scan_turn);
  }
  return site;
}

}  // namespace majak::sim
