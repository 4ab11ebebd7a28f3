// SPDX-License-Identifier: Apache-2.0
#include "majak/map/planes.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/map/solid_map.hpp"

namespace majak::map {
namespace {

constexpr double kVoxel = 0.1;

/// Points on a rectangle, one a cube's width, with noise across it.
void add_patch(SolidCloud& cloud, const Vec3& corner, const Vec3& u, const Vec3& v, double sigma,
               RandomStream& random) {
  const Vec3 normal = u.cross(v).normalized();
  const int nu = static_cast<int>(u.norm() / kVoxel), nv = static_cast<int>(v.norm() / kVoxel);
  for (int i = 0; i < nu; ++i)
    for (int k = 0; k < nv; ++k) {
      SolidPoint p;
      p.mean = corner + (i + 0.5) / nu * u + (k + 0.5) / nv * v + sigma * random.normal() * normal;
      p.normal =
          (normal + 0.05 * Vec3(random.normal(), random.normal(), random.normal())).normalized();
      p.towards = normal;
      p.count = 3;
      cloud.points.push_back(p);
    }
}

/// A room of 5 x 4 x 2.5 m seen from inside: x = 0, x = 5, y = 0, y = 4, floor, ceiling.
SolidCloud room(double sigma) {
  SolidCloud cloud;
  RandomStream random(7);
  const Vec3 x{5, 0, 0}, y{0, 4, 0}, z{0, 0, 2.5}, o = Vec3::Zero();
  add_patch(cloud, o, y, z, sigma, random);
  add_patch(cloud, x, z, y, sigma, random);
  add_patch(cloud, o, z, x, sigma, random);
  add_patch(cloud, y, x, z, sigma, random);
  add_patch(cloud, o, x, y, sigma, random);
  add_patch(cloud, z, y, x, sigma, random);
  return cloud;
}

const Plane* nearest(const PlaneMap& map, const Vec3& normal, double offset) {
  const auto off = [&](const Plane& p) {
    return (p.normal - normal).norm() + std::abs(p.offset - offset);
  };
  const auto best =
      std::min_element(map.planes.begin(), map.planes.end(),
                       [&](const Plane& a, const Plane& b) { return off(a) < off(b); });
  return best == map.planes.end() ? nullptr : &*best;
}

TEST(Planes, OfARoomAreItsSixSides) {
  const SolidCloud cloud = room(0.01);
  const PlaneMap map = find_planes(cloud);
  ASSERT_EQ(map.planes.size(), 6u);
  const std::pair<Vec3, double> sides[] = {{{1, 0, 0}, 0},   {{-1, 0, 0}, -5}, {{0, 1, 0}, 0},
                                           {{0, -1, 0}, -4}, {{0, 0, 1}, 0},   {{0, 0, -1}, -2.5}};
  for (const auto& [normal, offset] : sides) {
    const Plane* plane = nearest(map, normal, offset);
    EXPECT_LT(std::acos(plane->normal.dot(normal)), radians(0.075));
    EXPECT_NEAR(plane->offset, offset, 0.002);
    EXPECT_NEAR(plane->rms, 0.01, 0.001);
  }
  EXPECT_GT(std::count_if(map.plane_of.begin(), map.plane_of.end(), [](int p) { return p >= 0; }),
            0.97 * static_cast<double>(cloud.points.size()));
}

/// At the end no plane moves: each is the least-squares plane of the shares that all planes at
/// once, everywhere, give; by the definition, without blocks.
TEST(Planes, AreAFixedPointOfTheDefinition) {
  const SolidCloud cloud = room(0.01);
  const PlaneOptions options;
  const PlaneMap map = find_planes(cloud, options);
  for (std::size_t j = 0; j < map.planes.size(); ++j) {
    double weight = 0;
    Vec3 sum = Vec3::Zero();
    Mat3 squares = Mat3::Zero();
    for (const SolidPoint& p : cloud.points) {
      double all = std::exp(-options.gate * options.gate / 2);
      for (const Plane& plane : map.planes) all += explains(plane, p, options);
      const double r = explains(map.planes[j], p, options) / all;
      weight += r, sum += r * p.mean, squares += r * p.mean * p.mean.transpose();
    }
    const Vec3 mean = sum / weight;
    const Eigen::SelfAdjointEigenSolver<Mat3> axes(squares / weight - mean * mean.transpose());
    const Plane& plane = map.planes[j];
    EXPECT_GT(std::abs(axes.eigenvectors().col(0).dot(plane.normal)), 1 - 1e-8);
    EXPECT_NEAR(plane.normal.dot(mean), plane.offset, 1e-4);
    EXPECT_NEAR(weight, plane.support, 1e-3 * weight);
  }
}

TEST(Planes, ExplainLessWithDistanceAndTurnAndNothingFromBehind) {
  const PlaneOptions o;
  Plane plane;
  SolidPoint p;
  p.normal = p.towards = Vec3::UnitZ();
  EXPECT_EQ(explains(plane, p, o), 1);
  p.mean.z() = o.sigma;
  EXPECT_NEAR(explains(plane, p, o), std::exp(-0.5), 1e-12);
  p.mean.z() = 0, p.normal = rotation_of(0.01, 0, 0) * Vec3::UnitZ();
  EXPECT_NEAR(explains(plane, p, o), std::exp(-0.5 * std::pow(0.01 / o.normal_sigma, 2)), 1e-6);
  p.towards = -Vec3::UnitZ();
  EXPECT_EQ(explains(plane, p, o), 0);
}

TEST(Planes, ThinWallsHaveTwoFaces) {
  SolidCloud cloud;
  RandomStream random(3);
  add_patch(cloud, {0, 0.04, 0}, {0, 0, 2}, {3, 0, 0}, 0.005, random);   // faces +y
  add_patch(cloud, {0, -0.04, 0}, {3, 0, 0}, {0, 0, 2}, 0.005, random);  // faces -y
  const PlaneMap map = find_planes(cloud);
  ASSERT_EQ(map.planes.size(), 2u);
  EXPECT_NEAR(nearest(map, {0, 1, 0}, 0.04)->offset, 0.04, 0.001);
  EXPECT_NEAR(nearest(map, {0, -1, 0}, 0.04)->offset, 0.04, 0.001);
}

TEST(Planes, WhatLiesInOneLineFarApartIsNotOne) {
  SolidCloud cloud;
  RandomStream random(4);
  add_patch(cloud, {0, 0, 0}, {0, 0, 2}, {3, 0, 0}, 0.005, random);
  add_patch(cloud, {8, 0.01, 0}, {0, 0, 2}, {3, 0, 0}, 0.005, random);
  const PlaneMap map = find_planes(cloud);
  ASSERT_EQ(map.planes.size(), 2u);
  EXPECT_NEAR(std::abs(map.planes[0].offset - map.planes[1].offset), 0.01, 0.002);
}

TEST(Planes, HalvesOfOneAreOne) {
  SolidCloud cloud;
  RandomStream random(5);
  add_patch(cloud, {0, 0, 0}, {0, 0, 2}, {3, 0, 0}, 0.005, random);
  add_patch(cloud, {3, 0.004, 0}, {0, 0, 2}, {3, 0, 0}, 0.005, random);
  EXPECT_EQ(find_planes(cloud).planes.size(), 1u);
}

TEST(Planes, ThereAreNoneWhereNothingIsFlat) {
  SolidCloud cloud;
  RandomStream random(6);
  for (int i = 0; i < 3000; ++i) {
    SolidPoint p;
    p.mean = {random.uniform(0, 3), random.uniform(0, 3), random.uniform(0, 3)};
    p.normal = Vec3(random.normal(), random.normal(), random.normal()).normalized();
    p.towards = p.normal;
    p.count = 1;
    cloud.points.push_back(p);
  }
  EXPECT_TRUE(find_planes(cloud).planes.empty());
  EXPECT_TRUE(find_planes(SolidCloud{}).planes.empty());
}

TEST(Planes, SmallerThanThePenaltyAreNone) {
  SolidCloud cloud;
  RandomStream random(8);
  add_patch(cloud, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0.005, random);
  EXPECT_EQ(find_planes(cloud, {.min_area = 0.5}).planes.size(), 1u);
  EXPECT_EQ(find_planes(cloud, {.min_area = 1.1}).planes.size(), 0u);
  EXPECT_GT(find_planes(cloud, {.min_area = 0.5}).log_likelihood, 0);
}

TEST(Planes, TheSameForAnyThreadsAndNearlyForAnySeed) {
  const SolidCloud cloud = room(0.01);
  const PlaneMap one = find_planes(cloud);
  for (const int threads : {2, 8}) {
    const PlaneMap more = find_planes(cloud, {}, {threads});
    ASSERT_EQ(more.planes.size(), one.planes.size());
    for (std::size_t j = 0; j < one.planes.size(); ++j) {
      EXPECT_EQ(more.planes[j].normal, one.planes[j].normal);
      EXPECT_EQ(more.planes[j].offset, one.planes[j].offset);
    }
    EXPECT_EQ(more.plane_of, one.plane_of);
  }
  const PlaneMap other = find_planes(cloud, {.seed = 2});
  ASSERT_EQ(other.planes.size(), 6u);
  for (const Plane& plane : one.planes)
    EXPECT_NEAR(nearest(other, plane.normal, plane.offset)->offset, plane.offset, 1e-4);
}

TEST(Planes, OptionsOutOfRangeAreRefused) {
  EXPECT_THROW(find_planes({}, {.sigma = 0}), Error);
  EXPECT_THROW(find_planes({}, {.gate = 0.5}), Error);
  EXPECT_THROW(find_planes({}, {.block = 0}), Error);
}

/// m^2 of a part's quads.
double area(const SolidPart& part) {
  double sum = 0;
  for (const auto& q : part.quads)
    sum += static_cast<double>((part.vertices[q[1]] - part.vertices[q[0]])
                                   .cross(part.vertices[q[3]] - part.vertices[q[0]])
                                   .norm());
  return sum;
}

TEST(SolidMap, WhatIsFlatIsFewRectanglesOfItsSize) {
  SolidCloud cloud = room(0.005);
  const Solid solid = build_solid(cloud, find_planes(cloud));
  EXPECT_TRUE(well_formed(solid));
  ASSERT_EQ(solid.parts.size(), 6u);
  int walls = 0;
  for (const SolidPart& part : solid.parts) {
    const bool wall = part.name.starts_with("wall");
    walls += wall;
    EXPECT_TRUE(wall || part.name == "floor 1" || part.name == "ceiling 1") << part.name;
    EXPECT_LT(part.quads.size(), 20u);
  }
  EXPECT_EQ(walls, 4);
  double all = 0;
  for (const SolidPart& part : solid.parts) all += area(part);
  EXPECT_NEAR(all, 85, 5);  // 2 (5 x 4 + 5 x 2.5 + 4 x 2.5), edges to a cube
}

TEST(SolidMap, RectanglesFaceAsTheirPlaneDoes) {
  const SolidCloud cloud = room(0.005);
  const PlaneMap planes = find_planes(cloud);
  const Solid solid = build_solid(cloud, planes);
  for (std::size_t j = 0; j < solid.parts.size(); ++j)
    for (const Eigen::Vector3f& n : solid.parts[j].normals)
      EXPECT_GT(n.cast<double>().dot(planes.planes[j].normal), 1 - 1e-6);
}

TEST(SolidMap, GapsAreFilledAndDoorsAreNot) {
  SolidCloud cloud;
  RandomStream random(9);
  add_patch(cloud, {0, 0, 0}, {0, 0, 2}, {3, 0, 0}, 0.002, random);
  const auto without = [&](double from, double to) {
    SolidCloud some = cloud;
    std::erase_if(some.points,
                  [&](const SolidPoint& p) { return p.mean.x() > from && p.mean.x() < to; });
    const Solid solid = build_solid(some, find_planes(some));
    double sum = 0;
    for (const SolidPart& part : solid.parts) sum += area(part);
    return sum;
  };
  EXPECT_NEAR(without(9, 9), 6, 0.35);
  EXPECT_NEAR(without(1, 1.3), 6, 0.35);
  EXPECT_NEAR(without(1, 2), 4, 0.35);
}

TEST(SolidMap, ColoursAreGreysOfTheIntensity) {
  SolidCloud cloud;
  RandomStream random(10);
  add_patch(cloud, {0, 0, 0}, {0, 0, 2}, {2, 0, 0}, 0.002, random);
  add_patch(cloud, {0, 0, 0}, {2, 0, 0}, {0, 2, 0}, 0.002, random);
  cloud.has_intensity = true;
  for (SolidPoint& p : cloud.points) p.intensity = p.normal.z() > 0.5 ? 1000.f : 10.f;
  const Solid solid = build_solid(cloud, find_planes(cloud));
  ASSERT_EQ(solid.parts.size(), 2u);
  for (const SolidPart& part : solid.parts) {
    const std::uint8_t grey = part.name == "floor 1" ? 250 : 40;
    EXPECT_EQ(part.colours[0], (Rgb{grey, grey, grey})) << part.name;
  }
}

TEST(SolidMap, WhatIsOfNoPlaneStaysTriangles) {
  SolidCloud cloud;
  RandomStream random(11);
  add_patch(cloud, {0, 0, 0}, {2, 0, 0}, {0, 2, 0}, 0.002, random);
  const auto n = static_cast<std::uint32_t>(cloud.points.size());
  for (int i = 0; i < 3; ++i) {
    SolidPoint p;
    p.mean = {1.0 + 0.1 * i, 1.0, 0.5 + 0.05 * i * i};
    p.towards = Vec3::UnitZ();
    p.count = 1;
    cloud.points.push_back(p);
  }
  cloud.triangles = {{0, 1, 40}, {n, n + 1, n + 2}, {5, n, n + 1}};
  const Solid solid = build_solid(cloud, find_planes(cloud));
  ASSERT_EQ(solid.parts.size(), 2u);
  EXPECT_EQ(solid.parts[1].name, "rest");
  EXPECT_EQ(solid.parts[1].triangles.size(), 2u);
  EXPECT_EQ(solid.parts[1].vertices.size(), 4u);
  EXPECT_TRUE(well_formed(solid));
  EXPECT_EQ(count(points_solid(cloud)).points, cloud.points.size());
  EXPECT_EQ(count(mesh_solid(cloud)).triangles, 3u);
}

TEST(SolidMap, OfNothingIsNothing) {
  EXPECT_TRUE(build_solid({}, {}).parts.empty());
  EXPECT_THROW(build_solid({}, {}, {.close = -1}), Error);
}

}  // namespace
}  // namespace majak::map
