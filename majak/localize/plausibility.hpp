// SPDX-License-Identifier: Apache-2.0
// Plausibility: does what the laser sees, look after look, belong to the place where a method
// believes the robot? A corridor of another building looks like ours for metres, and a filter that
// knows nothing but this map finds its likeliest place there. So a place just found is on
// probation, and one that fits badly in the mean of the last looks is given up.
#pragma once

#include "majak/core/estimate.hpp"
#include "majak/core/options.hpp"
#include "majak/localize/place.hpp"
#include "majak/localize/pose_fit.hpp"
#include "majak/localize/scan_feed.hpp"

namespace majak::localize {

struct PlausibilityOptions {
  double step = 0.2;   ///< m driven between two looks ...
  double turn = 0.2;   ///< rad, ... or turned
  int probation = 12;  ///< looks at least before a place just found is called ok ...
  double good = 0.12;  ///< ... and the mean misfit that they must come to
  int least = 3;       ///< looks before a place is given up
  double poor = 0.2;   ///< mean misfit from which on the health is degraded ...
  double lost = 0.32;  ///< ... and from which on the place is given up
};
void describe(OptionFields& fields, PlausibilityOptions& options);

class Plausibility {
 public:
  explicit Plausibility(PlacePtr place, const PlausibilityOptions& options = {})
      : place_(std::move(place)), options_(options) {}

  /// Another place is tried.
  void begin_anew() { *this = Plausibility(place_, options_); }
  /// Each scan, and where the method believes the robot; farther off than the wheels can err it is
  /// another place.
  void add(const FedScan& scan, const Pose2& T_map_robot);

  /// The best that may be said of the place.
  Health at_best() const;
  /// Lowers what the method says of itself.
  void limit(Estimate& estimate) const;
  /// Mean over the last looks, see PoseFit.
  double misfit() const { return misfit_; }

 private:
  PlacePtr place_;
  PlausibilityOptions options_;
  Pose2 T_map_robot_;
  double way_ = 0, turned_ = 0;  // since the last look
  double misfit_ = 0;
  int looks_ = 0;
  bool accepted_ = false;  // the probation is over
};

}  // namespace majak::localize
