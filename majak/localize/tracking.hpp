// SPDX-License-Identifier: Apache-2.0
// Tracking (thesis p. 21, local methods): the pose is known; each scan corrects it. Four phases:
// the robot moves, odometry predicts, the laser measures, and what it sees is compared with the map
// and corrects the prediction. Cannot find a robot that was carried away; it says that it is lost.
#pragma once

#include <array>
#include <functional>

#include "majak/core/estimate.hpp"
#include "majak/core/options.hpp"
#include "majak/localize/localizer.hpp"
#include "majak/localize/place.hpp"
#include "majak/localize/plausibility.hpp"
#include "majak/localize/scan_feed.hpp"
#include "majak/localize/tracking_errors.hpp"
#include "majak/match/correlative.hpp"
#include "majak/match/point_to_line.hpp"
#include "majak/match/range_offset.hpp"
#include "majak/match/scan_points.hpp"

namespace majak::localize {

struct TrackingOptions {
  double start_sigma = 0.3;     ///< m, how well the start is known
  double start_turn = 0.2;      ///< rad
  double return_sigma = 0.03;   ///< m, of a return against the map, for its weight; not for the
                                ///< covariance
  double trusted_score = 0.75;  ///< share of returns on the map below which a window is searched
  double lost_score = 0.45;     ///< share below which, for `patience` scans, the robot is lost
  int patience = 3;
  double search_translation = 0.6;  ///< m, half width of that window
  double search_rotation = 0.5;     ///< rad
  double offset_sigma = 0.02;       ///< m, by how much the laser may read too long; 0: not at all
  int witnesses = 20;               ///< scans in a row that must tell of a jump
  double mirror_turn = 1.0 / 75;  ///< s, of the laser's mirror, see match::beam_time; 0: the robot
                                  ///< stands still while a scan is taken
};
void describe(OptionFields& fields, TrackingOptions& options);

class Tracker {
 public:
  /// start: T_map_robot at the first scan.
  Tracker(PlacePtr place, const TrackingOptions& options, const Pose2& start);

  /// The four phases one after the other.
  Estimate add(const FedScan& scan);

  void move(const FedScan& scan);     ///< 1. how the wheels say the robot moved
  void predict();                     ///< 2. where that puts it, and how surely
  void measure(const FedScan& scan);  ///< 3. what the laser sees, as points
  Estimate correct();                 ///< 4. where on the map that fits

  const Pose2& predicted() const { return T_map_predicted_; }
  const match::Match& match() const { return match_; }
  /// m, by how much the laser reads too long against this map.
  double range_offset() const { return offset_.offset; }
  /// Of the correction against the prediction; chi-square with three degrees of freedom if honest.
  double nis() const { return nis_; }

 private:
  void search_window(const match::PosePrior& prior);
  double contradicted() const;
  void learn_offset();
  void fuse(const match::PosePrior& prior);
  bool told_before(const Pose2& T_map_robot);
  void take(const Pose2& T_map_robot, const Mat3& covariance);
  void tell(Estimate& estimate) const;

  PlacePtr place_;
  TrackingOptions options_;
  match::AlignOptions align_;
  match::BeamDirections directions_;
  Estimate estimate_;
  Mat3 covariance_;  ///< map axes at the robot, without TrackingErrors::of_ranges
  FedScan motion_;
  double period_ = 0;          ///< s between scans, running mean
  Vec3 twist_ = Vec3::Zero();  ///< m/s, rad/s, robot axes
  Pose2 T_map_predicted_;
  Mat3 predicted_covariance_ = Mat3::Zero();  ///< as the wheels claim it; weighs the correction
  Mat3 predicted_errors_ = Mat3::Zero();      ///< as they turned out to err
  match::ScanPoints points_;
  Vec2 laser_ = Vec2::Zero();  ///< m, robot frame
  TrackingErrors errors_;
  match::RangeOffset offset_;  ///< of the laser against the map, as learnt so far
  match::Match match_;
  double nis_ = 0;
  int fitting_ = 0;  ///< scans so far that did
  int poor_ = 0;     ///< scans in a row that did not fit
  Pose2 rumour_;     ///< where the last scans said that the robot was put
  int told_ = 0;     ///< scans in a row that said so
  bool jumped_ = false;
};

/// As the registry wants it. `clock`: seconds, or nothing; the phases are timed by it.
Localizer tracking(const PlacePtr& place, const TrackingOptions& options, const Pose2& start,
                   const PlausibilityOptions& plausibility = {},
                   const std::function<double()>& clock = {});

}  // namespace majak::localize
