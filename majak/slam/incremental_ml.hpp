// SPDX-License-Identifier: Apache-2.0
// Incremental maximum likelihood (thesis p. 36; Thrun 2002, section 5): each scan at its most
// likely place on the map so far, and into the map with it. No doubt is kept, nothing is ever moved
// again: where a ring closes, what has gone wrong on the way stays.
#pragma once

#include <optional>

#include "majak/core/event.hpp"
#include "majak/map/surfel_map.hpp"
#include "majak/match/point_to_line.hpp"
#include "majak/slam/mapper.hpp"
#include "majak/slam/scan_chain.hpp"

namespace majak::slam {

struct IncrementalMlOptions {
  double way_sigma = 0.02;     ///< m, of the front end's step from key scan to key scan
  double turn_sigma = 0.01;    ///< rad
  double trusted_score = 0.6;  ///< share of returns on the map from which on the match is believed
  match::AlignOptions align;
  map::SurfelMapOptions map;
};

void describe(OptionFields& fields, IncrementalMlOptions& options);

class IncrementalMl {
 public:
  IncrementalMl(const ScanChainOptions& chain, const IncrementalMlOptions& options,
                Threads threads);

  std::optional<Estimate> add(Event event);
  Mapping finish();

  /// What is known so far.
  const ScanChain& chain() const { return chain_; }

 private:
  std::optional<Estimate> take_scans();
  void place(KeyScan& key);

  IncrementalMlOptions options_;
  Threads threads_;
  ScanChain chain_;
  map::SurfelMap map_;
};

}  // namespace majak::slam
