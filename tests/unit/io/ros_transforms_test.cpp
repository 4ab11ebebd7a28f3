// SPDX-License-Identifier: Apache-2.0
#include "majak/io/ros_transforms.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>

#include "majak/core/random.hpp"

namespace majak::io {
namespace {

ros::Transform transform(double x, double y, double z, const Eigen::Quaterniond& q) {
  return {{x, y, z}, {q.x(), q.y(), q.z(), q.w()}};
}
Eigen::Quaterniond about(const Vec3& axis, double angle) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis.normalized()));
}
ros::StampedTransform link(std::string parent, std::string child, const ros::Transform& t) {
  return {{0, 0, std::move(parent)}, std::move(child), t};
}
ros::Transform random_transform(RandomStream& random) {
  const Vec3 axis(random.normal(), random.normal(), random.normal());
  return transform(random.normal(), random.normal(), random.normal(),
                   about(axis, random.uniform(-3, 3)));
}
void expect_near(const Motion3& a, const Motion3& b) {
  EXPECT_LT((a.rotation - b.rotation).norm(), 1e-12);
  EXPECT_LT((a.translation - b.translation).norm(), 1e-12);
}

TEST(Motion3, IsAGroupThatEigenAgreesWith) {
  RandomStream random(1);
  for (int i = 0; i < 50; ++i) {
    const ros::Transform t = random_transform(random), u = random_transform(random);
    const Motion3 a = motion_of(t), b = motion_of(u);
    expect_near(a * a.inverse(), {});
    expect_near((a * b).inverse(), b.inverse() * a.inverse());
    const Eigen::Quaterniond q(t.rotation[3], t.rotation[0], t.rotation[1], t.rotation[2]);
    EXPECT_LT((a.rotation - q.toRotationMatrix()).norm(), 1e-12);
    // Messages are not always of length one.
    ros::Transform longer = t;
    for (double& value : longer.rotation) value *= 3;
    expect_near(motion_of(longer), a);
  }
  expect_near(motion_of({{1, 2, 3}, {0, 0, 0, 0}}), {Mat3::Identity(), {1, 2, 3}});
}

TEST(PlanarPose, IsExactForTurnsInThePlane) {
  for (const double theta : {0.0, 1e-12, 0.5, -3.0, kPi, -1.5}) {
    const Pose2 pose = planar_pose(transform(1, 2, 3, about(Vec3::UnitZ(), theta)));
    EXPECT_EQ(pose.x, 1);
    EXPECT_EQ(pose.y, 2);
    EXPECT_NEAR(angle_diff(pose.theta, theta), 0, 4e-16) << theta;
  }
  EXPECT_EQ(planar_pose({}).theta, 0);
  // A slope does not change where it heads.
  const auto slope = about(Vec3::UnitZ(), 0.7) * about(Vec3::UnitY(), 0.2);
  EXPECT_NEAR(planar_pose(transform(0, 0, 0, slope)).theta, 0.7, 1e-12);
}

TEST(Mounting, KnowsLevelUpsideDownAndTilted) {
  const auto of = [](const Eigen::Quaterniond& q) {
    return mounting_of(motion_of(transform(0.1, 0.2, 0.3, q)));
  };
  const Mounting level = of(about(Vec3::UnitZ(), 0.5));
  EXPECT_NEAR(level.T_robot_laser.theta, 0.5, 1e-12);
  EXPECT_EQ(level.T_robot_laser.x, 0.1);
  EXPECT_EQ(level.T_robot_laser.y, 0.2);
  EXPECT_FALSE(level.upside_down || level.tilted);
  const Mounting down = of(about(Vec3::UnitZ(), 0.5) * about(Vec3::UnitX(), kPi));
  EXPECT_NEAR(down.T_robot_laser.theta, 0.5, 1e-12);
  EXPECT_TRUE(down.upside_down);
  EXPECT_FALSE(down.tilted);
  EXPECT_TRUE(of(about(Vec3::UnitY(), radians(16))).tilted);
  EXPECT_FALSE(of(about(Vec3::UnitY(), radians(14))).tilted);
  EXPECT_TRUE(of(about(Vec3::UnitX(), radians(150))).tilted);
}

//        map
//         |
//        odom
//         |
//     base_footprint
//         |
//      base_link
//       |     |
//     mast   wheel
//       |
//     laser
TEST(FrameTree, LeadsFromAnyFrameToAnyOther) {
  RandomStream random(2);
  FrameTree tree;
  std::map<std::string, Motion3> T_map_frame{{"map", {}}};
  const std::vector<std::pair<std::string, std::string>> links = {
      {"map", "odom"},       {"odom", "base_footprint"}, {"base_footprint", "base_link"},
      {"base_link", "mast"}, {"mast", "laser"},          {"base_link", "wheel"}};
  for (const auto& [parent, child] : links) {
    const ros::Transform t = random_transform(random);
    tree.set(link(parent, child, t));
    T_map_frame[child] = T_map_frame[parent] * motion_of(t);
  }
  for (const auto& [a, T_map_a] : T_map_frame) {
    for (const auto& [b, T_map_b] : T_map_frame) {
      const auto found = tree.find(a, b);
      ASSERT_TRUE(found) << a << " " << b;
      expect_near(*found, T_map_a.inverse() * T_map_b);
    }
  }
  EXPECT_FALSE(tree.find("laser", "elsewhere"));
  EXPECT_EQ(tree.parent_of("laser"), "mast");
  EXPECT_EQ(tree.parent_of("map"), "");
}

TEST(FrameTree, TheLastWordCountsOrTheFirst) {
  FrameTree tree;
  tree.set_if_new(link("a", "b", {{1, 0, 0}}));
  tree.set_if_new(link("a", "b", {{2, 0, 0}}));
  EXPECT_EQ(tree.find("a", "b")->translation.x(), 1);
  tree.set(link("a", "b", {{3, 0, 0}}));
  EXPECT_EQ(tree.find("a", "b")->translation.x(), 3);
  tree.set(link("c", "b", {{4, 0, 0}}));
  EXPECT_FALSE(tree.find("a", "b"));
}

TEST(FrameTree, CirclesAndNonsenseEndNowhere) {
  FrameTree tree;
  tree.set(link("a", "b", {}));
  tree.set(link("b", "a", {}));
  tree.set(link("s", "s", {}));
  EXPECT_FALSE(tree.find("a", "b"));
  EXPECT_TRUE(tree.find("s", "s"));
  tree.set(link("x", "y", {{std::numeric_limits<double>::quiet_NaN(), 0, 0}}));
  EXPECT_FALSE(tree.find("x", "y"));
  FrameTree deep;
  for (int i = 0; i < 200; ++i)
    deep.set(link("f" + std::to_string(i), "f" + std::to_string(i + 1), {}));
  EXPECT_TRUE(deep.find("f3", "f90"));
  EXPECT_FALSE(deep.find("f0", "f200"));
}

}  // namespace
}  // namespace majak::io
