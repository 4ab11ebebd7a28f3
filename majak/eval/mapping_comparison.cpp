// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/mapping_comparison.hpp"

#include <algorithm>
#include <atomic>
#include <utility>

#include "majak/core/error.hpp"
#include "majak/eval/spoil.hpp"

namespace majak::eval {
namespace {

constexpr double kStray = 0.05;
constexpr int kPeople = 4;

bool asks_given(const TrialSetting& s) {
  return s.where == Surroundings::large ||
         (s.where == Surroundings::usual && s.wheels == 1 && s.seed <= 3);
}

std::array<GivenScore, 3> given_scores(const GivenMap& map, const Site& site,
                                       const Trajectory& truth,
                                       const std::function<double()>& clock) {
  std::array<GivenScore, 3> scores;
  for (const PosesFrom from : {PosesFrom::truth, PosesFrom::graph_slam, PosesFrom::wheels})
    scores[static_cast<std::size_t>(from)] = try_given(map, site, truth, from, clock);
  return scores;
}

Site graph_site(const TrialLog& log, const methods::MappingOptions& options) {
  slam::GraphSlam slam(options.graph_slam, {});
  for (const Event& event : log.events) slam.add(event);
  return slam.finish().site;
}

}  // namespace

std::vector<TrialSetting> plan_trials(const MappingPlan& plan,
                                      const std::vector<std::string>& only) {
  std::vector<TrialSetting> all;
  const auto add = [&](int seeds, TrialSetting setting) {
    for (setting.seed = 1; setting.seed <= seeds; ++setting.seed) all.push_back(setting);
  };
  add(plan.seeds, {.group = "seeds"});
  for (const double factor : {2.0, 4.0, 8.0}) add(plan.few, {.group = "wheels", .wheels = factor});
  add(plan.few, {.group = "no-wheels", .wheels = 0});
  add(plan.few, {.group = "straight", .where = Surroundings::straight});
  add(plan.rings, {.group = "ring", .where = Surroundings::ring});
  add(plan.few, {.group = "nested", .where = Surroundings::nested});
  add(plan.few, {.group = "stray", .stray = kStray});
  add(plan.few, {.group = "crowd", .people = kPeople});
  for (const double part : {0.25, 0.5, 1.0})
    add(1, {.group = "size", .where = Surroundings::large, .part = part});
  if (only.empty()) return all;
  for (const std::string& group : only)
    if (std::none_of(all.begin(), all.end(), [&](const auto& s) { return s.group == group; }))
      throw Error(
          "no trials are called " + group +
          "; there are: seeds, wheels, no-wheels, straight, ring, nested, stray, crowd, size");
  std::erase_if(all, [&](const TrialSetting& s) {
    return std::find(only.begin(), only.end(), s.group) == only.end();
  });
  return all;
}

MappingComparison compare_mappings(const MappingComparisonInput& input) {
  MappingComparison result{input.what, input.methods, input.settings, {}, {}};
  std::vector<const methods::MappingMethod*> methods;
  for (const std::string& name : input.methods) methods.push_back(&methods::mapping_method(name));
  const std::size_t n = input.settings.size();
  result.scores.assign(methods.size(), std::vector<std::optional<MappingScore>>(n));
  result.given.assign(given_maps().size(),
                      std::vector<std::optional<std::array<GivenScore, 3>>>(n));
  std::atomic<std::size_t> finished = 0;
  parallel_for(input.threads, n, [&](std::size_t i) {
    const TrialSetting& setting = input.settings[i];
    const auto log = input.log_of(setting);
    if (!log) return;
    for (std::size_t m = 0; m < methods.size(); ++m) {
      result.scores[m][i] = try_mapping(*log, *methods[m], input.options, {}, input.clock);
      if (input.progress) input.progress(++finished);
    }
    if (log->truth.empty() || input.maps.empty() || !asks_given(setting)) return;
    const Site site = graph_site(*log, input.options);
    for (std::size_t g = 0; g < given_maps().size(); ++g)
      if (std::find(input.maps.begin(), input.maps.end(), given_maps()[g].name) != input.maps.end())
        result.given[g][i] = given_scores(given_maps()[g], site, log->truth, input.clock);
  });
  return result;
}

std::function<std::optional<TrialLog>(const TrialSetting&)> variations_of(const TrialLog& log) {
  return [&log](const TrialSetting& s) -> std::optional<TrialLog> {
    const bool itself = s.where == Surroundings::usual || s.where == Surroundings::large;
    if (!itself || s.people > 0) return std::nullopt;
    TrialLog varied{first_part(log.events, s.part), log.truth, {}};
    if (s.part == 1) varied.relations = log.relations;
    const auto seed = static_cast<std::uint64_t>(s.seed);
    if (s.wheels == 0)
      varied.events = without_wheels(std::move(varied.events));
    else if (s.where == Surroundings::usual)
      varied.events = with_worn_wheels(std::move(varied.events), s.wheels, seed);
    if (s.stray > 0) varied.events = with_stray_returns(std::move(varied.events), s.stray, seed);
    return varied;
  };
}

}  // namespace majak::eval
