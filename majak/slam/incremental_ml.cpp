// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/incremental_ml.hpp"

#include <utility>

#include "majak/match/scan_points.hpp"

namespace majak::slam {

IncrementalMl::IncrementalMl(const ScanChainOptions& chain, const IncrementalMlOptions& options,
                             Threads threads)
    : options_(options), threads_(threads), chain_(chain), map_(options.map) {}

std::optional<Estimate> IncrementalMl::add(Event event) {
  chain_.add(std::move(event));
  return take_scans();
}

std::optional<Estimate> IncrementalMl::take_scans() {
  std::optional<Estimate> newest;
  while (const auto step = chain_.next()) {
    if (step->key) place(chain_.keys().back());
    newest = chain_.settle();
  }
  return newest;
}

// x_t = argmax p(z_t | x, m) p(x | x_{t-1}, u_t); m <- m with z_t drawn at x_t.
void IncrementalMl::place(KeyScan& key) {
  match::PosePrior prior{key.T_map_robot, Mat3::Zero()};
  const Vec3 sigma(options_.way_sigma, options_.way_sigma, options_.turn_sigma);
  prior.information.diagonal() = sigma.cwiseAbs2().cwiseInverse();
  const match::Match match = match::align(key.points, map_, prior, options_.align);
  if (match.score >= options_.trusted_score) key.T_map_robot = match.T_map_robot;
  match::add_to(map_, key.points, key.T_map_robot);
}

Mapping IncrementalMl::finish() {
  chain_.end();
  take_scans();
  require_keys(chain_.keys());
  chain_.hang_all(threads_);
  Mapping mapping;
  mapping.site = chain_.finish();
  mapping.belief_bytes = map_.bytes();
  return mapping;
}

void describe(OptionFields& f, IncrementalMlOptions& o) {
  f.add("incremental_ml.way_sigma", o.way_sigma,
        {"m", "of the front end's step from key scan to key scan", 1e-4, 10});
  f.add("incremental_ml.turn_sigma", o.turn_sigma, {"rad", "of that step", 1e-5, 3.15});
  f.add("incremental_ml.trusted_score", o.trusted_score,
        {"1", "share of returns on the map from which on a match is believed", 0, 1});
}

}  // namespace majak::slam
