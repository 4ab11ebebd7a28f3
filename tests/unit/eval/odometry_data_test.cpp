// SPDX-License-Identifier: Apache-2.0
// The raw odometry of three well-known logs against their relations: known figures, found by
// independent programs too.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "majak/eval/relations.hpp"
#include "majak/io/source.hpp"
#include "tests/support/data_folder.hpp"

namespace majak::eval {
namespace {

struct Known {
  const char* log;
  double mean_m, mean_degrees;
  double tolerance_m, tolerance_degrees;  // half a unit of the last digit known
  std::size_t relations;
};

class RawOdometry : public testing::TestWithParam<Known> {};

TEST_P(RawOdometry, ErrsAsPublished) {
  const Known& known = GetParam();
  const auto folder = data_folder() / "freiburg";
  const auto path = folder / (std::string(known.log) + ".clf.bz2");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "the data folder is absent (set MAJAK_DATA)";
  const auto source = io::open_log(path);
  std::vector<Event> events;
  while (auto event = source->next()) events.push_back(std::move(*event));
  Report report;
  const auto relations =
      read_relations((folder / (std::string(known.log) + ".relations")).string(), report);
  EXPECT_TRUE(report.empty());
  const auto result = evaluate_relations(odometry_of(events), relations);
  EXPECT_EQ(result.exact, known.relations);
  EXPECT_EQ(result.interpolated + result.unmatched, 0u);
  EXPECT_NEAR(result.all.translation.mean, known.mean_m, known.tolerance_m);
  EXPECT_NEAR(degrees(result.all.rotation.mean), known.mean_degrees, known.tolerance_degrees);
}

INSTANTIATE_TEST_SUITE_P(Freiburg, RawOdometry,
                         testing::Values(Known{"intel", 7.37, 39.2, 0.005, 0.05, 2984},
                                         Known{"fr079", 6.50, 30.3, 0.005, 0.05, 1685},
                                         Known{"aces", 0.55, 2.3, 0.005, 0.05, 1279}),
                         [](const auto& known) { return std::string(known.param.log); });

}  // namespace
}  // namespace majak::eval
