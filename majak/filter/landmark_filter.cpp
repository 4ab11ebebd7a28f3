// SPDX-License-Identifier: Apache-2.0
#include "majak/filter/landmark_filter.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace majak::filter {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

void drop(MatrixXd& m, Eigen::Index row, Eigen::Index rows) {
  const Eigen::Index left = m.rows() - row - rows;
  m.middleRows(row, left) = m.bottomRows(left).eval();
  m.conservativeResize(m.rows() - rows, m.cols());
}

/// Of a symmetric matrix of which the lower half is known.
void mirror(MatrixXd& m) {
  for (Eigen::Index i = 0; i + 1 < m.rows(); ++i)
    m.row(i).tail(m.cols() - i - 1) = m.col(i).tail(m.rows() - i - 1).transpose();
}

}  // namespace

LandmarkFilter::LandmarkFilter(const Pose2& T_map_robot, const Extra& extra, const Body& covariance)
    : T_map_robot_(T_map_robot), extra_(extra), near_covariance_(covariance) {
  look_around(Vec2::Zero(), 0);
}

// x' = x * T(extra), extra' = keep .* extra.
void LandmarkFilter::predict(const RelativeInput<kExtra>& motion) {
  const PoseState<kExtra> to = motion.apply({T_map_robot_, extra_});
  const Vec3 beside = motion.by_extra * (extra_ - motion.at);
  Mat3 turn = Mat3::Identity();
  turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(to.T_map_robot.theta).toRotationMatrix();
  Eigen::Matrix<double, 3, kBody> pose_by_body = Eigen::Matrix<double, 3, kBody>::Identity();
  pose_by_body(0, 2) = -(to.T_map_robot.y - T_map_robot_.y);
  pose_by_body(1, 2) = to.T_map_robot.x - T_map_robot_.x;
  pose_by_body.rightCols<kExtra>() = turn * right_jacobian(beside) * motion.by_extra;
  T_map_robot_ = to.T_map_robot;
  extra_ = to.extra;
  const auto carry = [&](MatrixXd& rows) {
    rows.topRows<3>() = (pose_by_body * rows.topRows<kBody>()).eval();
    rows.middleRows<kExtra>(3).array().colwise() *= motion.keep.array();
  };
  carry(near_covariance_);
  near_covariance_.leftCols<3>() =
      (near_covariance_.leftCols<kBody>() * pose_by_body.transpose()).eval();
  near_covariance_.middleCols<kExtra>(3).array().rowwise() *= motion.keep.transpose().array();
  near_covariance_.topLeftCorner<3, 3>() += turn * motion.noise * turn.transpose();
  near_covariance_.diagonal().segment<kExtra>(3) += motion.extra_noise;
  carry(carried_);
}

// With L L' the innovation's covariance: U = P H' L^-T, V = L^-1 H A, w = L^-1 e, and all that a
// correction does is a product of two of these.
double LandmarkFilter::correct(const VectorXd& residual, const MatrixXd& by_state,
                               const MatrixXd& noise) {
  const std::vector<Eigen::Index> used = begin_correction(by_state);
  const MatrixXd h = by_state(Eigen::all, used);
  const MatrixXd columns = near_covariance_(Eigen::all, used);
  MatrixXd u = columns * h.transpose();
  const Eigen::LLT<MatrixXd> root(h * u(used, Eigen::all) + noise);
  root.matrixU().solveInPlace<Eigen::OnTheRight>(u);
  const MatrixXd rows = carried_(used, Eigen::all);
  MatrixXd v = h * rows;
  root.matrixL().solveInPlace(v);
  const VectorXd w = root.matrixL().solve(residual);
  seen_.noalias() += v.transpose() * v;
  pulled_.noalias() += v.transpose() * w;
  carried_.noalias() -= u * v;
  near_covariance_.selfadjointView<Eigen::Lower>().rankUpdate(u, -1);
  mirror(near_covariance_);
  add_to_mean(u * w);
  return w.squaredNorm();
}

// Columns of the state that a measurement depends on; the landmarks among them count from now on.
std::vector<Eigen::Index> LandmarkFilter::begin_correction(const MatrixXd& by_state) {
  std::vector<Eigen::Index> used;
  for (Eigen::Index i = 0; i < kBody; ++i)
    if (!by_state.col(i).isZero(0)) used.push_back(i);
  for (const int id : near_) {
    const Eigen::Index at = column(id);
    if (by_state.middleCols<2>(at).isZero(0)) continue;
    used.push_back(at), used.push_back(at + 1);
    int& row = row_of_[static_cast<std::size_t>(id)];
    if (row < 0) continue;
    counts_.push_back(row), counts_.push_back(row + 1);
    row = -1;
    const auto n = static_cast<Eigen::Index>(counts_.size());
    carried_.conservativeResize(Eigen::NoChange, n);
    carried_.rightCols<2>().setZero();
    carried_.block<2, 2>(at, n - 2).setIdentity();
    seen_.conservativeResizeLike(MatrixXd::Zero(n, n));
    pulled_.conservativeResizeLike(VectorXd::Zero(n));
  }
  return used;
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
  row_of_.push_back(-1);
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
  if (!far_.empty()) {
    const Eigen::Index n = near_covariance_.rows(), m = far_covariance_.rows();
    const MatrixXd cross = cross_(counts_, Eigen::all);
    const VectorXd moved = cross.transpose() * pulled_;
    for (std::size_t i = 0; i < far_.size(); ++i)
      landmarks_[static_cast<std::size_t>(far_[i])] +=
          moved.segment<2>(2 * static_cast<Eigen::Index>(i));
    MatrixXd all(n + m, n + m), shared = carried_ * cross;
    for (const int id : near_)
      if (const int row = row_of_[static_cast<std::size_t>(id)]; row >= 0)
        shared.middleRows<2>(column(id)) += cross_.middleRows<2>(row);
    const MatrixXd weighed = seen_ * cross;
    far_covariance_.triangularView<Eigen::Lower>() -= cross.transpose() * weighed;
    all.topLeftCorner(n, n) = near_covariance_;
    all.bottomLeftCorner(m, n) = shared.transpose();
    all.bottomRightCorner(m, m) = far_covariance_;
    mirror(all);
    near_covariance_.swap(all);
    near_.insert(near_.end(), far_.begin(), far_.end());
    far_.clear();
    number_columns();
  }
  cross_.resize(near_covariance_.rows(), 0);
  far_covariance_.resize(0, 0);
  begin_afresh();
}

// Of what is near now nothing was seen yet.
void LandmarkFilter::begin_afresh() {
  row_of_.assign(landmarks_.size(), -1);
  for (const int id : near_) row_of_[static_cast<std::size_t>(id)] = column(id);
  counts_.resize(kBody);
  std::iota(counts_.begin(), counts_.end(), 0);
  carried_.setIdentity(near_covariance_.rows(), kBody);
  seen_.setZero(kBody, kBody);
  pulled_.setZero(kBody);
}

void LandmarkFilter::look_around(const Vec2& centre, double radius) {
  settle();
  std::vector<Eigen::Index> order(kBody);
  std::iota(order.begin(), order.end(), 0);
  std::vector<int> near, far;
  for (const int id : near_) ((landmark(id) - centre).norm() <= radius ? near : far).push_back(id);
  for (const std::vector<int>* part : {&near, &far})
    for (const int id : *part) order.push_back(column(id)), order.push_back(column(id) + 1);
  const auto n = kBody + 2 * static_cast<Eigen::Index>(near.size());
  const std::vector<Eigen::Index> first(order.begin(), order.begin() + n);
  const std::vector<Eigen::Index> second(order.begin() + n, order.end());
  const MatrixXd all = std::move(near_covariance_);
  near_.swap(near);
  far_.swap(far);
  near_covariance_ = all(first, first);
  cross_ = all(first, second);
  far_covariance_ = all(second, second);
  number_columns();
  begin_afresh();
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
