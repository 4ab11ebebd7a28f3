// SPDX-License-Identifier: Apache-2.0
#include "majak/filter/landmark_filter.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace majak::filter {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

void drop(MatrixXd& m, Eigen::Index row, Eigen::Index rows) {
  const Eigen::Index left = m.rows() - row - rows;
  m.middleRows(row, left) = m.bottomRows(left).eval();
  m.conservativeResize(m.rows() - rows, m.cols());
}

}  // namespace

LandmarkFilter::LandmarkFilter(const Pose2& T_map_robot, const Extra& extra, const Body& covariance)
    : T_map_robot_(T_map_robot), extra_(extra), near_covariance_(covariance) {
  look_around({}, 0);
}

// x' = x * T(extra), extra' = keep .* extra.
void LandmarkFilter::predict(const RelativeInput<kExtra>& motion) {
  const PoseState<kExtra> to = motion.apply({T_map_robot_, extra_});
  const Vec3 beside = motion.by_extra * (extra_ - motion.at);
  Mat3 turn = Mat3::Identity(), swing = Mat3::Identity();
  turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(to.T_map_robot.theta).toRotationMatrix();
  swing(0, 2) = -(to.T_map_robot.y - T_map_robot_.y);
  swing(1, 2) = to.T_map_robot.x - T_map_robot_.x;
  Body f = Body::Zero(), q = Body::Zero();
  f.topLeftCorner<3, 3>() = swing;
  f.topRightCorner<3, kExtra>() = turn * right_jacobian(beside) * motion.by_extra;
  f.bottomRightCorner<kExtra, kExtra>().diagonal() = motion.keep;
  q.topLeftCorner<3, 3>() = turn * motion.noise * turn.transpose();
  q.bottomRightCorner<kExtra, kExtra>().diagonal() = motion.extra_noise;
  T_map_robot_ = to.T_map_robot;
  extra_ = to.extra;
  near_covariance_.topRows<kBody>() = (f * near_covariance_.topRows<kBody>()).eval();
  near_covariance_.leftCols<kBody>() = (near_covariance_.leftCols<kBody>() * f.transpose()).eval();
  near_covariance_.topLeftCorner<kBody, kBody>() += q;
  carried_.topRows<kBody>() = (f * carried_.topRows<kBody>()).eval();
}

double LandmarkFilter::correct(const VectorXd& residual, const MatrixXd& by_state,
                               const MatrixXd& noise) {
  const MatrixXd spread = near_covariance_ * by_state.transpose();
  const MatrixXd s = by_state * spread + noise;
  const Eigen::LLT<MatrixXd> s_root(s);
  const MatrixXd gain = s_root.solve(spread.transpose()).transpose();
  const VectorXd weighed = s_root.solve(residual);
  const MatrixXd then = by_state * carried_;
  seen_.noalias() += then.transpose() * s_root.solve(then);
  pulled_.noalias() += then.transpose() * weighed;
  carried_.noalias() -= gain * then;
  near_covariance_.noalias() -= gain * spread.transpose();
  near_covariance_ = (0.5 * (near_covariance_ + near_covariance_.transpose())).eval();
  add_to_mean(gain * residual);
  return residual.dot(weighed);
}

void LandmarkFilter::add_to_mean(const VectorXd& d) {
  T_map_robot_ = {T_map_robot_.x + d(0), T_map_robot_.y + d(1),
                  wrap_angle(T_map_robot_.theta + d(2))};
  extra_ += d.segment<kExtra>(3);
  for (std::size_t i = 0; i < near_.size(); ++i)
    landmarks_[static_cast<std::size_t>(near_[i])] +=
        d.segment<2>(kBody + 2 * static_cast<Eigen::Index>(i));
}

int LandmarkFilter::add(const Vec2& q_robot, const Eigen::Matrix2d& noise) {
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(T_map_robot_.theta).toRotationMatrix();
  const Vec2 way = turn * q_robot;
  Eigen::Matrix<double, 2, 3> by_pose;
  by_pose << 1, 0, -way.y(), 0, 1, way.x();
  const Eigen::Index n = near_covariance_.rows();
  near_covariance_.conservativeResize(n + 2, n + 2);
  near_covariance_.bottomLeftCorner(2, n) = by_pose * near_covariance_.topLeftCorner(3, n);
  near_covariance_.topRightCorner(n, 2) = near_covariance_.bottomLeftCorner(2, n).transpose();
  near_covariance_.bottomRightCorner<2, 2>() =
      by_pose * near_covariance_.topLeftCorner<3, 3>() * by_pose.transpose() +
      turn * noise * turn.transpose();
  carried_.conservativeResize(n + 2, carried_.cols());
  carried_.bottomRows<2>() = by_pose * carried_.topRows<3>();
  const int id = static_cast<int>(landmarks_.size());
  landmarks_.push_back(T_map_robot_ * q_robot);
  columns_.push_back(static_cast<int>(n));
  near_.push_back(id);
  return id;
}

void LandmarkFilter::remove(int id) {
  const Eigen::Index at = column(id);
  drop(near_covariance_, at, 2);
  near_covariance_.transposeInPlace();
  drop(near_covariance_, at, 2);
  drop(carried_, at, 2);
  std::erase(near_, id);
  columns_[static_cast<std::size_t>(id)] = -1;
  number_columns();
}

void LandmarkFilter::number_columns() {
  int column = kBody;
  for (const int id : near_) columns_[static_cast<std::size_t>(id)] = column, column += 2;
  for (const int id : far_) columns_[static_cast<std::size_t>(id)] = -1;
}

// What was seen near by, told to what is far: with then -> now carried, and what was seen in terms
// of then, P_nf = carried cross, P_ff -= cross' seen cross, x_f += cross' pulled.
void LandmarkFilter::settle() {
  const Eigen::Index n = near_covariance_.rows(), m = far_covariance_.rows();
  if (m > 0) {
    const VectorXd moved = cross_.transpose() * pulled_;
    for (std::size_t i = 0; i < far_.size(); ++i)
      landmarks_[static_cast<std::size_t>(far_[i])] +=
          moved.segment<2>(2 * static_cast<Eigen::Index>(i));
    MatrixXd all(n + m, n + m);
    all.topLeftCorner(n, n) = near_covariance_;
    all.topRightCorner(n, m).noalias() = carried_ * cross_;
    all.bottomLeftCorner(m, n) = all.topRightCorner(n, m).transpose();
    all.bottomRightCorner(m, m) = far_covariance_;
    all.bottomRightCorner(m, m).noalias() -= cross_.transpose() * (seen_ * cross_);
    near_covariance_.swap(all);
    near_.insert(near_.end(), far_.begin(), far_.end());
    far_.clear();
    number_columns();
  }
  cross_.resize(near_covariance_.rows(), 0);
  far_covariance_.resize(0, 0);
  carried_.setIdentity(near_covariance_.rows(), near_covariance_.rows());
  seen_.setZero(near_covariance_.rows(), near_covariance_.rows());
  pulled_.setZero(near_covariance_.rows());
}

void LandmarkFilter::look_around(const Vec2& centre, double radius) {
  settle();
  std::vector<Eigen::Index> order(kBody);
  std::iota(order.begin(), order.end(), 0);
  std::vector<int> near, far;
  for (const int id : near_) ((landmark(id) - centre).norm() <= radius ? near : far).push_back(id);
  for (const std::vector<int>* part : {&near, &far})
    for (const int id : *part) order.push_back(column(id)), order.push_back(column(id) + 1);
  const MatrixXd all = near_covariance_(order, order);
  const auto n = kBody + 2 * static_cast<Eigen::Index>(near.size());
  const auto m = 2 * static_cast<Eigen::Index>(far.size());
  near_.swap(near);
  far_.swap(far);
  near_covariance_ = all.topLeftCorner(n, n);
  cross_ = all.topRightCorner(n, m);
  far_covariance_ = all.bottomRightCorner(m, m);
  carried_.setIdentity(n, n);
  seen_.setZero(n, n);
  pulled_.setZero(n);
  number_columns();
}

void LandmarkFilter::move_map(const Pose2& T_new_old, const Mat3& covariance) {
  settle();
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(T_new_old.theta).toRotationMatrix();
  const Eigen::Index n = near_covariance_.rows();
  MatrixXd by_old = MatrixXd::Identity(n, n), by_motion = MatrixXd::Zero(n, 3);
  const auto place = [&](Eigen::Index row, const Vec2& p_old) {
    const Vec2 way = turn * p_old;
    by_old.block<2, 2>(row, row) = turn;
    by_motion.middleRows<2>(row) << 1, 0, -way.y(), 0, 1, way.x();
  };
  place(0, T_map_robot_.translation());
  by_motion(2, 2) = 1;
  for (const int id : near_) place(column(id), landmark(id));
  near_covariance_ = by_old * near_covariance_ * by_old.transpose() +
                     by_motion * covariance * by_motion.transpose();
  T_map_robot_ = T_new_old * T_map_robot_;
  for (const int id : near_) {
    Vec2& p = landmarks_[static_cast<std::size_t>(id)];
    p = T_new_old * p;
  }
  settle();
}

}  // namespace majak::filter
