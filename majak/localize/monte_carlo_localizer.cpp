// SPDX-License-Identifier: Apache-2.0
// Monte Carlo localization as the registry wants it, and its options by name.
#include <memory>
#include <optional>
#include <utility>

#include "majak/localize/monte_carlo.hpp"
#include "majak/localize/on_scans.hpp"

namespace majak::localize {

Localizer monte_carlo(const PlacePtr& place, const MonteCarloOptions& options, const Pose2& start,
                      const PlausibilityOptions& plausibility, Threads threads) {
  return on_scans([=, filter = MonteCarlo(place, options, start, threads),
                   watch = Plausibility(place, plausibility)](
                      const FedScan& scan, Localization& result) mutable -> Step {
    Estimate estimate = filter.add(scan);
    const bool trusted = !scan.by_wheels && estimate.health == Health::ok;
    watch.add(scan, estimate.T_map_robot);
    watch.limit(estimate);
    if (watch.at_best() == Health::lost) {  // not here: anywhere
      MonteCarloOptions anew = options;
      anew.start_sigma = 0;
      filter = MonteCarlo(place, anew, {}, threads);
      watch.begin_anew();
      return {estimate, false};
    }
    if (filter.updated()) result.hypotheses.push_back({estimate.time, filter.clusters()});
    result.belief_bytes.push_back(filter.bytes());
    result.updates = filter.updates();
    // Its steps are no measure of the wheels: neighbouring estimates err apart.
    return {estimate, trusted};
  });
}

void describe(OptionFields& f, MonteCarloOptions& o) {
  f.add("monte_carlo.seed", o.seed, {"1", "of the random numbers", 0, 2e9});
  f.add("monte_carlo.particles", o.particles, {"1", "at most", 10, 1e7});
  f.add("monte_carlo.least", o.least, {"1", "particles at least", 10, 1e7});
  f.add("monte_carlo.beams", o.beams, {"1", "of a scan that are looked at", 10, 10000});
  f.add("monte_carlo.beam_model", o.beam_model,
        {"", "weigh by the beam model, not by the likelihood field; a hundred times as dear"});
  f.add("monte_carlo.hit", o.model.hit, {"1", "beam model: share of walls", 0, 1});
  f.add("monte_carlo.brief", o.model.brief, {"1", "share of what stands in the way", 0, 1});
  f.add("monte_carlo.none", o.model.none, {"1", "share without return", 0, 1});
  f.add("monte_carlo.random", o.model.random, {"1", "share of anything at all", 0, 1});
  f.add("monte_carlo.sigma", o.model.sigma, {"m", "of a wall's range", 0.001, 10});
  f.add("monte_carlo.rate", o.model.rate, {"1/m", "of what stands in the way", 0.001, 100});
  f.add("monte_carlo.effective", o.effective,
        {"1", "as how many independent beams they count", 1, 1000});
  f.add("monte_carlo.step", o.step, {"m", "driven between two updates", 0, 10});
  f.add("monte_carlo.step_turn", o.step_turn, {"rad", "turned between two updates", 0, 3});
  f.add("monte_carlo.start_sigma", o.start_sigma,
        {"m", "how well the start is known; 0: not at all", 0, 100});
  f.add("monte_carlo.start_turn", o.start_turn, {"rad", "the same of the heading", 0.001, 4});
  f.add("monte_carlo.spread", o.spread, {"m", "added to each motion so that copies part", 1e-4, 1});
  f.add("monte_carlo.spread_turn", o.spread_turn, {"rad", "the same", 1e-4, 1});
  f.add("monte_carlo.kld_error", o.kld_error,
        {"nat", "between the particles and the belief they stand for", 1e-3, 10});
  f.add("monte_carlo.kld_quantile", o.kld_quantile, {"1", "of how surely; normal", 0, 6});
  f.add("monte_carlo.alpha_slow", o.alpha_slow,
        {"1", "of the mean misfit of many updates", 1e-4, 1});
  f.add("monte_carlo.alpha_fast", o.alpha_fast, {"1", "of that of the last few", 1e-4, 1});
  f.add("monte_carlo.doubt", o.doubt,
        {"nat", "a beam, fast by slow mean, from which on new particles join", 0, 10});
  f.add("monte_carlo.lost", o.lost,
        {"nat", "a beam, the same, from which on the robot is lost", 0, 10});
  f.add("monte_carlo.proposals", o.proposals,
        {"", "places that fit the scan are among the new particles"});
  f.add("monte_carlo.carried", o.carried,
        {"nat", "an update, against having been carried away", 0, 100});
  f.add("monte_carlo.slip", o.slip, {"m", "how far the wheels may slip in doubt", 0.01, 10});
  f.add("monte_carlo.slip_turn", o.slip_turn, {"rad", "the same", 0.01, 3});
  f.add("monte_carlo.sure", o.sure, {"1", "weight of a cluster that is the place", 0.5, 1});
  f.add("monte_carlo.off_floor", o.off_floor,
        {"nat", "an update, against standing where no floor is known", 0, 100});
}

}  // namespace majak::localize
