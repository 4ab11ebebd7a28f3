// SPDX-License-Identifier: Apache-2.0
// Satellites in EKF-SLAM: fixes that correct the pose, and until the heading is known the search
// for it.
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "majak/core/rigid_fit.hpp"
#include "majak/slam/ekf_slam.hpp"

namespace majak::slam {
namespace {

using filter::LandmarkFilter;

constexpr const char* kRefused = "fixes that contradict all else; not used";
constexpr double kDrift = 0.1;  // of the way, until the heading is known

// Into a map whose frame is known that well.
void move(Estimate& e, const Pose2& T_new_old, const Mat3& covariance) {
  e.T_map_robot = T_new_old * e.T_map_robot;
  Mat3 turn = Mat3::Identity(), by_motion = Mat3::Identity();
  turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(T_new_old.theta).toRotationMatrix();
  const Vec2 way = e.T_map_robot.translation() - T_new_old.translation();
  by_motion.topRightCorner<2, 1>() = Vec2(-way.y(), way.x());
  e.covariance =
      turn * e.covariance * turn.transpose() + by_motion * covariance * by_motion.transpose();
}

}  // namespace

// z = t + R a + b: the antenna's place on the robot, and what the satellites err by now.
void EkfSlam::see(const GpsFix& fix) {
  predict(fix.time);
  ++fixes_seen_;
  const localize::FixVerdict verdict = pieces_.add(fix, motion_.way(), motion_.turned());
  if (!verdict.trusted) return report_.count("fixes that jump, or come alone; not used");
  if (!oriented_) return find_heading(fix, verdict.piece);
  if (verdict.piece != piece_) err_anew(verdict.piece);
  const Pose2& at = filter_.T_map_robot();
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(at.theta).toRotationMatrix();
  const Vec2 antenna = filter_.extra().segment<2>(kAntenna);
  const double fast = options_.gps_fast_sigma * options_.gps_fast_sigma;
  Eigen::MatrixXd by_state = Eigen::MatrixXd::Zero(2, filter_.covariance().cols());
  by_state.leftCols<2>().setIdentity();
  by_state.col(2) = turn * Vec2(-antenna.y(), antenna.x());
  by_state.middleCols<2>(3 + kAntenna) = turn;
  by_state.middleCols<2>(3 + kSlow).setIdentity();
  const Vec2 slow = filter_.extra().segment<2>(kSlow);
  const Vec2 residual = Vec2(fix.east, fix.north) - (at * antenna + slow);
  // Where both heading and antenna are hardly known, their product is no small number: the second
  // order of the turned antenna counts as noise.
  const Eigen::MatrixXd& known = filter_.covariance();
  const double bent = known(2, 2) * (known.block<2, 2>(3 + kAntenna, 3 + kAntenna).trace() +
                                     0.5 * known(2, 2) * antenna.squaredNorm());
  const Eigen::Matrix2d noise = (fast + bent) * Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d s = by_state * filter_.covariance() * by_state.transpose() + noise;
  const double nis = residual.dot(s.inverse() * residual);
  // Beyond the gate it counts as measured that much worse: it may be right, and the filter too
  // sure.
  const double share = std::min(1.0, options_.gps_gate / nis);
  innovations_.push_back({fix.time, "gps", nis, 2, share == 1});
  if (refused(nis, fix.time)) return report_.count(kRefused);
  if (share < 1) report_.count("fixes beyond the gate; believed less");
  keep(fix, verdict.piece);
  filter_.correct(residual, by_state, noise + s * (1 / share - 1));
}

void EkfSlam::err_anew(std::size_t piece) {
  piece_ = piece;
  filter::RelativeInput<LandmarkFilter::kExtra> anew;
  anew.at = filter_.extra();
  anew.keep.tail<2>().setZero();
  anew.extra_noise.tail<2>().setConstant(options_.gps_sigma * options_.gps_sigma);
  filter_.predict(anew);
}

// A receiver that is far off errs for some time, then the filter does.
bool EkfSlam::refused(double nis, Time time) {
  const bool far = nis > options_.gps_refused;
  if (!far) contradicted_since_.reset();
  if (far && !contradicted_since_) contradicted_since_ = time;
  return far && to_seconds(time - *contradicted_since_) < options_.gps_patience;
}

// For the graph, that may believe it more.
void EkfSlam::keep(const GpsFix& fix, std::size_t piece) {
  if (estimates_.empty()) return;
  const Pose2 T_scan_robot = since_scan_.apply({{}, filter_.extra()}).T_map_robot;
  fixes_.push_back({estimates_.size() - 1, T_scan_robot, {fix.east, fix.north}, piece});
}

// Until the way tells the heading, the map is as the robot began it.
void EkfSlam::find_heading(const GpsFix& fix, std::size_t piece) {
  keep(fix, piece);
  const Vec2 antenna = filter_.extra().segment<2>(kAntenna);
  before_.push_back({filter_.T_map_robot() * antenna, {fix.east, fix.north}, piece});
  std::vector<Vec2> driven, fixed;
  double widest = 0;
  for (const EarlyFix& f : before_) {
    driven.push_back(f.driven), fixed.push_back(f.fixed);
    widest = std::max(widest, (f.driven - driven.front()).norm());
  }
  if (widest < options_.find_heading) return;
  const double place = std::hypot(options_.gps_sigma, options_.antenna_sigma);
  // The antenna swings by what the way bends, half a radian. More would be safe in a linear world:
  // here a wide heading that is then corrected is taken for knowledge of it.
  const double turn = 0.5 * place / widest;
  const Pose2 T_new_old = rigid_fit(driven, fixed);
  double worst = 0;
  for (const EarlyFix& f : before_)
    worst = std::max(worst, (T_new_old * f.driven - f.fixed).norm());
  if (worst > 3 * place + kDrift * widest) return drop_early_fixes();
  const Mat3 covariance = Vec3(place, place, turn).cwiseAbs2().asDiagonal();
  filter_.move_map(T_new_old, covariance);
  for (Estimate& e : estimates_) {
    move(e, T_new_old, covariance);
    doubt_if_vague(e);
  }
  for (Known& known : known_) {  // the filter no longer has those that are gone
    Estimate as_pose{.T_map_robot = {known.p_map.x(), known.p_map.y(), 0}};
    as_pose.covariance.topLeftCorner<2, 2>() = known.covariance;
    move(as_pose, T_new_old, covariance);
    known.p_map = as_pose.T_map_robot.translation();
    known.covariance = as_pose.covariance.topLeftCorner<2, 2>();
  }
  looked_from_ = filter_.T_map_robot().translation();
  filter_.look_around(looked_from_, options_.near);
  oriented_ = true;
}

// The way and the fixes have not one shape: those of the longest piece stay.
void EkfSlam::drop_early_fixes() {
  const auto of_piece = [&](std::size_t piece) {
    return std::count_if(before_.begin(), before_.end(),
                         [&](const EarlyFix& f) { return f.piece == piece; });
  };
  std::size_t most = before_.front().piece;
  for (const EarlyFix& f : before_)
    if (of_piece(f.piece) > of_piece(most)) most = f.piece;
  const auto dropped = std::erase_if(before_, [&](const EarlyFix& f) { return f.piece != most; });
  std::erase_if(fixes_, [&](const FixObservation& f) { return f.piece != most; });
  if (dropped == 0) before_.clear(), fixes_.clear();  // nor has it by itself
  for (std::size_t i = 0; i < dropped; ++i) report_.count(kRefused);
}

}  // namespace majak::slam
