// SPDX-License-Identifier: Apache-2.0
// The front end of graph SLAM: every scan against a local map of recent key scans. Gives a smooth
// trajectory that drifts, and the chain of key scans that the graph is made of.
#pragma once

#include <optional>

#include "majak/core/event.hpp"
#include "majak/map/surfel_map.hpp"
#include "majak/match/correlative.hpp"
#include "majak/match/point_to_line.hpp"
#include "majak/match/scan_points.hpp"
#include "majak/motion/habit.hpp"

namespace majak::slam {

struct FrontEndOptions {
  double key_distance = 0.25;       ///< m, a new key scan after this way ...
  double key_turn = 0.17;           ///< rad, ... or this turn
  int local_map_keys = 20;          ///< a local map holds this many to twice as many key scans
  double trusted_score = 0.75;      ///< share of matched points below which the window is searched
  double weak_score = 0.6;          ///< share below which the step is not to be trusted at all
  double search_translation = 0.6;  ///< m, half width of that search
  double search_rotation = 0.5;     ///< rad
  double wide_translation = 1.8;    ///< m, half width where that was not enough
  double wide_rotation = 0.9;       ///< rad
  double gap = 1.0;   ///< s, after such a time without scans all headings are searched
  int patience = 2;   ///< poor scans in a row after which a new local map is begun
  int witnesses = 3;  ///< scans in a row that must tell a motion which contradicts the wheels
  match::ScanPointsOptions points;
  match::AlignOptions align;
  map::SurfelMapOptions map;
};

struct MotionPrior {
  Pose2 T_previous_robot;
  double sigma_translation = 0.1;  ///< m
  double sigma_rotation = 0.1;     ///< rad
  bool habit = false;              ///< the last motion again: such errors have their sign in common
};

struct FrontEndStep {
  Pose2 T_map_robot;
  match::Match match;
  bool key = false;
  match::ScanPoints key_points;  ///< of a key scan, with normals
  std::size_t local_map =
      0;                  ///< of a key scan: number of the one that began its local map, or its own
  Pose2 T_key_predicted;  ///< of a key scan: motion since the one before, without the laser
  Vec3 predicted_variance = Vec3::Zero();  ///< m^2, m^2, rad^2: of that
  bool searched = false;                   ///< the prediction was no use, the window was searched
  bool held = false;    ///< what was found contradicts the wheels and has too few witnesses yet
  bool broken = false;  ///< nothing fitted: a new local map begins here
};

class FrontEnd {
 public:
  explicit FrontEnd(const FrontEndOptions& options);

  /// The next scan; `motion` since the scan before it, or constant velocity without one.
  FrontEndStep add(const Scan& scan, const std::optional<MotionPrior>& motion);

 private:
  MotionPrior habit(Time now) const;
  void predict(const MotionPrior& motion);
  match::Match track(const match::ScanPoints& points, const MotionPrior& motion);
  match::Match slide(const match::ScanPoints& points, const match::Match& tracked);
  match::Match search_window(const match::ScanPoints& points, const match::Match& tracked,
                             const MotionPrior& motion, const match::SearchWindow& window);
  match::Match recover(const match::ScanPoints& points, match::Match tracked,
                       const MotionPrior& motion, bool gap);
  void follow(const match::ScanPoints& points, const MotionPrior& prior, bool gap,
              FrontEndStep& step);
  bool doubt(const MotionPrior& motion, const match::Match& match) const;
  bool things_walk(const match::ScanPoints& rest, const MotionPrior& motion, match::Match& match);
  bool slides_off(const MotionPrior& motion, const match::Match& found) const;
  bool against_wheels(const MotionPrior& motion, const Pose2& T_map_robot, bool crowded) const;
  int told(const MotionPrior& motion, const match::Match& found);
  void begin_again();
  void insert(const match::ScanPoints& points, const Pose2& pose);

  FrontEndOptions options_;
  // Scans are matched to `active_`; `next_` takes over when it is old.
  map::SurfelMap active_, next_;
  int active_keys_ = 0, next_keys_ = 0;
  std::size_t keys_ = 0, active_first_ = 0,
              next_first_ = 0;  // key scans so far; where the maps begin
  Pose2 T_key_predicted_;       // motion since the last key scan, without the laser
  Vec3 predicted_variance_ = Vec3::Zero();
  Pose2 pose_, last_key_;
  motion::Habit habit_;
  Time last_time_ = 0;
  int poor_ = 0;  // scans in a row that did not fit
  int told_ = 0;  // scans in a row that told the rumour: a pose that contradicts the wheels
  Pose2 rumour_;
  bool slid_ = false;  // the newest match was slid along a weak direction
  bool started_ = false;
  match::BeamDirections directions_;
};

}  // namespace majak::slam
