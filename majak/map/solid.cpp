// SPDX-License-Identifier: Apache-2.0
#include "majak/map/solid.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstddef>

namespace majak::map {
namespace {

template <class Faces>
bool all_below(const Faces& faces, std::size_t vertices) {
  return std::all_of(faces.begin(), faces.end(), [&](const auto& face) {
    return std::all_of(face.begin(), face.end(), [&](std::uint32_t i) { return i < vertices; });
  });
}

}  // namespace

SolidCount count(const Solid& solid) {
  SolidCount sum;
  for (const SolidPart& part : solid.parts) {
    ++sum.parts;
    sum.vertices += part.vertices.size();
    sum.quads += part.quads.size();
    sum.triangles += part.triangles.size();
    if (part.cloud()) sum.points += part.vertices.size();
  }
  return sum;
}

void add_rectangle(SolidPart& part, const Eigen::Vector3d& corner, const Eigen::Vector3d& u,
                   const Eigen::Vector3d& v, const Rgb& colour) {
  const auto first = static_cast<std::uint32_t>(part.vertices.size());
  const Eigen::Vector3f normal = u.cross(v).normalized().cast<float>();
  for (const Eigen::Vector3d& p : {corner, Eigen::Vector3d(corner + u),
                                   Eigen::Vector3d(corner + u + v), Eigen::Vector3d(corner + v)}) {
    part.vertices.push_back(p.cast<float>());
    part.normals.push_back(normal);
    part.colours.push_back(colour);
  }
  part.quads.push_back({first, first + 1, first + 2, first + 3});
}

bool well_formed(const Solid& solid) {
  return std::all_of(solid.parts.begin(), solid.parts.end(), [](const SolidPart& part) {
    const std::size_t n = part.vertices.size();
    const auto finite = [](const Eigen::Vector3f& p) { return p.allFinite(); };
    return part.normals.size() == n && part.colours.size() == n && all_below(part.quads, n) &&
           all_below(part.triangles, n) &&
           std::all_of(part.vertices.begin(), part.vertices.end(), finite) &&
           std::all_of(part.normals.begin(), part.normals.end(), finite);
  });
}

}  // namespace majak::map
