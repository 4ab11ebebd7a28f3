// SPDX-License-Identifier: Apache-2.0
// SolidWorld: a world with heights, for lasers that look out of the plane. What it is made of is
// the truth that a solid map is held against. Frame "world": metres, z up from the floor.
#pragma once

#include <string>
#include <vector>

#include "majak/core/pose3.hpp"
#include "majak/sim/world.hpp"

namespace majak::sim {

/// A flat parallelogram: corner, corner + u, corner + u + v, corner + v. It is seen from both
/// sides; in worlds that are made here its normal is on the side from which it can be.
struct Patch {
  std::string name;
  Vec3 corner, u, v;  ///< m
  double reflectivity = 0.6;

  Vec3 normal() const { return u.cross(v).normalized(); }
  double area() const { return u.cross(v).norm(); }
};

/// The mantle of an upright cylinder.
struct Pillar {
  std::string name;
  Vec2 centre;
  double radius = 0, low = 0, high = 0;  ///< m
  double reflectivity = 0.4;
};

struct SolidScene {
  std::vector<Patch> patches;
  std::vector<Pillar> pillars;
};

struct RaiseSceneOptions {
  double height = 2.5;  ///< m, of walls and pillars
  bool ceiling = true;
  bool floor = true;
};

/// Every segment a wall, every disc a pillar, floor and ceiling below and above their box.
SolidScene raised(const Scene& scene, const RaiseSceneOptions& options = {});

/// The six sides of a box along the axes.
void add_box(SolidScene& scene, const std::string& name, const Vec3& low, const Vec3& high,
             double reflectivity = 0.6);

struct SolidHit {
  double range = 0;      ///< m; infinite where nothing was met
  double incidence = 0;  ///< rad between the ray and the surface's normal, 0 ... pi/2
  double reflectivity = 0;
  int object = -1;  ///< number of the patch, or of patches + of the pillar
};

class SolidWorld {
 public:
  /// Throws Error when there is nothing to see.
  explicit SolidWorld(SolidScene scene);

  /// The nearest thing along the unit vector `direction`, at most `max_range` away.
  SolidHit cast(const Vec3& origin, const Vec3& direction, double max_range) const;

  const SolidScene& scene() const { return scene_; }

 private:
  struct Plane {
    Vec3 normal, along_u, along_v;  // p - corner = s u + t v with s, t by these
  };
  SolidScene scene_;
  std::vector<Plane> planes_;  // of the patches
};

}  // namespace majak::sim
