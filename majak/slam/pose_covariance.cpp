// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/pose_covariance.hpp"

#include <Eigen/LU>
#include "majak/graph/marginals.hpp"

namespace majak::slam {
std::vector<Mat3> key_covariances(const KeyScans& keys, const JointRefinement& refined) {
  graph::PoseGraph graph;
  for (const KeyScan& key : keys) graph.poses.push_back(key.T_map_robot);
  graph.edges = refined.edges;
  std::vector<Mat3> covariances(keys.size(), Mat3::Zero());
  if (keys.size() < 2) return covariances;
  const graph::Marginals marginals(graph);
  for (std::size_t k = 0; k < keys.size(); ++k)
    covariances[k] = marginals.covariance(static_cast<int>(k));
  return covariances;
}

Mat3 scan_covariance(const Mat3& key_covariance, const match::Match& match,
                     const match::PosePrior& prior) {
  return key_covariance + (match.information + prior.information).inverse();
}

}  // namespace majak::slam
