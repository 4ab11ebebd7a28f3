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
#include "majak/core/random.hpp"
#include "majak/map/surfel_map.hpp"
#include "majak/match/point_to_line.hpp"
#include "majak/slam/mapper.hpp"
#include "majak/slam/scan_chain.hpp"

namespace majak::slam {

struct RaoBlackwellizedOptions {
  int particles = 60;
  int seed = 1;
  double resample_below = 0.5;  ///< share of the particles that the effective size must fall under
  double bend = 0.5e-3;         ///< rad/m: the front end turns the way by so much, one sigma ...
  double bend_way = 30;         ///< m, ... and goes on doing so for about this way
  double known = 0.5;           ///< share of returns on what was mapped before the local map from
                                ///< which on the place is known, and matched
  double shared = 0.25;  ///< of a match's information: returns of one wall share their errors
  double likelihood_share = 0.15;  ///< the same of the returns' log-likelihood, in the weights
  match::AlignOptions align{.tolerance = 1e-3};
  map::SurfelMapOptions map{.cell = 0.10, .reach = 0.30, .merge_radius = 0.08};
};

void describe(OptionFields& fields, RaoBlackwellizedOptions& options);

class RaoBlackwellized {
 public:
  RaoBlackwellized(const ScanChainOptions& chain, const RaoBlackwellizedOptions& options,
                   Threads threads);

  std::optional<Estimate> add(Event event);
  Mapping finish();

  /// Of the particles, since they were last drawn; their sum is 1.
  std::vector<double> weights() const;
  std::size_t resamplings() const { return resamplings_; }

  /// What is known so far.
  const ScanChain& chain() const { return chain_; }

 private:
  struct Particle {
    Pose2 T_map_robot;
    map::SharedSurfelMap map;
    double bend = 0;                // rad/m, by which the front end turns its way
    std::uint32_t old_surfels = 0;  // of the map: those from before the front end's local map
    double log_weight = 0;          // since it was drawn
    double log_weight_total = 0;    // since the beginning
  };
  // One step of the tree of ancestors.
  struct Step {
    std::vector<std::uint32_t> parents;  // whose child each particle is
    std::vector<std::uint32_t> surfels;  // in its map before the key scan was drawn
    std::vector<Pose2> poses;
  };

  std::optional<Estimate> take_scans();
  void update(KeyScan& key);
  match::ScanPoints unexplained(const KeyScan& key);
  Mat3 kernel() const;
  void move(std::size_t i, const Mat3& kernel, const match::ScanPoints& unexplained);
  void localize(Particle& particle, const match::ScanPoints& points, const match::PosePrior& prior,
                RandomStream& random) const;
  std::uint32_t surfels_before(std::size_t key, std::size_t i) const;
  void resample();
  void count_bytes();
  std::size_t best() const;
  void place_keys();

  RaoBlackwellizedOptions options_;
  Threads threads_;
  ScanChain chain_;
  std::vector<Particle> particles_;
  std::vector<Step> steps_;             // one a key scan
  std::vector<std::uint32_t> parents_;  // of the step to come
  map::SurfelMap local_;                // the front end's local map, in its frame
  std::size_t local_first_ = 0;         // key scan that began it
  double belief_bytes_ = 0;             // at most so far
  std::size_t resamplings_ = 0;
};

}  // namespace majak::slam
