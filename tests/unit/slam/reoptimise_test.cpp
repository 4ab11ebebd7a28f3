// SPDX-License-Identifier: Apache-2.0
// A map optimised anew from its Site: the laws that make switching closures safe.
#include "majak/slam/reoptimise.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/map/edits.hpp"
#include "tests/unit/slam/simulated.hpp"

namespace majak::slam {
namespace {

/// A lap and a quarter round a ring so long that without its closures the map is half a metre off.
const Site& ring_site() {
  static const Site site = map_of(simulated_run("large_ring"));
  return site;
}
/// Much of it is seen twice, with closures or without.
const Site& building_site() {
  static const Site site = map_of(building_run());
  return site;
}

std::vector<std::pair<std::size_t, std::size_t>> closures(const Site& site) {
  std::vector<std::pair<std::size_t, std::size_t>> all;
  for (const Constraint& c : site.constraints)
    if (c.kind == ConstraintKind::closure) all.emplace_back(c.from, c.to);
  return all;
}

void expect_same(const Site& a, const Site& b) {
  ASSERT_EQ(a.scans.size(), b.scans.size());
  for (std::size_t i = 0; i < a.scans.size(); ++i) {
    const Estimate &e = a.scans[i].estimate, &f = b.scans[i].estimate;
    ASSERT_EQ(e.T_map_robot, f.T_map_robot) << i;
    ASSERT_EQ(e.covariance, f.covariance) << i;
    ASSERT_EQ(e.health, f.health) << i;
    ASSERT_EQ(e.weak_direction, f.weak_direction) << i;
    ASSERT_EQ(a.scans[i].match_score, b.scans[i].match_score) << i;
  }
  ASSERT_EQ(a.constraints.size(), b.constraints.size());
  for (std::size_t i = 0; i < a.constraints.size(); ++i) {
    const Constraint &c = a.constraints[i], &d = b.constraints[i];
    ASSERT_EQ(c.kind, d.kind) << i;
    ASSERT_EQ(c.from, d.from) << i;
    ASSERT_EQ(c.to, d.to) << i;
    ASSERT_EQ(c.T_from_to, d.T_from_to) << i;
    ASSERT_EQ(c.information, d.information) << i;
    ASSERT_EQ(c.chi2, d.chi2) << i;
    ASSERT_EQ(c.enabled, d.enabled) << i;
  }
  ASSERT_EQ(a.key_links.size(), b.key_links.size());
}

double farthest_apart(const Site& a, const Site& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.scans.size(); ++i)
    most = std::max(most, (a.scans[i].estimate.T_map_robot.translation() -
                           b.scans[i].estimate.T_map_robot.translation())
                              .norm());
  return most;
}

Site without_all(Site site) {
  for (const auto& [from, to] : closures(site)) map::switch_closure(site, from, to, false);
  return site;
}

TEST(Reoptimised, IsTheSameBitByBitWhereNothingIsSwitched) {
  expect_same(reoptimised(ring_site(), {}, {1}), ring_site());
  expect_same(reoptimised(building_site(), {}, {2}), building_site());
}

TEST(Reoptimised, HasItsOldBytesBackWhenSwitchedOnAgain) {
  Site off = reoptimised(without_all(ring_site()), {}, {2});
  EXPECT_GT(farthest_apart(off, ring_site()), 0.3);  // 0.45
  for (const auto& [from, to] : closures(off)) map::switch_closure(off, from, to, true);
  expect_same(reoptimised(off, {}, {1}), ring_site());
}

TEST(Reoptimised, DoesNotDependOnThreads) {
  const Site off = without_all(ring_site());
  expect_same(reoptimised(off, {}, {1}), reoptimised(off, {}, {3}));
}

/// As long as the search finds no others in their place.
TEST(Reoptimised, IsTheMapThatIsMadeWithoutThoseClosures) {
  GraphSlamOptions options;
  options.loops.switched_off = closures(building_site());
  const Site mapped = map_of(building_run(), options);
  for (const Constraint& c : mapped.constraints)
    ASSERT_TRUE(c.kind != ConstraintKind::closure || !c.enabled);
  const Site site = reoptimised(without_all(building_site()), {}, {2});
  // What the search says of closures that are off depends on where it began; all else is the same.
  EXPECT_EQ(farthest_apart(site, mapped), 0);
  EXPECT_GT(farthest_apart(site, building_site()), 0.005);  // 0.010
}

TEST(Reoptimised, AWrongClosureDoesItsHarmAndIsTakenOut) {
  Site wrong = ring_site();
  const auto [from, to] = closures(wrong).front();
  for (Constraint& c : wrong.constraints) {
    if (c.kind != ConstraintKind::closure || c.from != from || c.to != to) continue;
    c.T_from_to = c.T_from_to * Pose2{2.0, 0.6, 0.05};
    c.information *= 100;
  }
  wrong = reoptimised(wrong, {}, {2});
  EXPECT_GT(error_of(wrong).worst, 0.3);  // 0.43
  Site mended = wrong, without = ring_site();
  map::switch_closure(mended, from, to, false);
  map::switch_closure(without, from, to, false);
  mended = reoptimised(mended, {}, {2}), without = reoptimised(without, {}, {2});
  for (std::size_t i = 0; i < mended.scans.size(); ++i)
    ASSERT_EQ(mended.scans[i].estimate.T_map_robot, without.scans[i].estimate.T_map_robot);
  EXPECT_LT(error_of(mended).worst, 0.1);
}

TEST(Reoptimised, KeepsEditsAndSaysWhichAreOff) {
  Site site = ring_site();
  const auto [from, to] = closures(site).front();
  EXPECT_FALSE(switched_off(site, from, to));
  map::switch_closure(site, from, to, false);
  const Site after = reoptimised(site, {}, {1});
  EXPECT_EQ(after.edits, site.edits);
  EXPECT_TRUE(switched_off(after, from, to));
  for (const Constraint& c : after.constraints)
    EXPECT_FALSE(c.kind == ConstraintKind::closure && c.from == from && c.to == to && c.enabled);
}

TEST(Reoptimised, RefusesASiteThatKnowsTooLittle) {
  Site site = ring_site();
  site.key_links.clear();
  EXPECT_THROW(reoptimised(site, {}, {1}), Error);
  EXPECT_THROW(reoptimised(Site{}, {}, {1}), Error);
  site = ring_site();
  site.key_links[3].local_map = 4;
  EXPECT_THROW(reoptimised(site, {}, {1}), Error);
}

}  // namespace
}  // namespace majak::slam
