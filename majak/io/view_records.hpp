// SPDX-License-Identifier: Apache-2.0
// What a viewer is told, as the records of an MCAP stream: those of a recording for what sensors
// said, and messages of our own for what was made of it. docs/FORMATS.md lists topics and fields.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "majak/core/estimate.hpp"
#include "majak/core/event.hpp"
#include "majak/core/site.hpp"
#include "majak/map/occupancy_grid.hpp"

namespace majak::io {

enum class ViewTopic : std::uint16_t {  // numbers of the stream's channels
  scan = 1,
  estimate,
  key_poses,
  map,
  graph,
  truth,
  segments,
  particles,
  hypotheses,
  landmarks,
  run,
  closures,
  edits,
  status,
};

/// Magic, header, schemas and channels: what every stream begins with.
std::string view_head();

/// A JSON text as a record of its topic.
std::string view_json(ViewTopic topic, std::string_view text);

/// `laser`: its frame is "laser0", "laser1", ..., whose mountings /run tells. A stamp that ROS
/// cannot write is written as the nearest that it can.
std::string view_scan(std::size_t number, const Scan& scan, std::size_t laser);

/// A scan's pose and what is known of it. Poses that do not exist are not-a-numbers on the wire.
struct ViewedPose {
  std::size_t scan = 0;
  std::size_t key = 0;  ///< the key scan that it hangs on
  bool is_key = false;
  Estimate estimate;
  float match_score = 0;
  float milliseconds = 0;                ///< that the program took for it; 0: not known
  std::uint32_t particles = 0;           ///< of the method, where it has any
  std::optional<Pose2> T_map_odometry;   ///< where odometry alone would have it
  std::optional<Pose2> T_map_front_end;  ///< before loop closing
};
std::string view_estimate(const ViewedPose& pose);

/// Key scans as they stand now.
std::string view_key_poses(std::span<const std::size_t> scans, std::span<const Pose2> poses);

/// Probabilities in percent, -1 where nothing is known.
std::string view_map(const map::OccupancyGrid& grid);

/// All constraints, switched off ones too.
std::string view_graph(const Site& site);

struct StampedPoses {
  std::vector<Time> stamps;
  std::vector<Pose2> poses;
};
std::string view_truth(const StampedPoses& path);

/// x1 y1 x2 y2 of each, m.
std::string view_segments(const std::vector<float>& ends);

/// `weights` may be empty: all alike.
std::string view_particles(Time time, std::span<const Pose2> particles,
                           std::span<const float> weights);

}  // namespace majak::io
