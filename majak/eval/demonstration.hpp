// SPDX-License-Identifier: Apache-2.0
// The demonstration of the thesis (p. 43): EKF-SLAM and the landmark graph on one log of a car with
// a laser and satellites: without the satellites, with them, and with them cut off for minutes.
// Each path is measured against what it was not fed with: the truth, where the log knows it, else
// bursts of fixes that were held out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "majak/core/event.hpp"
#include "majak/eval/held_out_fixes.hpp"
#include "majak/eval/obstacle_errors.hpp"
#include "majak/eval/path_score.hpp"
#include "majak/eval/trajectory.hpp"
#include "majak/slam/landmark_graph.hpp"

namespace majak::eval {

struct DemonstrationOptions {
  slam::EkfSlamOptions ekf;
  slam::LandmarkGraphOptions graph;
  Vec2 antenna = Vec2(3.6, 0.6);  ///< m, on the robot; of Victoria Park
  double heading = radians(36);   ///< the first, from east counter-clockwise; of Victoria Park
  double cut_off = 300;      ///< s in the middle of the log without satellites; at most a third
  std::vector<Vec2> trunks;  ///< where they truly are, in the truth's frame; if known
  std::function<double()> clock;                            ///< s of CPU; none: no times
  std::function<void(const char*, std::int64_t)> progress;  ///< run, scans so far; or none
};

/// Which fixes a run is fed with.
enum class Feed : std::uint8_t { none, fold, cut_off, all };
const char* name_of(Feed feed);

struct DemonstrationAnswer {
  slam::LandmarkMap map;
  double cpu = 0;  ///< s
  std::vector<PathScore> scores;
  ObstacleErrors obstacles;
};

/// How long a scan took EKF-SLAM, and how many landmarks there were.
struct StepTime {
  std::size_t landmarks = 0;
  double seconds = 0;
};

struct DemonstrationRun {
  Feed feed = Feed::none;
  std::vector<bool> withheld;  ///< fixes that it was not fed with
  DemonstrationAnswer ekf, graph;
  std::vector<StepTime> steps;
};

struct Demonstration {
  ReferenceFixes fixes;
  Trajectory truth;          ///< empty: nobody knows
  std::vector<Vec2> trunks;  ///< as told
  Trajectory wheels;         ///< dead reckoning, laid onto the finished path where it begins
  Pose2 T_robot_laser;
  std::vector<DemonstrationRun> runs;
  const DemonstrationRun& alone() const { return runs.front(); }    ///< without satellites
  const DemonstrationRun& with_all() const { return runs.back(); }  ///< with all that is there
};

/// Of the trunks' sightings, with all satellites: against the truth as they were placed then;
/// without it, against the map they made at last.
const std::vector<SightingError>& sightings_of(const Demonstration& demonstration);

/// Throws Error where the log has no scans, or neither fixes nor truth.
Demonstration demonstrate(const std::vector<Event>& events,
                          const DemonstrationOptions& options = {});

/// The errors of all scores of that kind, over all runs of that kind.
std::vector<PlaceError> pooled(const Demonstration& demonstration, Feed feed, Against against,
                               bool graph);

}  // namespace majak::eval
