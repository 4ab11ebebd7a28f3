// SPDX-License-Identifier: Apache-2.0
// Solid: a place in three dimensions as coloured polygons and points, for programs that show such
// things (io/vrml, io/gltf, io/ply). Map frame: metres, x and y as in the plane, z up from the
// floor that the robot stands on.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace majak::map {

struct Rgb {
  std::uint8_t r = 0, g = 0, b = 0;  ///< sRGB, as screens take it
  bool operator==(const Rgb&) const = default;
};

/// Some of its surfaces under one name. Vertices have normals and colours; faces are numbers of
/// vertices, counter-clockwise as the normals' side sees them. Without faces: a cloud of points.
struct SolidPart {
  std::string name{};
  std::vector<Eigen::Vector3f> vertices{};  ///< m
  std::vector<Eigen::Vector3f> normals{};   ///< unit, one a vertex
  std::vector<Rgb> colours{};               ///< one a vertex
  std::vector<std::array<std::uint32_t, 4>> quads{};
  std::vector<std::array<std::uint32_t, 3>> triangles{};

  bool cloud() const { return quads.empty() && triangles.empty(); }
};

struct Solid {
  std::vector<SolidPart> parts;
};

struct SolidCount {
  std::size_t parts = 0, vertices = 0, quads = 0, triangles = 0;
  std::size_t points = 0;  ///< vertices of clouds
};
SolidCount count(const Solid& solid);

/// A rectangle with corners `corner`, + u, + u + v, + v; seen from the side of u x v.
void add_rectangle(SolidPart& part, const Eigen::Vector3d& corner, const Eigen::Vector3d& u,
                   const Eigen::Vector3d& v, const Rgb& colour);

/// Do all vertices have a normal and a colour, are all numbers finite and all faces of vertices
/// that there are?
bool well_formed(const Solid& solid);

}  // namespace majak::map
