// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/wheel_numbers.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace majak::slam {
namespace {

constexpr Eigen::Index kNumbers = MotionInput::kNumbers;
constexpr double kMostKnots = 200;  // each costs a solve of the whole graph

// Information of what forgets itself exponentially, at `n` places each of which keeps so much of
// the one before.
Eigen::MatrixXd forgetful(Eigen::Index n, double sigma, double keep) {
  const double fresh = 1 / (sigma * sigma * (1 - keep * keep));
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    information(i, i) = fresh * (i == 0 || i == n - 1 ? 1 : 1 + keep * keep);
    if (i > 0) information(i, i - 1) = information(i - 1, i) = -keep * fresh;
  }
  return information;
}

}  // namespace

WheelNumbers::WheelNumbers(const std::vector<MotionInput::Motion>& steps, const Numbers& begin,
                           const Numbers& sigma, const GroundOptions& ground)
    : steps_(steps), sigmas_(sigma) {
  double way = 0;
  for (const MotionInput::Motion& step : steps)
    way_.push_back(way += step.T_from_to.translation().norm());
  knot_way_ = std::max(ground.knot_way, way / kMostKnots);
  const Eigen::Index knots =
      ground.crab > 0 ? static_cast<Eigen::Index>(way / knot_way_) + 2 : Eigen::Index{0};
  nominal_ = Eigen::VectorXd::Zero(kNumbers + knots);
  nominal_.head<kNumbers>() = MotionInput::counted_right().at.head<kNumbers>();
  values_ = nominal_;
  values_.head<kNumbers>() = begin;
  prior_ = Eigen::MatrixXd::Zero(kNumbers + knots, kNumbers + knots);
  prior_.diagonal().head<kNumbers>() = sigma.cwiseAbs2().cwiseInverse();
  if (knots > 0)
    prior_.bottomRightCorner(knots, knots) =
        forgetful(knots, ground.crab, std::exp(-knot_way_ / ground.memory));
}

double WheelNumbers::crab(std::size_t k) const {
  double crab = values_(MotionInput::kCrab);
  if (values_.size() == kNumbers) return crab;
  const double at = way_[k] / knot_way_, knot = std::floor(at);
  const Eigen::Index i = kNumbers + static_cast<Eigen::Index>(knot);
  return crab + (1 - at + knot) * values_(i) + (at - knot) * values_(i + 1);
}

Pose2 WheelNumbers::step(std::size_t k) const {
  filter::LandmarkFilter::Extra extra = steps_[k].at;
  extra.head<kNumbers>() = numbers();
  extra(MotionInput::kCrab) = crab(k);
  return steps_[k].apply({{}, extra}).T_map_robot;
}

WheelNumbers::Reach WheelNumbers::reach(Eigen::Index value) const {
  const std::size_t last = steps_.size();
  if (value < kNumbers) return {std::min<std::size_t>(1, last), last};
  const double knot = static_cast<double>(value - kNumbers) * knot_way_;
  const auto at = [&](double way) {
    const auto step = std::lower_bound(way_.begin(), way_.end(), way) - way_.begin();
    return std::max<std::size_t>(1, static_cast<std::size_t>(step));
  };
  return {at(knot - knot_way_), at(knot + knot_way_)};
}

Vec3 WheelNumbers::by(std::size_t k, Eigen::Index value) const {
  if (value < kNumbers) return steps_[k].by_extra.col(value);
  const double off = way_[k] / knot_way_ - static_cast<double>(value - kNumbers);
  return std::max(0.0, 1 - std::abs(off)) * steps_[k].by_extra.col(MotionInput::kCrab);
}

std::vector<Vec3> WheelNumbers::response(const graph::PoseGraph& graph,
                                         const graph::Marginals& marginals,
                                         Eigen::Index value) const {
  const auto [first, last] = reach(value);
  std::vector<Vec3> shifts;
  for (std::size_t k = first; k < last; ++k) shifts.push_back(by(k, value));
  return marginals.response(graph, first - 1, shifts);
}

// Changing the values by d changes the residual r of a step by J x(d) - by d, where x(d) is how
// the optimum of the poses moves: the normal equations of d are those of all unknowns with the
// poses eliminated.
void WheelNumbers::learn(graph::PoseGraph& graph, const graph::Marginals& marginals) {
  if (steps_.size() < 2) return;
  const Eigen::Index n = values_.size();
  std::vector<std::vector<Vec3>> moves;
  for (Eigen::Index i = 0; i < n; ++i) moves.push_back(response(graph, marginals, i));
  std::vector<graph::ResidualJacobians> jacobian(1);
  for (std::size_t k = 1; k < steps_.size(); ++k)
    jacobian.push_back(graph::residual_jacobians(graph.poses[k - 1], graph.poses[k],
                                                 graph.edges[k - 1].T_from_to));
  Eigen::MatrixXd normal = prior_;
  Eigen::VectorXd right = prior_ * (nominal_ - values_);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto [first, last] = reach(i);
    for (std::size_t k = first; k < last; ++k) {
      const graph::Edge& e = graph.edges[k - 1];
      const Vec3 weighed = e.information * by(k, i);
      right(i) += weighed.dot(graph::residual(graph.poses[k - 1], graph.poses[k], e.T_from_to));
      const Vec3 from = jacobian[k].from.transpose() * weighed;
      const Vec3 to = jacobian[k].to.transpose() * weighed;
      for (Eigen::Index j = 0; j <= i; ++j) {
        const std::vector<Vec3>& move = moves[static_cast<std::size_t>(j)];
        normal(i, j) += weighed.dot(by(k, j)) - from.dot(move[k - 1]) - to.dot(move[k]);
      }
    }
  }
  const Eigen::LDLT<Eigen::MatrixXd> root(normal);  // reads the lower half
  const Eigen::VectorXd d = root.solve(right);
  values_ += d;
  sigmas_ = root.solve(Eigen::MatrixXd::Identity(n, kNumbers)).diagonal().cwiseSqrt();
  for (std::size_t k = 0; k < graph.poses.size(); ++k) {
    Vec3 moved = Vec3::Zero();
    for (Eigen::Index i = 0; i < n; ++i) moved += d(i) * moves[static_cast<std::size_t>(i)][k];
    Pose2& pose = graph.poses[k];
    pose = {pose.x + moved.x(), pose.y + moved.y(), wrap_angle(pose.theta + moved.z())};
  }
}

}  // namespace majak::slam
