// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/demonstration.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "majak/core/error.hpp"
#include "tests/support/park_drive.hpp"

namespace majak::eval {
namespace {

const std::vector<Event>& park_drive() {
  static const std::vector<Event> events = test::park_drive();
  return events;
}

/// The same as somebody without truth would have it.
std::vector<Event> without_truth(std::vector<Event> events) {
  std::erase_if(events, [](const Event& e) { return std::holds_alternative<Truth>(e); });
  return events;
}

DemonstrationOptions options() {
  DemonstrationOptions options;
  options.ekf.wheelbase = test::kParkWheelbase;
  options.cut_off = 15;
  return options;
}

Demonstration with_truth() {
  DemonstrationOptions input = options();
  input.trunks = test::park_trunks();
  return demonstrate(park_drive(), input);
}

Demonstration on_fixes() {
  const std::vector<Event> blind = without_truth(park_drive());
  return demonstrate(blind, options());
}

std::vector<Feed> feeds(const Demonstration& d) {
  std::vector<Feed> all;
  for (const DemonstrationRun& run : d.runs) all.push_back(run.feed);
  return all;
}

TEST(Demonstration, AgainstTheTruthWhereItIsKnown) {
  const Demonstration d = with_truth();
  EXPECT_EQ(feeds(d), (std::vector<Feed>{Feed::none, Feed::cut_off, Feed::all}));
  for (const DemonstrationRun& run : d.runs)
    for (const DemonstrationAnswer* a : {&run.ekf, &run.graph})
      for (const PathScore& s : a->scores)
        EXPECT_EQ(s.errors.size(), a->map.localization.estimates.size());
  const Headline place = headline(pooled(d, Feed::all, Against::held_out, true));
  EXPECT_LT(place.mean.mean, 0.5);
  EXPECT_GT(place.mean.high, place.mean.mean);
  EXPECT_TRUE(place.nis);
}

TEST(Demonstration, TheFirstPoseIsMadeEqual) {
  for (const Demonstration& d : {with_truth(), on_fixes()}) {
    const auto errors = pooled(d, Feed::none, Against::first_pose, true);
    EXPECT_LT(errors.front().error(), 1e-9);
    EXPECT_GT(errors.back().error(), 1e-3);
  }
}

TEST(Demonstration, AlignmentIsTheLeastSquaresOne) {
  const Demonstration d = on_fixes();
  const auto sum = [&](Against against) {
    double squares = 0;
    for (const PlaceError& e : pooled(d, Feed::none, against, true))
      if (e.sound) squares += e.off.squaredNorm();
    return squares;
  };
  EXPECT_LT(sum(Against::aligned), sum(Against::first_pose));
}

TEST(Demonstration, OnFixesScoresWhatWasWithheldAndNothingElse) {
  const Demonstration d = on_fixes();
  EXPECT_EQ(feeds(d),
            (std::vector<Feed>{Feed::none, Feed::fold, Feed::fold, Feed::cut_off, Feed::all}));
  for (const DemonstrationRun& run : d.runs)
    for (const PathScore& s : run.graph.scores) {
      if (s.against != Against::held_out) continue;
      std::set<Time> withheld;
      for (std::size_t i = 0; i < run.withheld.size(); ++i)
        if (run.withheld[i]) withheld.insert(d.fixes.fixes[i].time);
      EXPECT_EQ(s.errors.empty(), withheld.empty());
      for (const PlaceError& e : s.errors) EXPECT_TRUE(withheld.contains(e.time));
    }
}

TEST(Demonstration, WhatIsWithheldDoesNotMoveThePath) {
  std::vector<Event> events = without_truth(park_drive());
  const Demonstration before = demonstrate(events, options());
  std::size_t fix = 0;
  for (Event& event : events)
    if (auto* f = std::get_if<GpsFix>(&event); f && before.runs[1].withheld[fix++]) f->east += 100;
  const Demonstration after = demonstrate(events, options());
  const auto end = [](const Demonstration& d) {
    return d.runs[1].graph.map.localization.estimates.back().T_map_robot;
  };
  EXPECT_EQ(end(before).x, end(after).x);
  EXPECT_EQ(end(before).theta, end(after).theta);
  EXPECT_GT(headline(pooled(after, Feed::fold, Against::held_out, true), false).mean.mean, 20);
}

TEST(Demonstration, ObstaclesAgainstTheTrueOnesAndAgainstThemselves) {
  const Demonstration d = with_truth();
  for (const DemonstrationAnswer* a : {&d.with_all().ekf, &d.with_all().graph}) {
    ASSERT_TRUE(a->obstacles.match);
    EXPECT_GT(a->obstacles.match->pairs.size(), 20U);
    EXPECT_LT(a->obstacles.aligned->error.rms, a->obstacles.match->error.rms);
    EXPECT_LT(headline(*a->obstacles.match, d.trunks).mean.mean, 0.5);
    EXPECT_FALSE(a->obstacles.sightings.empty());
  }
  EXPECT_FALSE(on_fixes().with_all().graph.obstacles.match);
}

TEST(Demonstration, WithoutSatellitesThereIsOneRun) {
  std::vector<Event> events = park_drive();
  std::erase_if(events, [](const Event& e) { return std::holds_alternative<GpsFix>(e); });
  const Demonstration d = demonstrate(events, options());
  EXPECT_EQ(feeds(d), std::vector<Feed>{Feed::none});
  EXPECT_EQ(&d.alone(), &d.with_all());
}

TEST(Demonstration, TimesOfEachScanWhereThereIsAClock) {
  double seconds = 0;
  DemonstrationOptions input = options();
  input.clock = [&seconds] { return seconds += 0.5; };
  const Demonstration d = demonstrate(park_drive(), input);
  const auto& steps = d.alone().steps;
  ASSERT_EQ(steps.size(), d.alone().ekf.map.localization.estimates.size());
  for (const StepTime& s : steps) EXPECT_EQ(s.seconds, 0.5);
  EXPECT_GT(steps.back().landmarks, 20U);
  EXPECT_GT(d.alone().ekf.cpu, d.alone().graph.cpu);
}

TEST(Demonstration, RefusesWhatCannotBeMeasured) {
  const std::vector<Event> nothing;
  EXPECT_THROW(demonstrate(nothing, options()), Error);
  std::vector<Event> events = without_truth(park_drive());
  std::erase_if(events, [](const Event& e) { return std::holds_alternative<GpsFix>(e); });
  EXPECT_THROW(demonstrate(events, options()), Error);
}

TEST(Headline, SaysMeanScatterAndNis) {
  const std::vector<PlaceError> errors = {{0, {3, 0}, 1, true, 1.0},
                                          {1, {5, 0}, 1, true, 3.0},
                                          {2, {0, 1}, 2, true, {}},
                                          {3, {100, 0}, 2, false, 50.0}};
  const Headline h = headline(errors);
  EXPECT_EQ(h.stats.count, 3U);
  EXPECT_EQ(h.groups, 2U);
  EXPECT_DOUBLE_EQ(h.mean.mean, 3);
  EXPECT_DOUBLE_EQ(h.stats.median, 3);
  EXPECT_DOUBLE_EQ(h.scatter, 1);  // of one group with two errors: 1 m each about its mean
  EXPECT_DOUBLE_EQ(*h.nis, 2);
  EXPECT_EQ(headline(errors, false).stats.count, 4U);
  EXPECT_EQ(headline(std::vector<PlaceError>{}).stats.count, 0U);
}

}  // namespace
}  // namespace majak::eval
