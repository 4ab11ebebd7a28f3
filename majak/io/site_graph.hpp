// SPDX-License-Identifier: Apache-2.0
// A Site's key scans and constraints as a pose graph, for graph.g2o.
#pragma once

#include "majak/core/site.hpp"
#include "majak/graph/pose_graph.hpp"

namespace majak::io {

/// Key scans in log order as poses, enabled constraints as edges; closures are marked robust.
graph::PoseGraph graph_of(const Site& site);

}  // namespace majak::io
