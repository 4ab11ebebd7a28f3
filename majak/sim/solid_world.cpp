// SPDX-License-Identifier: Apache-2.0
#include "majak/sim/solid_world.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "majak/core/error.hpp"

namespace majak::sim {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr double kNear = 1e-9;  // m; a ray does not meet what it begins on

Vec3 raise(const Vec2& p, double z) { return {p.x(), p.y(), z}; }

/// How far along the ray the mantle of a pillar is met first.
double way_to(const Pillar& pillar, const Vec3& origin, const Vec3& direction) {
  const Vec2 off = origin.head<2>() - pillar.centre, way = direction.head<2>();
  const double a = way.squaredNorm(), b = off.dot(way);
  const double root = b * b - a * (off.squaredNorm() - pillar.radius * pillar.radius);
  if (a < 1e-18 || root < 0) return kFar;
  for (const double t : {(-b - std::sqrt(root)) / a, (-b + std::sqrt(root)) / a}) {
    const double z = origin.z() + t * direction.z();
    if (t > kNear && z >= pillar.low && z <= pillar.high) return t;
  }
  return kFar;
}

}  // namespace

SolidScene raised(const Scene& scene, const RaiseSceneOptions& options) {
  SolidScene solid;
  Vec2 low(kFar, kFar), high(-kFar, -kFar);
  const auto include = [&](const Vec2& p) { low = low.cwiseMin(p), high = high.cwiseMax(p); };
  for (const Segment& s : scene.segments) {
    solid.patches.push_back(
        {"wall", raise(s.a, 0), raise(s.b - s.a, 0), {0, 0, options.height}, s.reflectivity});
    include(s.a), include(s.b);
  }
  for (const Disc& d : scene.discs) {
    solid.pillars.push_back({"pillar", d.centre, d.radius, 0, options.height, d.reflectivity});
    include(d.centre - Vec2(d.radius, d.radius)), include(d.centre + Vec2(d.radius, d.radius));
  }
  if (solid.patches.empty() && solid.pillars.empty()) return solid;
  const Vec3 along{high.x() - low.x(), 0, 0}, across{0, high.y() - low.y(), 0};
  if (options.floor) solid.patches.push_back({"floor", raise(low, 0), along, across, 0.3});
  if (options.ceiling)
    solid.patches.push_back({"ceiling", raise(low, options.height), across, along, 0.8});
  return solid;
}

void add_box(SolidScene& scene, const std::string& name, const Vec3& low, const Vec3& high,
             double reflectivity) {
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 u = Vec3::Zero(), v = Vec3::Zero();
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    u[a] = high[a] - low[a], v[b] = high[b] - low[b];
    scene.patches.push_back({name, high - u - v, u, v, reflectivity});
    scene.patches.push_back({name, low, v, u, reflectivity});
  }
}

SolidWorld::SolidWorld(SolidScene scene) : scene_(std::move(scene)) {
  if (scene_.patches.empty() && scene_.pillars.empty()) throw Error("a solid world of nothing");
  for (const Patch& patch : scene_.patches) {
    const Vec3 n = patch.u.cross(patch.v);
    planes_.push_back(
        {n.normalized(), patch.v.cross(n) / n.squaredNorm(), n.cross(patch.u) / n.squaredNorm()});
  }
}

SolidHit SolidWorld::cast(const Vec3& origin, const Vec3& direction, double max_range) const {
  SolidHit best{max_range, 0, 0, -1};
  for (std::size_t i = 0; i < planes_.size(); ++i) {
    const Plane& plane = planes_[i];
    const Patch& patch = scene_.patches[i];
    const double towards = plane.normal.dot(direction);
    const double t = plane.normal.dot(patch.corner - origin) / towards;
    if (!(t > kNear && t < best.range)) continue;
    const Vec3 off = origin + t * direction - patch.corner;
    const double s = off.dot(plane.along_u), r = off.dot(plane.along_v);
    if (s < 0 || s > 1 || r < 0 || r > 1) continue;
    best = {t, std::acos(std::min(1.0, std::abs(towards))), patch.reflectivity,
            static_cast<int>(i)};
  }
  for (std::size_t i = 0; i < scene_.pillars.size(); ++i) {
    const Pillar& pillar = scene_.pillars[i];
    const double t = way_to(pillar, origin, direction);
    if (!(t < best.range)) continue;
    const Vec2 n = ((origin + t * direction).head<2>() - pillar.centre) / pillar.radius;
    best = {t, std::acos(std::min(1.0, std::abs(n.dot(direction.head<2>())))), pillar.reflectivity,
            static_cast<int>(planes_.size() + i)};
  }
  if (best.object < 0) best.range = kFar;
  return best;
}

}  // namespace majak::sim
