// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/pose_covariance.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "majak/core/error.hpp"
#include "majak/graph/normal_equations.hpp"

namespace majak::slam {
namespace {

constexpr double kNormalNoise2 = 4e-3;  // rad^2, variance of a surface's normal
constexpr double kReused = 2.8;     // a scan stands in six pairs and more, which count as independent
constexpr double kAmplified = 1.7;  // what a common error does, measured, beside its linear prediction
constexpr double kTold = 0.3;       // share of the edges' disagreement that counts, by the same reuse
constexpr double kPairGate = 0.075;  // m
constexpr double kLeastNoise = 0.005;  // m
constexpr double kLostScore = 0.4;   // share of the returns that fit, below which a scan is elsewhere
constexpr double kHeldSigma = 0.02;  // m; a direction known worse by the laser is weak

constexpr int kLaw = RangeBias::kCount;
constexpr int kColumns = kLaw + 1;  // the last: motion that nothing sees, all in one direction
using Shift = Eigen::Matrix<double, 3, kColumns>;

Mat3 to_own_axes(double theta, const Mat3& information) {
  const double c = std::cos(theta), s = std::sin(theta);
  Mat3 r;
  r << c, -s, 0, s, c, 0, 0, 0, 1;
  return r.transpose() * information * r;
}

Mat3 widened(const Mat3& information, bool weak) {
  Mat3 covariance = (information + 1e-3 * Mat3::Identity()).inverse();
  covariance.diagonal() += Vec3(4e-6, 4e-6, 1e-6);
  if (weak) covariance.diagonal() += Vec3(0.04, 0.04, 0.04);
  return covariance.inverse();
}

Mat3 information_of(const UnseenMotion& unseen) {
  const double way = 1 / (unseen.way * unseen.way), turn = 1 / (unseen.turn * unseen.turn);
  return Vec3(way, way, turn).asDiagonal();
}

// The graph with honest informations, and how each pose answers to each common error.
class Responses {
 public:
  explicit Responses(const KeyScans& keys) : gradient_(keys.size(), Shift::Zero()), disagreement_(keys.size(), Vec3::Zero()) {
    for (const KeyScan& key : keys) graph_.poses.push_back(key.T_map_robot);
  }

  // An edge whose measurement is shifted by the columns of `shift`, in the axes of edge.to.
  void add(const graph::Edge& edge, const Shift& shift) {
    const Pose2 &from = graph_.poses[edge.from], &to = graph_.poses[edge.to];
    const graph::ResidualJacobians d = graph::residual_jacobians(from, to, edge.T_from_to);
    const Mat3 &information = edge.information;
    const Vec3 e = graph::residual(from, to, edge.T_from_to);
    gradient_[edge.from] += d.from.transpose() * information * shift;
    gradient_[edge.to] += d.to.transpose() * information * shift;
    disagreement_[edge.from] += d.from.transpose() * information * e;
    disagreement_[edge.to] += d.to.transpose() * information * e;
    precision_ += shift.transpose() * information * shift;
    seen_ -= shift.transpose() * information * e;
    graph_.edges.push_back(edge);
  }

  // `scale` of the variance that the edges claim.
  KeyUncertainty solve(double scale) {
    equations_.set(graph_);
    equations_.linearize(graph_.poses);
    if (!equations_.matrix().factor())
      throw Error("pose graph: its edges leave a pose undetermined, so it has no covariance");
    solve_columns();
    KeyUncertainty result;
    result.range_bias = learn();
    const std::vector<Mat3> blocks = equations_.matrix().inverse_diagonal();
    const LearntRangeBias& law = result.range_bias;
    Eigen::Matrix<double, kColumns, kColumns> moment = Eigen::Matrix<double, kColumns, kColumns>::Identity();
    moment.topLeftCorner<kLaw, kLaw>() = kAmplified * kAmplified * (law.covariance + law.mean * law.mean.transpose());
    for (std::size_t i = 0; i < graph_.poses.size(); ++i) {
      const bool anchor = equations_.is_anchor(static_cast<int>(i));
      result.covariances.push_back(Mat3::Zero());
      if (anchor) continue;
      result.covariances[i] = scale * blocks[equations_.variable(static_cast<int>(i))] + response_[i] * moment * response_[i].transpose();
    }
    return result;
  }

 private:
  std::size_t row(std::size_t pose) const { return 3 * static_cast<std::size_t>(equations_.variable(static_cast<int>(pose))); }

  void solve_columns() {
    response_.assign(graph_.poses.size(), Shift::Zero());
    std::vector<double> column(3 * static_cast<std::size_t>(equations_.matrix().size()));
    for (int c = 0; c < kColumns; ++c) {
      for (std::size_t i = 0; i < graph_.poses.size(); ++i)
        if (!equations_.is_anchor(static_cast<int>(i))) std::copy_n(gradient_[i].col(c).data(), 3, &column[row(i)]);
      equations_.matrix().solve(column);
      for (std::size_t i = 0; i < graph_.poses.size(); ++i)
        if (!equations_.is_anchor(static_cast<int>(i))) response_[i].col(c) = Eigen::Map<const Vec3>(&column[row(i)]);
    }
  }

  // The law's most probable weights given how the edges disagree: poses eliminated (Schur).
  LearntRangeBias learn() const {
    Eigen::Matrix<double, kColumns, kColumns> precision = precision_;
    Eigen::Matrix<double, kColumns, 1> seen = seen_;
    for (std::size_t i = 0; i < graph_.poses.size(); ++i) {
      precision -= gradient_[i].transpose() * response_[i];
      seen += response_[i].transpose() * disagreement_[i];
    }
    using Square = Eigen::Matrix<double, kLaw, kLaw>;
    LearntRangeBias law;
    law.covariance = (kTold * Square(precision.topLeftCorner<kLaw, kLaw>()) + Square::Identity()).llt().solve(Square::Identity());
    law.mean = law.covariance * (kTold * seen.head<kLaw>());
    return law;
  }

  graph::PoseGraph graph_;
  graph::NormalEquations equations_;
  std::vector<Shift> gradient_, response_;
  std::vector<Vec3> disagreement_;
  Eigen::Matrix<double, kColumns, kColumns> precision_ = Eigen::Matrix<double, kColumns, kColumns>::Zero();
  Eigen::Matrix<double, kColumns, 1> seen_ = Eigen::Matrix<double, kColumns, 1>::Zero();
};

}  // namespace

// The matcher's own information, which knows the weak directions, widened by what returns of one wall
// have in common.
Mat3 step_information(const FrontEndStep& step, bool weak) {
  return widened(to_own_axes(step.T_map_robot.theta, 0.25 * step.match.information + step.prior_information), weak);
}

Mat3 laser_step_information(const FrontEndStep& step, bool weak) {
  return widened(to_own_axes(step.T_map_robot.theta, 0.25 * without_normal_noise(step.match.information)), weak);
}

Mat3 without_normal_noise(const Mat3& information) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes;
  axes.computeDirect(information.topLeftCorner<2, 2>());
  const double weak = axes.eigenvalues()(0);
  if (!(weak > 0)) return information;
  const double kept = std::max(0.0, 1 - kNormalNoise2 * axes.eigenvalues().sum() / weak);
  const Vec2 t = axes.eigenvectors().col(0);
  Mat3 s = Mat3::Identity();
  s.topLeftCorner<2, 2>() -= (1 - std::sqrt(kept)) * t * t.transpose();
  return s * information * s;
}

UnseenMotion unseen_motion(const PosedScan& from, const PosedScan& to) {
  if (from.T_odom_robot && to.T_odom_robot) {
    const Pose2 step = between(*from.T_odom_robot, *to.T_odom_robot);
    return {0.01 + 0.02 * std::hypot(step.x, step.y), 0.02 + 0.05 * std::abs(step.theta)};
  }
  const double time = std::min(std::abs(to_seconds(to.scan.time - from.scan.time)), 1000.0);
  return {0.01 + 0.7 * time, 0.02 + 0.5 * time};
}

KeyUncertainty key_uncertainty(const KeyScans& keys, const JointRefinement& refined, const std::vector<UnseenMotion>& unseen) {
  if (keys.size() < 2) return {std::vector<Mat3>(keys.size(), Mat3::Zero()), {}};
  std::vector<LaserView> views;
  for (const KeyScan& key : keys) views.push_back(laser_view(key));
  Responses responses(keys);
  for (std::size_t k = 0; k < refined.edges.size(); ++k) {
    graph::Edge edge = refined.edges[k];
    Shift shift = Shift::Zero();
    if (refined.is_step[k]) {
      edge.information = refined.step_weight * keys[edge.to].laser_step_information;
    } else {
      edge.information = without_normal_noise(edge.information);
    }
    shift.leftCols<kLaw>() = RangeBias::shift(keys[edge.from], views[edge.from], keys[edge.to], kPairGate);
    responses.add(edge, shift);
  }
  // Where the laser says nothing, all of the way may be wrong by the same share.
  for (std::size_t k = 1; k < keys.size(); ++k) {
    Shift shift = Shift::Zero();
    shift(0, kLaw) = unseen[k].way;
    responses.add({static_cast<int>(k) - 1, static_cast<int>(k), between(keys[k - 1].T_map_robot, keys[k].T_map_robot),
                   information_of(unseen[k]), false}, shift);
  }
  // The returns' own noise is what the log shows, not what the matcher weighs with.
  const double noise = refined.rms.empty() ? refined.sigma : std::max(refined.rms.back(), kLeastNoise);
  return responses.solve(kReused * noise * noise / (refined.sigma * refined.sigma));
}

void judge(const Mat3& key_covariance, const match::Match& match, const UnseenMotion& unseen, Estimate& estimate) {
  const Mat3 seen = without_normal_noise(match.information);
  estimate.covariance = key_covariance + (seen + information_of(unseen)).inverse();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes;
  axes.computeDirect(seen.topLeftCorner<2, 2>());
  if (match.score < kLostScore) {
    estimate.health = Health::lost;
  } else if (axes.eigenvalues()(0) < 1 / (kHeldSigma * kHeldSigma)) {
    estimate.health = Health::degraded;
    estimate.weak_direction = axes.eigenvectors().col(0);
  }
}

}  // namespace majak::slam
