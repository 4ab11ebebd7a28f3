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
#include "majak/localize/pose_fit.hpp"
#include "majak/match/global_search.hpp"

namespace majak::localize {

struct GlobalOptions {
  match::GlobalSearchOptions search;
  double effective = 15;  ///< beams that err by themselves; neighbours err together
  PoseFitOptions fit;
  double elsewhere = 0.3;  ///< mean likelihood of a place that the map does not show
};

void describe(OptionFields& fields, GlobalOptions& options);

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

 private:
  PlacePtr place_;
  GlobalOptions options_;
  match::GlobalSearch search_;
};

}  // namespace majak::localize
