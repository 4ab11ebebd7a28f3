// SPDX-License-Identifier: Apache-2.0
// Poses from the edges alone, wherever the poses stood before.
#pragma once

#include <span>
#include <vector>

#include "majak/graph/normal_equations.hpp"
#include "majak/graph/pose_graph.hpp"

namespace majak::graph {

/// Chordal relaxation of the headings, then one linear solve for positions and headings together
/// (Carlone et al. 2015; MATH 2.6, 2.7). The spanning tree's poses where the equations are
/// singular. Anchors keep the pose that the graph gives them. Throws Error where check() does.
std::vector<Pose2> initialize(const PoseGraph& graph);

/// The same on equations that are set already; `weights` (of the edges) may be empty.
std::vector<Pose2> initialize(const PoseGraph& graph, NormalEquations& equations,
                              std::span<const double> weights = {});

/// Poses by walking from the anchors breadth first, edges that are not robust before those that
/// are.
std::vector<Pose2> spanning_tree(const PoseGraph& graph);

}  // namespace majak::graph
