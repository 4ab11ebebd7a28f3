// SPDX-License-Identifier: Apache-2.0
// Rao-Blackwellised particle filter (Murphy 1999; Grisetti, Stachniss, Burgard 2007, "Improved
// techniques for grid mapping", known as GMapping): each particle is one way the robot may have
// gone and the map that follows from it. Proposals look at the scan before they move, resampling
// waits until it must. Where a ring closes, the particles whose maps meet themselves survive.
// docs/MATH.md, "Particles that carry maps".
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "majak/core/event.hpp"
#include "majak/map/surfel_map.hpp"
#include "majak/match/point_to_line.hpp"
#include "majak/slam/mapper.hpp"
#include "majak/slam/scan_chain.hpp"

namespace majak::slam {

struct RaoBlackwellizedOptions {
  int particles = 30;
  int seed = 1;
  double resample_below = 0.5;  ///< share of the particles that the effective size must fall under
  double shared = 0.25;  ///< of a match's information: returns of one wall share their errors
  double likelihood_share = 0.05;  ///< the same of the returns' log-likelihood, in the weights
  double trusted_score = 0.6;   ///< share of returns on the map from which on a match is believed
  double drift_way = 0.7e-3;    ///< m for a key scan: a map's own random walk, beside the match
  double drift_turn = 0.55e-3;  ///< rad
  match::AlignOptions align;
  map::SurfelMapOptions map;
};

void describe(OptionFields& fields, RaoBlackwellizedOptions& options);

class RaoBlackwellized {
 public:
  RaoBlackwellized(const ScanChainOptions& chain, const RaoBlackwellizedOptions& options,
                   Threads threads);

  std::optional<Estimate> add(Event event);
  Mapping finish();

 private:
  struct Particle {
    Pose2 T_map_robot;
    map::SharedSurfelMap map;
    double log_weight = 0;        // since it was resampled
    double log_weight_total = 0;  // since the beginning
  };
  // One step of the tree of ancestors: each particle's pose, and whose child it is.
  struct Step {
    std::vector<Pose2> poses;
    std::vector<std::uint32_t> parents;
  };

  std::optional<Estimate> take_scans();
  void update(KeyScan& key);
  void move(const KeyScan& key, const Pose2& T_previous_robot, std::size_t i);
  void resample();
  std::size_t best() const;
  void place_keys();

  RaoBlackwellizedOptions options_;
  Threads threads_;
  ScanChain chain_;
  std::vector<Particle> particles_;
  std::vector<Step> steps_;             // one a key scan
  std::vector<std::uint32_t> parents_;  // of the step to come
  double belief_bytes_ = 0;             // at most so far
  std::size_t resamplings_ = 0;
};

}  // namespace majak::slam
