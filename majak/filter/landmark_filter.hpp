// SPDX-License-Identifier: Apache-2.0
// LandmarkFilter: the extended Kalman filter over a pose, numbers that are learnt beside it, and
// points in the plane (Smith, Self and Cheeseman 1990), with local updates: only what stands near
// is touched at each step, what that means for all the rest is put off until the robot looks
// around elsewhere, and is then exactly the same (Guivant and Nebot 2001; docs/MATH.md "EKF-SLAM").
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "majak/filter/pose_filter.hpp"

namespace majak::filter {

class LandmarkFilter {
 public:
  static constexpr int kExtra = 11;         ///< numbers beside the pose
  static constexpr int kBody = 3 + kExtra;  ///< numbers before the landmarks'
  using Extra = Eigen::Matrix<double, kExtra, 1>;
  using Body = Eigen::Matrix<double, kBody, kBody>;

  /// `covariance` of (x, y, theta in map axes, extra).
  LandmarkFilter(const Pose2& T_map_robot, const Extra& extra, const Body& covariance);

  const Pose2& T_map_robot() const { return T_map_robot_; }
  const Extra& extra() const { return extra_; }
  /// Of the body and of the landmarks that are near, in that order.
  const Eigen::MatrixXd& covariance() const { return near_covariance_; }
  const std::vector<int>& near() const { return near_; }
  std::size_t size() const { return near_.size() + far_.size(); }
  /// m, map frame. Of one that is far as it was when it was near last, before settle().
  const Vec2& landmark(int id) const { return landmarks_[static_cast<std::size_t>(id)]; }
  /// Column of a landmark in covariance(), -1 if it is far or removed.
  int column(int id) const { return columns_[static_cast<std::size_t>(id)]; }

  void predict(const RelativeInput<kExtra>& motion);

  /// residual = measured - expected, `by_state`: its expectation's derivative by the state that
  /// covariance() is of. Not gated. Returns the NIS.
  double correct(const Eigen::VectorXd& residual, const Eigen::MatrixXd& by_state,
                 const Eigen::MatrixXd& noise);

  /// A new landmark at q in the robot's frame; `noise` of q. Returns its number; it is near.
  int add(const Vec2& q_robot, const Eigen::Matrix2d& noise);
  /// Forgets one that is near.
  void remove(int id);

  /// What is within `radius` m of `centre` is near from now on, the rest is far.
  void look_around(const Vec2& centre, double radius);
  /// All is near.
  void settle();
  /// The whole map is moved by T_new_old, which is known as well as `covariance` says (of its x,
  /// y, theta). All is near afterwards.
  void move_map(const Pose2& T_new_old, const Mat3& covariance);

 private:
  void number_columns();
  void begin_afresh();
  std::vector<Eigen::Index> begin_correction(const Eigen::MatrixXd& by_state);
  void add_to_mean(const Eigen::VectorXd& d);

  Pose2 T_map_robot_;
  Extra extra_;
  std::vector<Vec2> landmarks_;
  std::vector<int> columns_;
  std::vector<int> near_, far_;
  Eigen::MatrixXd near_covariance_;
  // As they were when the robot looked around last, and what happened since. Of what was near then
  // only the body and what was seen since counts; the rest stands for itself, row by row.
  Eigen::MatrixXd cross_;  ///< near then x far
  Eigen::MatrixXd far_covariance_;
  std::vector<Eigen::Index> counts_;  ///< rows of cross_
  std::vector<int> row_of_;           ///< of landmarks that stand for themselves, in cross_; or -1
  Eigen::MatrixXd carried_;           ///< near now by what counts
  Eigen::MatrixXd seen_;              ///< information of what counts
  Eigen::VectorXd pulled_;            ///< the same of its mean
};

}  // namespace majak::filter
