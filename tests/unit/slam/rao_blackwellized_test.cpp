// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/rao_blackwellized.hpp"

#include <gtest/gtest.h>
#include <algorithm>

#include <numeric>

#include "majak/core/error.hpp"
#include "majak/filter/resampling.hpp"
#include "simulated.hpp"

namespace majak::slam {
namespace {

Mapping mapping_of(const std::vector<Event>& events, const RaoBlackwellizedOptions& options = {},
                   int threads = 1, const ScanChainOptions& chain = {}) {
  RaoBlackwellized slam(chain, options, {threads});
  for (const Event& event : events) slam.add(event);
  return slam.finish();
}

std::vector<Event> first_of(const std::vector<Event>& events, std::size_t count) {
  return {events.begin(), events.begin() + static_cast<std::ptrdiff_t>(count)};
}

const std::vector<Event>& ring_run() {
  static const std::vector<Event> events = simulated_run("ring", 1);
  return events;
}

TEST(RaoBlackwellized, AnyNumberOfThreadsGivesTheSameBytes) {
  const auto events = first_of(ring_run(), 900);
  const Mapping one = mapping_of(events);
  for (const int threads : {2, 8}) {
    const Mapping more = mapping_of(events, {}, threads);
    ASSERT_EQ(one.site.scans.size(), more.site.scans.size());
    EXPECT_EQ(one.belief_bytes, more.belief_bytes);
    for (std::size_t i = 0; i < one.site.scans.size(); ++i)
      ASSERT_EQ(one.site.scans[i].estimate.T_map_robot.vector(),
                more.site.scans[i].estimate.T_map_robot.vector());
  }
}

TEST(RaoBlackwellized, AnotherSeedGivesAnotherRun) {
  const auto events = first_of(ring_run(), 800);
  const Mapping one = mapping_of(events), two = mapping_of(events, {.seed = 2});
  EXPECT_NE(one.site.scans.back().estimate.T_map_robot.vector(),
            two.site.scans.back().estimate.T_map_robot.vector());
}

TEST(RaoBlackwellized, WeightsSumToOneAndTheEffectiveSizeStaysUp) {
  RaoBlackwellizedOptions options;
  options.particles = 10;
  RaoBlackwellized slam({}, options, {1});
  for (const Event& event : ring_run()) {
    if (!slam.add(event)) continue;
    const std::vector<double> w = slam.weights();
    ASSERT_EQ(w.size(), 10U);
    ASSERT_NEAR(std::accumulate(w.begin(), w.end(), 0.0), 1, 1e-12);
    ASSERT_GE(filter::effective_size(w), options.resample_below * 10);
  }
  EXPECT_GT(slam.resamplings(), 0U);
}

TEST(RaoBlackwellized, WithoutResamplingNoneIsDrawn) {
  RaoBlackwellizedOptions options;
  options.resample_below = 0;
  options.particles = 5;
  RaoBlackwellized slam({}, options, {1});
  for (const Event& event : ring_run()) slam.add(event);
  EXPECT_EQ(slam.resamplings(), 0U);
  EXPECT_LT(filter::effective_size(slam.weights()), 2.5);
}

// Luck has its part: the middle one of three seeds.
TEST(RaoBlackwellized, InARingTheRightParticleWins) {
  const auto middle = [](int particles) {
    std::vector<double> errors;
    for (const int seed : {1, 2, 3}) {
      RaoBlackwellizedOptions options;
      options.particles = particles, options.seed = seed;
      errors.push_back(error_of(mapping_of(ring_run(), options).site).rms);
    }
    std::sort(errors.begin(), errors.end());
    return errors[1];
  };
  EXPECT_LT(middle(30), 0.6 * middle(1));
}

TEST(RaoBlackwellized, ManyParticlesNeedLessThanAMapEach) {
  const auto events = first_of(building_run(), 1800);
  RaoBlackwellizedOptions options;
  const Mapping many = mapping_of(events, options);
  const auto count = static_cast<std::size_t>(options.particles);
  options.particles = 1;
  const Mapping one = mapping_of(events, options);
  EXPECT_LT(many.belief_bytes, 3 * count / 4 * one.belief_bytes);
  EXPECT_GT(many.belief_bytes, one.belief_bytes);
  EXPECT_LT(error_of(many.site).rms, 0.2);
  EXPECT_FALSE(many.posterior);
}

TEST(RaoBlackwellized, OneScanIsEnough) {
  for (std::size_t i = 0; i < building_run().size(); ++i) {
    if (!std::holds_alternative<Scan>(building_run()[i])) continue;
    const Site site = mapping_of({building_run()[i]}).site;
    ASSERT_EQ(site.scans.size(), 1U);
    EXPECT_EQ(site.scans[0].estimate.T_map_robot.vector(), Pose2{}.vector());
    break;
  }
  EXPECT_THROW(mapping_of({}), Error);
}

TEST(RaoBlackwellized, WorksWithoutOdometry) {
  ScanChainOptions chain;
  chain.use_odometry = false;
  const Mapping mapping = mapping_of(first_of(building_run(), 1200), {}, 1, chain);
  EXPECT_FALSE(mapping.site.used_odometry);
  EXPECT_LT(error_of(mapping.site).rms, 0.1);
}

}  // namespace
}  // namespace majak::slam
