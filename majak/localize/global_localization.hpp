// SPDX-License-Identifier: Apache-2.0
// Global localization (thesis p. 21): where on the map could this scan have been taken? The places
// that global search finds are fitted to the surfaces, then weighed by all beams, those too that
// would have to pass through walls. The answer is a list with probabilities, and says so where
// places look alike.
#pragma once

#include <vector>

#include "majak/core/options.hpp"
#include "majak/localize/localizer.hpp"
#include "majak/localize/place.hpp"
#include "majak/match/global_search.hpp"

namespace majak::localize {

struct GlobalOptions {
  match::GlobalSearchOptions search;
  double effective = 15;    ///< beams that err by themselves; neighbours err together
  double through_wall = 2;  ///< nat, against a beam that would have passed through a wall
  double wall = 0.4;        ///< m, by which it must be beyond
  double elsewhere = 0.3;   ///< mean likelihood of a place that the map does not show
};

/// How well a scan fits a pose.
struct PoseFit {
  double cost = 0;     ///< nat, of a beam in the mean; 0 is perfect
  double through = 0;  ///< share of beams that would have passed through walls
};

/// 0: all is as the map says; people before the laser cost half of what walls do that are not
/// there.
inline double misfit(double score, double through) { return 0.5 * (1 - score) + through; }

struct FoundPlace : Hypothesis {
  double score = 0;  ///< share of returns that lie on the map
  PoseFit fit;
};

struct GlobalAnswer {
  std::vector<FoundPlace> places;  ///< the likeliest first
  double elsewhere = 1;            ///< probability that it is none of them
  bool complete = true;            ///< false: the search ended early
};

class GlobalLocalization {
 public:
  explicit GlobalLocalization(PlacePtr place, const GlobalOptions& options = {});
  GlobalAnswer find(const Scan& scan) const;
  /// Of any pose, in the same coin.
  PoseFit weigh(const match::Beams& beams, const Pose2& T_map_robot) const;

 private:
  PlacePtr place_;
  GlobalOptions options_;
  match::GlobalSearch search_;
};

}  // namespace majak::localize
