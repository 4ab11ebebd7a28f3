// SPDX-License-Identifier: Apache-2.0
// What the Kalman filter is told: by the wheels (relative), by satellites and beacons (absolute).
#include <algorithm>
#include <cmath>

#include "majak/localize/kalman.hpp"

namespace majak::localize {
namespace {

constexpr double kTooNear = 0.05;                     // m to a beacon that tells nothing any more
constexpr double kJitter = 0.01, kTurnJitter = 0.01;  // m, rad of a step

}  // namespace

// ---- Relative information: the wheels --------------------------------------------------------

void Kalman::roll(const motion::WheelStep& wheels, double seconds) {
  const KalmanOptions& o = options_;
  Motion step;
  step.at = pending_.at;
  step.T_from_to = exp(wheels.twist);
  step.by_extra.leftCols<4>() = right_jacobian(wheels.twist) * wheels.by_numbers.leftCols<4>();
  step.noise.diagonal() =
      motion::step_variance(wheels.twist, {o.way_noise, o.side_noise, o.turn_noise, o.spin_noise});
  pending_.then(step);
  way_ += wheels.twist.head<2>().norm();
  turned_ += std::abs(wheels.twist.z());
  drift(seconds);
}

// What time alone does to the extra numbers.
void Kalman::drift(double seconds) {
  if (seconds <= 0) return;
  Motion idle;
  idle.at = pending_.at;
  const double keep = std::exp(-seconds / options_.gps_memory);
  const double slow = fixes_.empty() ? options_.gps_sigma : sigma_of(fixes_.back());
  idle.keep.tail<2>().setConstant(keep);
  idle.extra_noise.tail<2>().setConstant(slow * slow * (1 - keep * keep));
  if (!wheels_ && !odometry_)
    idle.noise.diagonal().setConstant(options_.idle_noise * options_.idle_noise * seconds);
  pending_.then(idle);
}

// Speed and steering hold until the next record.
void Kalman::drive(const WheelMotion& next) {
  if (wheels_) {
    const double seconds = std::max(0.0, to_seconds(next.time - clock_));
    roll(motion::wheel_step(*wheels_, seconds, options_.wheelbase), seconds);
  }
  clock_ = begun_ ? std::max(clock_, next.time) : next.time;
  begun_ = true;
  wheels_ = next;
}

double Kalman::sigma_of(const GpsFix& fix) const {
  return fix.sigma > 0 ? fix.sigma : options_.gps_sigma;
}

// The odometry's own poses: what is measured between two of them waits for the second.
std::optional<Estimate> Kalman::drive(Time time, const Pose2& T_odom_robot) {
  std::optional<Estimate> newest;
  if (odometry_ && time > odometry_->time) {
    const Vec3 all = log(between(odometry_->T_odom_robot, T_odom_robot));
    const double whole = to_seconds(time - odometry_->time);
    const auto go = [&](Time until) {
      const double part = to_seconds(until - clock_) / whole;
      roll(motion::wheel_step(part * all), part * whole);
      clock_ = until;
    };
    while (!waiting_.empty() && waiting_.front().time <= time) {
      if (waiting_.front().time > clock_) go(waiting_.front().time);
      newest = take_waiting(waiting_.front().time);
    }
    if (time > clock_) go(time);
  } else if (!odometry_) {
    clock_ = time;
    begun_ = true;
  }
  if (!odometry_ || time > odometry_->time) odometry_ = Odometry{time, T_odom_robot, {}, {}};
  return newest;
}

// Wheels and laser are two accounts of one motion; each counts by its covariance. The wheels' has
// the jitter between the two clocks on top, which does not add up over the steps.
void Kalman::fuse(const ScanMatch& match, Node& node) const {
  Motion& motion = node.motion;
  const Mat3 match_noise = match.information.inverse();
  Mat3 wheels_noise = motion.noise;
  wheels_noise.diagonal() += Vec3(kJitter, kJitter, kTurnJitter).cwiseAbs2();
  const Mat3 gain = wheels_noise * (wheels_noise + match_noise).inverse();
  node.by_wheels = Mat3::Identity() - gain;
  motion.T_from_to = motion.T_from_to * exp(gain * log(between(motion.T_from_to, match.T_from_to)));
  motion.by_extra = node.by_wheels * motion.by_extra;
  motion.noise = node.by_wheels * motion.noise * node.by_wheels.transpose() +
                 gain * match_noise * gain.transpose();
}

// The motion up to a measurement, where the wheels have not told it themselves.
void Kalman::move_to(Time time) {
  if (wheels_ && time > clock_) drive(WheelMotion{time, wheels_->speed, wheels_->steering});
  if (wheels_ || odometry_) return;
  if (begun_) drift(to_seconds(time - clock_));
  clock_ = begun_ ? std::max(clock_, time) : time;
  begun_ = true;
}

// ---- Absolute information: the satellites ----------------------------------------------------

// z = t + R a + b: the antenna's place, and the slow error of the satellites.
filter::AbsoluteInput<Kalman::kExtra, 2> Kalman::see(const GpsFix& fix, double weight,
                                                     const State& at) const {
  const double c = std::cos(at.T_map_robot.theta), s = std::sin(at.T_map_robot.theta);
  Eigen::Matrix2d turn;
  turn << c, -s, s, c;
  const Vec2 antenna = at.extra.segment<2>(kAntenna), slow = at.extra.segment<2>(kSlow);
  filter::AbsoluteInput<kExtra, 2> z;
  z.residual = Vec2(fix.east, fix.north) - (at.T_map_robot * antenna + slow);
  z.H.setZero();
  z.H.leftCols<2>() = turn;
  z.H.col(2) = turn * Vec2(-antenna.y(), antenna.x());
  z.H.middleCols<2>(3 + kAntenna) = turn;
  z.H.middleCols<2>(3 + kSlow).setIdentity();
  const double fast = options_.gps_fast_share * sigma_of(fix);
  z.noise = Eigen::Matrix2d::Identity() * (fast * fast / weight);
  return z;
}

// Range and bearing of a beacon, each by itself: q is the beacon in the robot's axes.
void Kalman::see(const BeaconSighting& sighting, double gate, Belief& belief,
                 std::vector<Innovation>* innovations) const {
  const Vec2 p_map = beacons_.find(sighting.beacon)->p_map;
  // At the nominal state, which a correction leaves alone.
  const Vec2 q = belief.nominal.T_map_robot.inverse() * p_map;
  const Vec2 way = q - sighting.T_robot_sensor.translation();
  const auto correct = [&](double residual, const Vec2& by_q, double sigma) {
    filter::AbsoluteInput<kExtra, 1> z;
    z.residual << residual;
    z.H.setZero();
    z.H.template leftCols<2>() = -by_q.transpose();
    z.H(0, 2) = by_q.x() * q.y() - by_q.y() * q.x();
    z.noise << sigma * sigma;
    const auto done = belief.correct(z, gate);
    if (innovations)
      innovations->push_back({sighting.time, "beacon", done.nis, 1, done.share == 1});
  };
  const double range = way.norm();
  if (range < kTooNear) return;
  if (sighting.range) correct(*sighting.range - range, way / range, sighting.range_sigma);
  if (sighting.bearing) {
    const double bearing = std::atan2(way.y(), way.x()) - sighting.T_robot_sensor.theta;
    correct(angle_diff(*sighting.bearing, bearing), Vec2(-way.y(), way.x()) / (range * range),
            sighting.bearing_sigma);
  }
}

// `linear`: the path is smoothed already. What a scale does to a step is then taken from the step
// as smoothed: the wheels' own account has noise, and a scale learnt from noise comes out too small
// (errors in variables, docs/MATH.md 3.2).
Kalman::Motion Kalman::motion_to(std::size_t k, bool linear) const {
  const Node& node = nodes_[k];
  Motion motion = node.motion;
  if (linear && k > 0 && odometry_) {
    const Vec3 u =
        log(between(nodes_[k - 1].smoothed.nominal.T_map_robot, node.smoothed.nominal.T_map_robot));
    const auto& extra = node.smoothed.nominal.extra;
    Vec3 counted = u / extra(kScale);  // what wheels without noise would report
    counted.z() = (u.z() - extra(kTurnOffset) * counted.x()) / extra(kTurnScale);
    motion.by_extra.leftCols<4>() =
        node.by_wheels * right_jacobian(u) * motion::wheel_step(counted).by_numbers.leftCols<4>();
  }
  if (!node.new_piece) return motion;
  const double sigma = sigma_of(fixes_[node.fix]);
  motion.keep.tail<2>().setZero();
  motion.extra_noise.tail<2>().setConstant(sigma * sigma / slow_weight(verdicts_[node.fix].piece));
  return motion;
}

}  // namespace majak::localize
