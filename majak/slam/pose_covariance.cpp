// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/pose_covariance.hpp"

#include <Eigen/LU>
#include <cmath>

#include "majak/graph/marginals.hpp"

namespace majak::slam {
namespace {

Mat3 rotation3(double theta) {
  const double c = std::cos(theta), s = std::sin(theta);
  Mat3 r;
  r << c, -s, 0, s, c, 0, 0, 0, 1;
  return r;
}

}  // namespace

// Information of the step to a key scan from its match: the matcher's own, which knows the weak
// directions, widened by what returns of one wall have in common.
Mat3 step_information(const FrontEndStep& step, bool weak) {
  const Mat3 r = rotation3(step.T_map_robot.theta);
  const Mat3 information = r.transpose() * (0.25 * step.match.information + step.prior_information) * r;
  Mat3 covariance = (information + 1e-3 * Mat3::Identity()).inverse();
  covariance.diagonal() += Vec3(4e-6, 4e-6, 1e-6);
  if (weak) covariance.diagonal() += Vec3(0.04, 0.04, 0.04);
  return covariance.inverse();
}

std::vector<Mat3> key_covariances(const KeyScans& keys, const JointRefinement& refined) {
  graph::PoseGraph graph;
  for (const KeyScan& key : keys) graph.poses.push_back(key.T_map_robot);
  graph.edges = refined.edges;
  std::vector<Mat3> covariances(keys.size(), Mat3::Zero());
  if (keys.size() < 2) return covariances;
  const graph::Marginals marginals(graph);
  for (std::size_t k = 0; k < keys.size(); ++k) covariances[k] = marginals.covariance(static_cast<int>(k));
  return covariances;
}

Mat3 scan_covariance(const Mat3& key_covariance, const match::Match& match, const match::PosePrior& prior) {
  return key_covariance + (match.information + prior.information).inverse();
}

}  // namespace majak::slam
