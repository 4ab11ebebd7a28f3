// SPDX-License-Identifier: Apache-2.0
// The registry of methods: one row a method, read by the command line and by everything that
// compares methods. A new method is one new file and one new row.
#pragma once

#include <functional>
#include <span>
#include <string_view>

#include "majak/core/options.hpp"
#include "majak/localize/beacons.hpp"
#include "majak/localize/dead_reckoning.hpp"
#include "majak/localize/find_and_track.hpp"
#include "majak/localize/kalman.hpp"
#include "majak/localize/localizer.hpp"
#include "majak/localize/markov.hpp"
#include "majak/localize/monte_carlo.hpp"
#include "majak/localize/place.hpp"
#include "majak/localize/tracking.hpp"
#include "majak/motion/drive_correction.hpp"
#include "majak/slam/ekf_slam.hpp"
#include "majak/slam/landmark_graph.hpp"

namespace majak::methods {

/// The options of all methods together: one struct, so that one options.toml serves them all.
struct LocalizeOptions {
  Pose2 start;  ///< T_map_robot at the first record, for methods that are told
  localize::DeadReckoningOptions dead_reckoning;
  localize::KalmanOptions kalman;
  localize::TrackingOptions tracking;
  localize::GlobalOptions global;
  localize::FindOptions find;
  localize::MonteCarloOptions monte_carlo;
  localize::MarkovOptions markov;
  slam::EkfSlamOptions ekf_slam;
  slam::LandmarkGraphOptions landmark_graph;
  localize::PlausibilityOptions plausibility;
  std::function<double()> clock;  ///< s; the parts of the work are timed by it where it is given
  beacon::ReflectorOptions reflectors;
  beacon::BeaconMap beacons;  ///< where they stand; no option, but an input like the log
  localize::PlacePtr
      place;  ///< the known map, for methods that need one; no option, but an input like the log
  motion::DriveCorrection drive;  ///< from a calibration; the log is mended with it first
};
void describe(OptionFields& fields, LocalizeOptions& options);

struct Method {
  const char* name;           ///< on the command line: "dead-reckoning"
  const char* in_the_thesis;  ///< what it is called there, and where: "dead reckoning, p. 15"
  const char* needs;          ///< for people: "odometry, or wheel speed and steering"
  const char* yields;         ///< for people: "trajectory with covariance"
  localize::Localizer (*make)(const LocalizeOptions& options);
  bool on_map = false;  ///< works on a known map
  bool told = true;     ///< begins where `start` says
};

std::span<const Method> methods();

/// Throws Error that lists the names there are.
const Method& method(std::string_view name);

}  // namespace majak::methods
