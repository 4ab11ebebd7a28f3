// SPDX-License-Identifier: Apache-2.0
#include "majak/methods/methods.hpp"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "majak/core/error.hpp"
#include "tests/support/ascii_map.hpp"

namespace majak::methods {
namespace {

TEST(Methods, EveryRowIsComplete) {
  std::set<std::string> names;
  for (const Method& m : methods()) {
    EXPECT_TRUE(names.insert(m.name).second) << m.name << " stands twice";
    for (const char* words : {m.name, m.in_the_thesis, m.needs, m.yields})
      EXPECT_GT(std::string(words).size(), 3U) << m.name;
    LocalizeOptions options;
    options.place = localize::place_of(fixture::ascii_map({"#####", "#...#", "#####"}));
    const auto localizer = m.make(options);
    EXPECT_TRUE(localizer.add && localizer.finish) << m.name;
    EXPECT_TRUE(localizer.finish().estimates.empty()) << m.name << " knows where it is of nothing";
  }
  EXPECT_TRUE(names.count("dead-reckoning"));
}

TEST(Methods, SayWhenTheyNeedAMap) {
  for (const char* name : {"tracking", "monte-carlo"}) try {
      method(name).make({});
      FAIL() << name;
    } catch (const Error& e) {
      EXPECT_EQ(std::string(e.what()), std::string(name) + " needs --map MAP");
    }
}

TEST(Methods, AreFoundByName) {
  EXPECT_STREQ(method("dead-reckoning").name, "dead-reckoning");
  try {
    method("guessing");
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("dead-reckoning"), std::string::npos);
  }
}

TEST(Methods, OptionsAreDescribedOnce) {
  LocalizeOptions options;
  OptionFields fields;
  describe(fields, options);
  std::set<std::string> names;
  for (const OptionField& field : fields.list)
    EXPECT_TRUE(names.insert(field.name).second) << field.name << " stands twice";
}

TEST(Methods, EachOptionOfGlobalSearchHasItsName) {
  LocalizeOptions options;
  OptionFields fields;
  describe(fields, options);
  std::set<std::string> names;
  for (const OptionField& field : fields.list) {
    names.insert(field.name);
    if (field.name == "global.blocks") *std::get<int*>(field.value) = 7;
    if (field.name == "global.elsewhere") *std::get<double*>(field.value) = 0.25;
  }
  for (const char* name :
       {"effective", "through_wall", "wall", "elsewhere", "cell", "sigma", "random", "reach",
        "returns", "most", "apart", "apart_turn", "worse", "blocks"})
    EXPECT_TRUE(names.count(std::string("global.") + name)) << name;
  EXPECT_EQ(options.global.search.blocks, 7);
  EXPECT_EQ(options.global.elsewhere, 0.25);
}

TEST(Methods, OnAMapOnlyTrackingIsTold) {
  for (const Method& m : methods()) {
    EXPECT_EQ(m.on_map, std::string(m.needs).find("--map MAP") == 0) << m.name;
    if (m.on_map) {
      EXPECT_EQ(m.told, std::string(m.name) == "tracking") << m.name;
    }
  }
}

TEST(Methods, StartIsTaken) {
  LocalizeOptions options;
  options.start = {1, 2, 0.5};
  const auto localizer = method("dead-reckoning").make(options);
  EXPECT_EQ(localizer.add(Odometry{})->T_map_robot, options.start);
}

}  // namespace
}  // namespace majak::methods
