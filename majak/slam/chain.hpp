// SPDX-License-Identifier: Apache-2.0
// What the front end says of the key scans, as measurements for a graph. There are two kinds, and
// they are independent of each other: where a key scan stands in the local map it was matched to,
// and how the robot moved since the key scan before by wheels or by habit. A local map is the mean
// of many key scans, so the errors of neighbours in it do not add up: that is why the first kind
// hangs on the beginning of the map and not on the neighbour (docs/MATH.md, "The chain").
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "majak/graph/pose_graph.hpp"
#include "majak/slam/front_end.hpp"
#include "majak/slam/key_scan.hpp"

namespace majak::slam {

/// Of a match's information: returns of one wall share their errors.
inline constexpr double kSharedErrors = 0.25;
/// m^2, m^2, rad^2 for a key scan: the random walk of the front end's local maps.
inline const Vec3 kLocalMapDrift(5e-7, 5e-7, 3e-7);

/// Turns vectors and covariances of (x, y, theta) from the axes of a pose with that heading.
Mat3 rotation3(double theta);

/// The key scan that a step of the front end makes; `scan`: index into the run's scans, `weak`: its
/// match is not to be trusted. T_map_robot is left to the caller.
KeyScan key_scan(FrontEndStep&& step, std::size_t scan, const Pose2& T_robot_laser, bool weak);

/// All of that as a graph. Poses: the key scans, then the local maps in their order.
struct ChainGraph {
  graph::PoseGraph graph;
  std::vector<std::size_t> local_maps;  ///< key scan that began each
};
ChainGraph chain_graph(const KeyScans& keys);

/// Key scan k in its local map, measured from the key scan that began the map; nothing for that one
/// itself. Where a match before k left a direction open (an empty corridor), what was seen since
/// hangs together with that match only: in that direction k is measured from there.
std::vector<graph::Edge> match_edges(const KeyScans& keys, std::size_t k);

/// Motion between the key scans k - 1 and k, k > 0.
graph::Edge motion_edge(const KeyScans& keys, std::size_t k);

/// Information of the front end's own relative pose of two key scans, from < to, in the axes of
/// `to`.
Mat3 chain_information(const KeyScans& keys, std::size_t from, std::size_t to);

}  // namespace majak::slam
