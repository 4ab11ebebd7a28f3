// SPDX-License-Identifier: Apache-2.0
// Global localization (thesis p. 21): where on the map could this scan have been taken? The places
// that global search finds are fitted to the surfaces, then weighed by all beams, those too that
// would have to pass through walls. The answer is a list with probabilities, and says so where
// places look alike.
#pragma once

#include <vector>

#include "majak/core/options.hpp"
#include "majak/localize/place.hpp"
#include "majak/match/global_search.hpp"

namespace majak::localize {

struct GlobalOptions {
  match::GlobalSearchOptions search;
  double effective = 15;    ///< beams that err by themselves; neighbours err together
  double through_wall = 2;  ///< nat, against a beam that would have passed through a wall
  double wall = 0.4;        ///< m, by which it must be beyond
  double elsewhere = 0.5;   ///< mean likelihood of a place that the map does not show
};

struct Hypothesis {
  Pose2 T_map_robot;
  Mat3 covariance = Mat3::Zero();  ///< map axes, of the fit
  double probability = 0;
  double score = 0;    ///< share of returns that lie on the map
  double through = 0;  ///< share of beams that would have passed through walls
};

struct GlobalAnswer {
  std::vector<Hypothesis> hypotheses;  ///< the likeliest first
  double elsewhere = 1;                ///< probability that it is none of them
  bool complete = true;                ///< false: the search ended early
};

class GlobalLocalization {
 public:
  explicit GlobalLocalization(PlacePtr place, const GlobalOptions& options = {});
  GlobalAnswer find(const Scan& scan) const;

 private:
  PlacePtr place_;
  GlobalOptions options_;
  match::GlobalSearch search_;
};

}  // namespace majak::localize
