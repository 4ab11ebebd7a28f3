// SPDX-License-Identifier: Apache-2.0
// Markov localization (thesis p. 24; Fox, Burgard, Thrun 1999): the belief is a histogram over all
// poses on the map, so that any number of places may be thought likely at once, and a robot that
// was carried away is found again. Nobody tells it where it starts.
//
// Selective update: once most of the belief stands in a few tiles, only these are moved and
// weighed. The others rest: they keep their belief, remember how the robot has moved since, and are
// scaled by one likelihood together. Where the tiles awake explain the scans worse than that, the
// resting ones gain, and all are woken; unless the last look at all of the map found nothing
// better.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "majak/core/estimate.hpp"
#include "majak/core/options.hpp"
#include "majak/filter/pose_histogram.hpp"
#include "majak/localize/belief_weighing.hpp"
#include "majak/localize/localizer.hpp"
#include "majak/localize/place.hpp"
#include "majak/localize/plausibility.hpp"
#include "majak/localize/scan_feed.hpp"

namespace majak::localize {

struct MarkovOptions {
  double cell = 0.10;                  ///< m
  double turn = 2 * kPi / 180;         ///< rad, of a cell; made to divide a whole turn
  double motion_step = 0.10;           ///< m, moved before it is worth an update
  double motion_turn = 2 * kPi / 180;  ///< rad
  int beams = 90;                      ///< of a scan
  double effective = 15;               ///< of these, that err by themselves
  double share = 1e-4;                 ///< cells below this times the largest are not looked at
  double elsewhere = 0.35;  ///< mean likelihood of a beam, taken for what is not looked at
  double carried = 1e-4;    ///< probability a step that the robot was carried away
  double wake = 0.3;        ///< probability of what rests from which on all are woken
  double sure = 0.9;        ///< probability about the likeliest pose from which on it is sure
};
void describe(OptionFields& fields, MarkovOptions& options);

class Markov {
 public:
  Markov(PlacePtr place, const MarkovOptions& options, Threads threads = {});

  Estimate add(const FedScan& scan);

  /// What is awake; it sums to 1 - resting().
  const filter::PoseHistogram& belief() const { return belief_; }
  double resting() const;
  std::size_t bytes() const;  ///< of all beliefs
  int updates() const { return updates_; }
  const Weighed& weighed() const { return weighed_; }  ///< at the last update

 private:
  /// Tiles laid to rest together.
  struct Rest {
    filter::PoseHistogram belief;
    filter::PoseMotion since;
    double mass;
  };
  bool worth_an_update(const FedScan& scan) const;
  void move();
  void see(const Scan& scan);
  void lay_to_rest();
  void wake();
  Estimate about_the_mode() const;

  PlacePtr place_;
  MarkovOptions options_;
  Threads threads_;
  std::shared_ptr<const filter::PoseLattice> lattice_;
  BeliefWeighing weighing_;
  filter::PoseHistogram belief_;
  std::vector<Rest> resting_;
  double anywhere_ = 0;  // probability of a robot that was carried to no one knows where
  double elsewhere_;     // nat, mean cost of a beam where nobody looks
  bool all_ = true;      // the next scan is held against all cells
  filter::PoseMotion pending_;
  Estimate estimate_;  // at the last update
  Weighed weighed_;
  int updates_ = 0;
};

/// As the registry wants it. `clock`: seconds, or nothing.
Localizer markov(const PlacePtr& place, const MarkovOptions& options,
                 const PlausibilityOptions& plausibility = {},
                 const std::function<double()>& clock = {});

}  // namespace majak::localize
