// SPDX-License-Identifier: Apache-2.0
// WheelNumbers: what the wheels of a whole drive count wrongly, learnt together with all poses of
// the graph that they are a part of: numbers that stay, and by how much the robot drives to the
// side of where it looks, which comes and goes with the ground: on a slope a car crabs (MATH
// "Graph").
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "majak/graph/marginals.hpp"
#include "majak/graph/pose_graph.hpp"
#include "majak/slam/motion_input.hpp"

namespace majak::slam {

struct GroundOptions {
  double crab = 0.006;   ///< rad, one sigma, of the direction in which it drives; 0: stays
  double memory = 40;    ///< m driven, after which it has changed
  double knot_way = 40;  ///< m driven between two values of it, of 200 at most; linear between
};

class WheelNumbers {
 public:
  using Numbers = Eigen::Matrix<double, MotionInput::kNumbers, 1>;

  /// steps[k]: by the wheels from pose k - 1 to pose k; they must outlive this. `begin`: the
  /// numbers as they are guessed, `sigma`: how far off wheels that count right they may be.
  WheelNumbers(const std::vector<MotionInput::Motion>& steps, const Numbers& begin,
               const Numbers& sigma, const GroundOptions& ground);

  /// From pose k - 1 to pose k, as learnt so far; k > 0.
  Pose2 step(std::size_t k) const;

  /// One step of least squares in which all poses follow the numbers. edges[k - 1] of the graph
  /// joins the poses k - 1 and k, as step(k) told it; the poses are at their optimum. `marginals`:
  /// of that graph.
  void learn(graph::PoseGraph& graph, const graph::Marginals& marginals);

  Numbers numbers() const { return values_.head<MotionInput::kNumbers>(); }
  Numbers sigmas() const { return sigmas_; }  ///< one sigma of them, as of the last learn()
  double crab(std::size_t k) const;           ///< rad, at pose k, all in all

 private:
  /// Steps [first, last) that a value has a say in.
  struct Reach {
    std::size_t first, last;
  };
  Reach reach(Eigen::Index value) const;
  Vec3 by(std::size_t k, Eigen::Index value) const;
  std::vector<Vec3> response(const graph::PoseGraph& graph, const graph::Marginals& marginals,
                             Eigen::Index value) const;

  const std::vector<MotionInput::Motion>& steps_;
  double knot_way_;
  std::vector<double> way_;  ///< m driven at each pose
  Eigen::VectorXd values_;   ///< numbers, then the crab's knots
  Eigen::VectorXd nominal_;  ///< of wheels that count right
  Eigen::MatrixXd prior_;    ///< information
  Numbers sigmas_;
};

}  // namespace majak::slam
