// SPDX-License-Identifier: Apache-2.0
#include "majak/io/site_graph.hpp"

#include <vector>

namespace majak::io {

graph::PoseGraph graph_of(const Site& site) {
  graph::PoseGraph graph;
  std::vector<int> node(site.scans.size(), -1);
  for (std::size_t i = 0; i < site.scans.size(); ++i) {
    if (!site.scans[i].key) continue;
    node[i] = static_cast<int>(graph.poses.size());
    graph.poses.push_back(site.scans[i].estimate.T_map_robot);
  }
  for (const Constraint& c : site.constraints) {
    if (!c.enabled || node[c.from] < 0 || node[c.to] < 0) continue;
    graph.edges.push_back(
        {node[c.from], node[c.to], c.T_from_to, c.information, c.kind == ConstraintKind::closure});
  }
  return graph;
}

}  // namespace majak::io
