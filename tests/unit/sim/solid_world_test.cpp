// SPDX-License-Identifier: Apache-2.0
#include "majak/sim/solid_world.hpp"

#include <gtest/gtest.h>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/solid_simulator.hpp"

namespace majak::sim {
namespace {

TEST(SolidWorld, LevelRaysMeetWhatTheyMeetInThePlane) {
  const Scene scene = built_in("building");
  const World flat(scene);
  const SolidWorld solid(raised(scene));
  RandomStream random(1);
  for (int i = 0; i < 300; ++i) {
    const Vec2 p{random.uniform(0, 40), random.uniform(0, 25)};
    const double angle = random.uniform(-kPi, kPi), z = random.uniform(0.1, 2.4);
    if (flat.clearance(p) == 0) continue;  // within a pillar
    const Hit a = flat.cast(p, angle, 30);
    const SolidHit b = solid.cast({p.x(), p.y(), z}, {std::cos(angle), std::sin(angle), 0}, 30);
    if (std::isfinite(a.range))
      EXPECT_NEAR(a.range, b.range, 1e-9);
    else
      EXPECT_FALSE(std::isfinite(b.range));
    EXPECT_NEAR(a.incidence, b.incidence, 1e-6);
  }
}

TEST(SolidWorld, SlantedRaysMeetWallsFartherOffOrFloorAndCeiling) {
  const Scene scene = built_in("building");
  const World flat(scene);
  const SolidWorld solid(raised(scene, {.height = 3}));
  RandomStream random(2);
  for (int i = 0; i < 300; ++i) {
    const Vec2 p{random.uniform(1, 39), random.uniform(1, 24)};
    const double angle = random.uniform(-kPi, kPi), up = random.uniform(-1.4, 1.4), z = 1;
    const Vec3 way{std::cos(up) * std::cos(angle), std::cos(up) * std::sin(angle), std::sin(up)};
    const Hit wall = flat.cast(p, angle, 1000);
    if (!std::isfinite(wall.range)) continue;
    const double level = up > 0 ? (3 - z) / std::sin(up) : -z / std::sin(up);
    EXPECT_NEAR(solid.cast({p.x(), p.y(), z}, way, 1000).range,
                std::min(wall.range / std::cos(up), level), 1e-9);
  }
}

TEST(SolidWorld, BoxesAreClosedAndFaceOutwards) {
  SolidScene scene;
  add_box(scene, "box", {1, 2, 3}, {2, 4, 6});
  ASSERT_EQ(scene.patches.size(), 6u);
  double area = 0;
  for (const Patch& patch : scene.patches) {
    area += patch.area();
    const Vec3 out = patch.corner + (patch.u + patch.v) / 2 - Vec3(1.5, 3, 4.5);
    EXPECT_GT(out.dot(patch.normal()), 0.4);
  }
  EXPECT_NEAR(area, 2 * (2 + 3 + 6), 1e-12);
  const SolidWorld world(scene);
  EXPECT_NEAR(world.cast({1.5, 3, 10}, {0, 0, -1}, 20).range, 4, 1e-12);
  EXPECT_NEAR(world.cast({1.5, 3, 4}, {0, 0, -1}, 20).range, 1, 1e-12);
  EXPECT_EQ(world.cast({1.5, 3, 10}, {0, 0, -1}, 3.9).object, -1);
}

TEST(SolidWorld, PillarsEndAtTheirHeights) {
  SolidScene scene;
  scene.pillars.push_back({"post", {3, 0}, 0.5, 1, 2, 0.4});
  const SolidWorld world(scene);
  EXPECT_NEAR(world.cast({0, 0, 1.5}, {1, 0, 0}, 10).range, 2.5, 1e-12);
  EXPECT_NEAR(world.cast({0, 0, 1.5}, {1, 0, 0}, 10).incidence, 0, 1e-7);
  EXPECT_EQ(world.cast({0, 0, 2.5}, {1, 0, 0}, 10).object, -1);
  EXPECT_NEAR(world.cast({3, 0, 1.5}, {1, 0, 0}, 10).range, 0.5, 1e-12);  // from inside
  EXPECT_THROW(SolidWorld(SolidScene{}), Error);
}

class SolidPlaces : public testing::TestWithParam<bool> {
 protected:
  SolidRooms place_ = GetParam() ? solid_rooms() : solid_yard();
};

TEST_P(SolidPlaces, ATourLeadsThrough) {
  const World world(place_.plan);
  EXPECT_GT(length(plan_tour(world).points), 30);
}

TEST_P(SolidPlaces, TheFirstLaserIsUntouchedAndTheSecondExact) {
  const World world(place_.plan);
  const SolidWorld solid(place_.solid);
  Path path = plan_tour(world);
  path.points.resize(60);
  SimulationOptions options;
  scale_noise(options, 0);
  SecondLaserOptions second;
  second.nod = 0.3;
  second.mounting = map::looking("down");
  SolidSimulator both(world, solid, path, options, second);
  Simulator alone(world, path, options);
  int scans = 0;
  while (const auto event = both.next()) {
    const auto* scan = std::get_if<Scan>(&*event);
    if (scan == nullptr || scan->laser == 0) {
      const auto same = alone.next();
      ASSERT_TRUE(same);
      EXPECT_EQ(time_of(*same), time_of(*event));
      if (scan != nullptr) {
        EXPECT_EQ(std::get<Scan>(*same).ranges, scan->ranges);
      }
      continue;
    }
    ++scans;
    for (std::size_t i = 0; i < scan->ranges.size(); i += 30) {
      const Duration since = scan->time - from_seconds(options.start_time) +
                             sensor::beam_time(sensor::variant_of_beams(181), static_cast<int>(i));
      const Pose3 T =
          in_space(both.run().truth(since)) *
          second.mounting.T_robot_laser(0.3 * std::sin(2 * kPi * to_seconds(since) / 4));
      const double angle = scan->angle(i);
      const SolidHit hit =
          solid.cast(T.translation, T.rotation * Vec3(std::cos(angle), std::sin(angle), 0), 80);
      if (std::isfinite(hit.range)) {
        EXPECT_NEAR(scan->ranges[i], hit.range, 2e-4);
      }
    }
  }
  EXPECT_FALSE(alone.next());
  EXPECT_GT(scans, 20);
}

INSTANTIATE_TEST_SUITE_P(Both, SolidPlaces, testing::Bool());

TEST(SolidSimulator, NodsAsItsTrackSays) {
  const SolidRooms place = solid_rooms();
  const World world(place.plan);
  const SolidWorld solid(place.solid);
  Path path = plan_tour(world);
  path.points.resize(60);
  SecondLaserOptions second;
  second.nod = 0.3;
  SolidSimulator nodding(world, solid, path, {}, second);
  for (const double t : {0.0, 0.31, 1.0, 2.77})
    EXPECT_NEAR(nodding.tilt().at(from_seconds(1e9 + t)), 0.3 * std::sin(2 * kPi * t / 4), 1e-4);
  EXPECT_TRUE(SolidSimulator(world, solid, path, {}).tilt().empty());
}

}  // namespace
}  // namespace majak::sim
