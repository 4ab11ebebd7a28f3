// SPDX-License-Identifier: Apache-2.0
// Find and track (thesis p. 21, global methods): looks for the robot on the whole map until one
// place is left, tracks it there, and looks again when what it sees fits another place better: the
// robot was carried away, or the place was the wrong one of two that look alike.
//
//   looking: each scan after some motion gives a list of places; those that lie where the list
//   before foretold gain, the rest lose (Bayes, with the places as the only hypotheses).
#pragma once

#include <optional>
#include <vector>

#include "majak/core/options.hpp"
#include "majak/localize/global_localization.hpp"
#include "majak/localize/localizer.hpp"
#include "majak/localize/place.hpp"
#include "majak/localize/plausibility.hpp"
#include "majak/localize/scan_feed.hpp"
#include "majak/localize/tracking.hpp"

namespace majak::localize {

struct FindOptions {
  double at_once = 0.999;   ///< probability from which on one look is enough, if it fits well
  double sure = 0.99;       ///< probability from which on a place is tracked
  double step = 0.2;        ///< m driven between two looks ...
  double turn = 0.2;        ///< rad, ... or turned
  double newcomer = 1e-3;   ///< prior of a place that the looks before did not foretell
  double elsewhere = 0.05;  ///< least prior of none of the places
  double own = 0.4;         ///< share of a look's evidence that the look before had not given
  int looks = 3;            ///< in a row in which a place must be among those told
  double doubt = 0.2;       ///< drop of the fit below its mean from which on another is looked for
  double poor = 0.25;       ///< misfit from which on a place is not tracked
  int witnesses = 2;        ///< looks in a row that must favour another place
};
void describe(OptionFields& fields, FindOptions& options);

class FindAndTrack {
 public:
  FindAndTrack(PlacePtr place, const GlobalOptions& global, const TrackingOptions& tracking,
               const FindOptions& options, const PlausibilityOptions& plausibility = {});

  Estimate add(const FedScan& scan);
  bool tracking() const { return tracker_.has_value(); }
  /// The places that are in question, while it looks.
  std::vector<Hypothesis> hypotheses() const { return {hypotheses_.begin(), hypotheses_.end()}; }

 private:
  struct Followed : Hypothesis {
    int looks = 1;  ///< in a row in which it was told
    double misfit = 0;
  };
  Estimate look(const FedScan& scan);
  Estimate begin(const FedScan& scan);
  Estimate track(const FedScan& scan);
  bool carried_away(const FedScan& scan, Estimate& estimate);
  void weigh(const GlobalAnswer& answer);
  Estimate unsure(Time time) const;
  bool moved() const { return way_ >= options_.step || turned_ >= options_.turn; }

  PlacePtr place_;
  TrackingOptions tracking_;
  FindOptions options_;
  GlobalLocalization global_;
  std::optional<Tracker> tracker_;
  Plausibility plausibility_;
  std::vector<Followed> hypotheses_;  // moved along with the robot
  double elsewhere_ = 1;
  double way_ = 0, turned_ = 0;  // since the last look
  bool looked_ = false;
  bool asked_ = false;      // the whole map, in this doubt
  double usual_score_ = 0;  // running mean while tracking
  int doubted_ = 0;         // looks in a row that favoured another place
};

/// As the registry wants it.
Localizer find_and_track(const PlacePtr& place, const GlobalOptions& global,
                         const TrackingOptions& tracking, const FindOptions& options,
                         const PlausibilityOptions& plausibility);

}  // namespace majak::localize
