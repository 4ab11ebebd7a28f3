// SPDX-License-Identifier: Apache-2.0
// World: walls and round things in the plane that a simulated laser sees, with a fast ray cast.
// Frame "world": metres, x to the right of a plan, y up.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "majak/core/pose2.hpp"

namespace majak::sim {

struct Segment {
  Vec2 a, b;
  double reflectivity = 0.6;  ///< 0.1 black card ... 0.8 white paper
};

struct Disc {
  Vec2 centre;
  double radius = 0;  ///< m
  double reflectivity = 0.4;
};

/// A round reflector: it sends back to the laser many times what white paper does.
inline constexpr double kShining = 5;  ///< reflectivity from which on a thing is a reflector
inline Disc reflector(const Vec2& centre, double diameter = 0.1) {
  return {centre, diameter / 2, 20};
}

/// What a ray met.
struct Hit {
  double range = 0;      ///< m; infinite where nothing was met
  double incidence = 0;  ///< rad between the ray and the surface's normal, 0 ... pi/2
  double reflectivity = 0;
  int object = -1;  ///< the same number for the same segment or disc; -1 for nothing
};

/// What a world is made of.
struct Scene {
  std::string name;
  std::vector<Segment> segments;
  std::vector<Disc> discs;
  Pose2 start;                      ///< T_world_robot at the beginning
  std::vector<Vec2> tour;           ///< places to visit in this order; empty: a tour is made up
  std::vector<Vec2> short_tour;     ///< about 100 m, for statistics over many runs
  bool straight = false;            ///< the tour is driven in straight lines from place to place
  std::vector<Segment> doorways{};  ///< where a door shuts; not seen unless doors move (doors.hpp)
};

class World {
 public:
  /// Sorts everything into a uniform grid. Throws Error when there is nothing to see.
  explicit World(Scene scene);

  /// The nearest thing in direction `angle`, at most `max_range` away. `moving` are discs that are
  /// not part of the world (people); those that contain the origin are not seen. `leaves` of doors
  /// are not part of it either.
  Hit cast(const Vec2& origin, double angle, double max_range, std::span<const Disc> moving = {},
           std::span<const Segment> leaves = {}) const;

  /// Distance to the nearest surface; 0 inside a disc. Slow: for planning and tests.
  double clearance(const Vec2& point) const;

  const Scene& scene() const { return scene_; }
  const Vec2& low() const { return low_; }  ///< corners of the box around everything
  const Vec2& high() const { return high_; }

 private:
  struct Ray {
    Vec2 origin, direction;
  };
  void meet(int object, const Ray& ray, Hit& best) const;
  void walk(const Ray& ray, Hit& best) const;
  void fill_grid();
  template <class Body>
  void for_each_cell(int object, const Body& body) const;

  Scene scene_;
  Vec2 low_, high_;
  // Grid: the objects of cell c are objects_[first_[c]] ... objects_[first_[c + 1] - 1].
  Vec2 grid_low_;
  int columns_ = 0, rows_ = 0;
  std::vector<std::int32_t> first_, objects_;
};

/// Distance from a point to a segment.
double distance_to(const Segment& segment, const Vec2& point);

}  // namespace majak::sim
