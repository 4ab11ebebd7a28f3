// SPDX-License-Identifier: Apache-2.0
#include "majak/methods/mappers.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/simulator.hpp"
#include "majak/sim/tour.hpp"

namespace majak::methods {
namespace {

/// A quarter of a drive through a building: 25 m.
const std::vector<Event>& drive() {
  static const std::vector<Event> events = [] {
    const sim::World world(sim::building());
    std::vector<Event> all = sim::simulate(world, sim::plan_tour(world, {.short_tour = true}), {});
    all.resize(all.size() / 4);
    return all;
  }();
  return events;
}

slam::Mapping map_with(const MappingMethod& method, const std::vector<Event>& events, int threads) {
  const slam::Mapper mapper = method.make({}, {threads});
  for (const Event& event : events) mapper.add(event);
  return mapper.finish();
}

TEST(Mappers, EveryRowIsComplete) {
  std::set<std::string> names;
  for (const MappingMethod& m : mapping_methods()) {
    EXPECT_TRUE(names.insert(m.name).second) << m.name << " stands twice";
    for (const char* words : {m.name, m.in_the_thesis, m.needs, m.yields})
      EXPECT_GE(std::string(words).size(), 2U) << m.name;
  }
  EXPECT_STREQ(mapping_methods().front().name, "graph-slam");
}

TEST(Mappers, PlaceEveryScanTheSameWayForAnyNumberOfThreads) {
  for (const MappingMethod& m : mapping_methods()) {
    const slam::Mapping one = map_with(m, drive(), 1), three = map_with(m, drive(), 3);
    ASSERT_EQ(one.site.scans.size(), three.site.scans.size()) << m.name;
    ASSERT_GT(one.site.scans.size(), 300U) << m.name;
    for (std::size_t i = 0; i < one.site.scans.size(); ++i) {
      const Estimate &a = one.site.scans[i].estimate, &b = three.site.scans[i].estimate;
      ASSERT_TRUE(a.T_map_robot.finite()) << m.name;
      ASSERT_EQ(a.T_map_robot.vector(), b.T_map_robot.vector()) << m.name << ", scan " << i;
      ASSERT_EQ(a.covariance, b.covariance) << m.name << ", scan " << i;
      ASSERT_EQ(a.time, one.site.scans[i].scan.time) << m.name;
    }
    EXPECT_GT(one.belief_bytes, 0U) << m.name;
  }
}

TEST(Mappers, SayThatThereIsNothingToMap) {
  for (const MappingMethod& m : mapping_methods()) {
    EXPECT_THROW(map_with(m, {}, 1), Error) << m.name;
    EXPECT_THROW(map_with(m, {Odometry{0, {}, {}, {}}}, 1), Error) << m.name;
  }
}

TEST(Mappers, AreFoundByName) {
  EXPECT_STREQ(mapping_method("incremental-ml").name, "incremental-ml");
  EXPECT_STREQ(mapping_method("stochastic-map").name, "ekf-slam");
  try {
    mapping_method("magic");
    FAIL();
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), testing::HasSubstr("no method magic"));
    EXPECT_THAT(e.what(), testing::HasSubstr("graph-slam"));
  }
}

TEST(Mappers, DescribeEveryOptionOnce) {
  MappingOptions options;
  OptionFields fields;
  describe(fields, options);
  std::set<std::string> names;
  for (const OptionField& field : fields.list)
    EXPECT_TRUE(names.insert(field.name).second) << field.name << " stands twice";
}

}  // namespace
}  // namespace majak::methods
