// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/solid_view.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace majak::draw {
namespace {

const Vec3 kLight = Vec3(0.5, -0.35, 0.8).normalized();

struct Tile {
  double distance = 0;
  Polyline shape;
};

Colour lit(const map::Rgb& c, const Vec3& normal) {
  const double light = 0.68 + 0.32 * normal.dot(kLight);
  const auto part = [&](std::uint8_t v) {
    return static_cast<std::uint8_t>(std::clamp(std::lround(v * light), 0L, 255L));
  };
  return {part(c.r), part(c.g), part(c.b)};
}

Vec3 vertex(const map::SolidPart& part, std::uint32_t i) { return part.vertices[i].cast<double>(); }

class Painter {
 public:
  Painter(const Camera& camera, double tile) : camera_(camera), tile_(tile) {}

  void add(const map::SolidPart& part) {
    for (const auto& q : part.quads) add_quad(part, q);
    for (const auto& t : part.triangles) {
      const Vec3 a = vertex(part, t[0]), b = vertex(part, t[1]), c = vertex(part, t[2]);
      add_tile({a, b, c}, (b - a).cross(c - a).normalized(), part.colours[t[0]]);
    }
  }

  std::vector<Mark> marks() && {
    std::stable_sort(tiles_.begin(), tiles_.end(),
                     [](const Tile& a, const Tile& b) { return a.distance > b.distance; });
    std::vector<Mark> marks;
    for (Tile& tile : tiles_) marks.emplace_back(std::move(tile.shape));
    return marks;
  }

 private:
  void add_quad(const map::SolidPart& part, const std::array<std::uint32_t, 4>& q) {
    const Vec3 corner = vertex(part, q[0]), u = vertex(part, q[1]) - corner,
               v = vertex(part, q[3]) - corner;
    const int nu = std::max(1, static_cast<int>(std::ceil(u.norm() / tile_ - 1e-6))),
              nv = std::max(1, static_cast<int>(std::ceil(v.norm() / tile_ - 1e-6)));
    for (int i = 0; i < nu; ++i)
      for (int k = 0; k < nv; ++k) {
        const Vec3 p = corner + i * u / nu + k * v / nv;
        add_tile({p, p + u / nu, p + u / nu + v / nv, p + v / nv},
                 part.normals[q[0]].cast<double>(), part.colours[q[0]]);
      }
  }

  void add_tile(const std::vector<Vec3>& corners, const Vec3& normal, const map::Rgb& colour) {
    Vec3 middle = Vec3::Zero();
    for (const Vec3& p : corners) middle += p / static_cast<double>(corners.size());
    if (!camera_.faces(normal, middle)) return;
    Tile tile;
    for (const Vec3& p : corners) tile.shape.points.push_back(camera_.see(p));
    const Colour fill = lit(colour, normal);
    tile.shape.closed = true;
    tile.shape.fill = fill;
    tile.shape.pen = {fill, 0.6};  // over the seams
    tile.distance = camera_.distance(middle);
    tiles_.push_back(std::move(tile));
  }

  const Camera& camera_;
  double tile_;
  std::vector<Tile> tiles_;
};

double area(const map::Solid& solid) {
  double sum = 0;
  for (const map::SolidPart& part : solid.parts)
    for (const auto& q : part.quads)
      sum += (vertex(part, q[1]) - vertex(part, q[0]))
                 .cross(vertex(part, q[3]) - vertex(part, q[0]))
                 .norm();
  return sum;
}

}  // namespace

Camera::Camera(const Vec3& eye, const Vec3& at) : eye_(eye), ahead_((at - eye).normalized()) {
  right_ = ahead_.cross(Vec3::UnitZ()).normalized();
  up_ = right_.cross(ahead_);
}

Point Camera::see(const Vec3& p) const {
  const Vec3 way = p - eye_;
  const double far = way.dot(ahead_);
  return {way.dot(right_) / far, way.dot(up_) / far};
}

Camera overlooking(const map::Solid& solid) {
  Vec3 low = Vec3::Constant(1e30), high = -low;
  for (const map::SolidPart& part : solid.parts)
    for (const Eigen::Vector3f& v : part.vertices)
      low = low.cwiseMin(v.cast<double>()), high = high.cwiseMax(v.cast<double>());
  if (low.x() > high.x()) low = high = Vec3::Zero();
  const Vec3 middle = (low + high) / 2;
  const double size = std::max((high - low).norm(), 1.0);
  return {middle + 1.05 * size * Vec3(-0.25, -0.8, 0.85), middle};
}

std::vector<Mark> view_of(const map::Solid& solid, const Camera& camera, double tile, int most) {
  Painter painter(camera, std::max(tile, std::sqrt(area(solid) / most)));
  for (const map::SolidPart& part : solid.parts) painter.add(part);
  return std::move(painter).marks();
}

}  // namespace majak::draw
