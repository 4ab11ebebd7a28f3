// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/calibration.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "majak/core/error.hpp"

namespace majak::motion {
namespace {

using Rows = Eigen::Matrix<double, 3, 7>;

constexpr double kGate = 18;         // chi-square, 3 degrees of freedom: 1 in 2000
constexpr double kGross = 0.15;      // m and rad: a step so far off is none
constexpr double kGrossShare = 0.3;  // of the way or turn, added to it
constexpr std::size_t kLeastSteps = 40;
constexpr std::size_t kBlock = 5;    // steps whose scatter is taken together
constexpr double kNearFactor = 1.2;  // of the search for a noise that is known roughly
constexpr int kFirstDropping = 3;
// What the laser's own poses are wrong by, seen over simulated drives: no number of steps tells.
constexpr std::array<double, kUnknowns> kFloor{0.001,  0.0015, 0.0004, 0.0013,
                                               0.0004, 0.0006, 0.001};
// What is usual, where the log does not say; and the sigma below which a value is determined.
constexpr std::array<double, kUnknowns> kUsual{0.1, 0.1, 0.05, 0.3, 0.3, 0.1, 0.3};
constexpr std::array<double, kUnknowns> kUsable{0.02, 0.02, 0.005, 0.03, 0.03, 0.01, 0.03};

/// Where the iteration stands.
struct State {
  DriveCorrection correction;
  Pose2 D;  ///< the laser's true place against the nominal one
  StepNoise noise;
};

// Poses so far apart that the motion between them stands out of the laser's noise.
std::vector<LaserPose> thinned(const std::vector<LaserPose>& laser, const CalibrationOptions& o) {
  std::vector<LaserPose> out;
  for (const LaserPose& pose : laser) {
    if (!out.empty()) {
      const Pose2 step = between(out.back().T_map_robot, pose.T_map_robot);
      if (step.translation().norm() < o.least_way && std::abs(step.theta) < o.least_turn) continue;
      if (o.timed && pose.time <= out.back().time) continue;
    }
    out.push_back(pose);
  }
  return out;
}

bool gross(const SeenStep& step) {
  const Vec3 e = step.error();
  return e.head<2>().norm() > kGross + kGrossShare * step.way ||
         std::abs(e.z()) > kGross + kGrossShare * step.turn;
}

std::vector<SeenStep> compare(const std::vector<LaserPose>& laser,
                              const std::vector<WheelSample>& wheels, const State& state,
                              const CalibrationOptions& o) {
  auto steps = seen_steps(laser, wheels, state.correction, state.D, o.wheelbase);
  for (SeenStep& step : steps) step.broken = step.broken || gross(step);
  return steps;
}

/// How the corrected twist changes with scale, turn scale and unevenness.
Mat3 by_drive(const Vec3& twist, const State& s, const CalibrationOptions& o) {
  const DriveCorrection& c = s.correction;
  const double way = twist.x() / c.scale,
               turn = (twist.z() - c.turn_per_metre * way) / c.turn_scale;
  Mat3 m = Mat3::Zero();
  m.col(0) << way, twist.y() / c.scale, 0;
  m(2, 1) = turn;
  if (o.wheelbase > 0) {
    const double tangent = std::abs(way) > 1e-6 ? turn * o.wheelbase / way : 0;
    m(2, 2) = c.turn_scale * way * (1 + tangent * tangent) / o.wheelbase;
  } else {
    m.col(2) << o.track * o.track * c.scale / (4 * c.turn_scale) * turn, 0, way;
  }
  return m;
}

// The derivative of what the wheels foretell, made of motions that are free of this step's noise:
// smoothed by all that is seen. Made of the wheels' own they would be too long (regression
// dilution).
std::vector<Rows> derivatives(const std::vector<SeenStep>& steps, const WhitenedSteps& white,
                              const State& state, const CalibrationOptions& o) {
  const std::vector<Vec3> errors = white.wheel_errors();
  std::vector<Vec3> twists;
  for (std::size_t i = 0; i < steps.size(); ++i)
    twists.push_back(log(state.D * steps[i].wheels * exp(errors[i]) * state.D.inverse()));
  const Mat3 to_laser = adjoint(state.D.inverse());
  std::vector<Rows> out(steps.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    const Mat3 back = adjoint(exp(-twists[i]));
    out[i].leftCols<3>() = to_laser * right_jacobian(twists[i]) * by_drive(twists[i], state, o);
    out[i].middleCols<3>(3) =
        Mat3::Identity() - adjoint((state.D.inverse() * exp(twists[i]) * state.D).inverse());
    out[i].col(6).setZero();
    if (o.timed)
      out[i].col(6) = to_laser * (velocity_between(twists, steps, i + 1) -
                                  back * velocity_between(twists, steps, i));
  }
  return out;
}

Vec7 off_nominal(const State& s, const CalibrationOptions& o) {
  const DriveCorrection& c = s.correction;
  const Vec3 place = log(s.D);
  Vec7 p;
  p << c.scale - 1, c.turn_scale - 1, o.wheelbase > 0 ? c.steering_offset : c.turn_per_metre,
      place.x(), place.y(), place.z(), 0;  // the lag is held by its start
  return p;
}

void move(State& s, const Vec7& dp, const CalibrationOptions& o) {
  DriveCorrection& c = s.correction;
  c.scale += dp(0), c.turn_scale += dp(1);
  (o.wheelbase > 0 ? c.steering_offset : c.turn_per_metre) += dp(2);
  c.way_per_turn = o.track * o.track * c.scale / (4 * c.turn_scale) * c.turn_per_metre;
  s.D = s.D * exp(dp.segment<3>(3));
  c.lag = std::clamp(c.lag + dp(6), o.start_lag - 0.15, o.start_lag + 0.15);
}

/// Normal equations of whitened rows; `dp` goes to the solution.
struct Solution {
  Vec7 dp;
  Mat7 covariance;
};
Solution solve(const std::vector<Rows>& rows, const WhitenedSteps& white, const State& state,
               const CalibrationOptions& o) {
  Mat7 A = Mat7::Zero(), spread = Mat7::Zero();
  Vec7 b = Vec7::Zero(), block = Vec7::Zero();
  Rows before = Rows::Zero();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Rows turned = white.whiten(i, rows[i], before);
    const Eigen::Matrix<double, 7, 3> weighted = turned.transpose() * white.weight(i);
    const Vec7 score = weighted * white.innovation(i);
    A += weighted * turned, b += score, block += score;
    if ((i + 1) % kBlock == 0 || i + 1 == rows.size()) {
      spread += block * block.transpose();
      block.setZero();
    }
    before = turned;
  }
  Vec7 prior;
  for (std::size_t k = 0; k < kUnknowns; ++k)
    prior(static_cast<int>(k)) = 1 / (kUsual[k] * kUsual[k]);
  A.diagonal() += prior;
  b -= prior.cwiseProduct(off_nominal(state, o));
  const Mat7 inverse = A.inverse();
  // Where the innovations scatter more than the noise says, the larger of both counts.
  const Vec7 scatter = (inverse * spread * inverse).diagonal().cwiseQuotient(inverse.diagonal());
  const Vec7 widen = scatter.cwiseMax(1).cwiseSqrt();
  return {inverse * b, widen.asDiagonal() * inverse * widen.asDiagonal()};
}

void take_evidence(const std::vector<SeenStep>& steps, const WhitenedSteps& white,
                   Calibration& out) {
  out.steps = steps.size(), out.left_out = 0;
  out.way = out.turned = 0;
  double sum = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    out.way += steps[i].way, out.turned += steps[i].turn;
    out.left_out += white.broken(i);
    sum += white.broken(i) ? 0 : white.nis(i);
  }
  out.mean_nis = sum / static_cast<double>(std::max<std::size_t>(out.steps - out.left_out, 1));
  out.log_likelihood = white.log_likelihood();
}

// From the body axes of D, in which the iteration moves, to T_robot_laser.
Mat7 to_mounting(const State& s, const CalibrationOptions& o) {
  Mat7 m = Mat7::Identity();
  const double c = std::cos(s.D.theta), n = std::sin(s.D.theta);
  const Vec2 arm = Pose2{0, 0, s.D.theta} * o.T_robot_laser.translation();
  m.block<3, 3>(3, 3) << c, -n, -arm.y(), n, c, arm.x(), 0, 0, 1;
  return m;
}

void take_values(const State& s, const Mat7& covariance, const CalibrationOptions& o,
                 Calibration& out) {
  const Mat7 m = to_mounting(s, o);
  out.covariance = m * covariance * m.transpose();
  const DriveCorrection& c = s.correction;
  const Pose2 place = s.D * o.T_robot_laser;
  const std::array<double, kUnknowns> values{
      c.scale, c.turn_scale, o.wheelbase > 0 ? c.steering_offset : c.turn_per_metre,
      place.x, place.y,      place.theta,
      c.lag};
  for (std::size_t k = 0; k < kUnknowns; ++k) {
    const auto i = static_cast<int>(k);
    // The steering makes a bend of steering / wheelbase.
    const bool steering = o.wheelbase > 0 && k == static_cast<std::size_t>(Unknown::uneven);
    const double floor = kFloor[k] * (steering ? o.wheelbase : 1);
    out.covariance(i, i) += floor * floor;
    const double sigma = std::sqrt(out.covariance(i, i));
    out.values[k] = {values[k], sigma, sigma < kUsable[k]};
  }
  if (!o.timed) out.values[6] = {0, kUsual[6], false};
}

// Track or wheelbase, and the difference of the wheels: b' = b s / g, (r_right - r_left) / r = k b
// / g.
void take_lengths(const CalibrationOptions& o, Calibration& out) {
  const double believed = o.wheelbase > 0 ? o.wheelbase : o.track;
  if (believed <= 0) return;
  const Learnt &s = out.values[0], &g = out.values[1], &k = out.values[2];
  const double variance = s.sigma * s.sigma / (s.value * s.value) +
                          g.sigma * g.sigma / (g.value * g.value) -
                          2 * out.covariance(0, 1) / (s.value * g.value);
  const double length = believed * s.value / g.value;
  out.length = {length, length * std::sqrt(std::max(variance, 0.0)), s.used && g.used};
  if (o.wheelbase > 0) return;
  out.wheel_difference = {k.value * o.track / g.value, k.sigma * o.track / g.value, k.used};
}

void take_correction(const State& s, const CalibrationOptions& o, Calibration& out) {
  const auto value = [&](Unknown u, double nominal) {
    return out[u].used ? out[u].value : nominal;
  };
  DriveCorrection& c = out.correction;
  c.wheelbase = o.wheelbase;
  c.lag = value(Unknown::lag, 0);
  c.scale = value(Unknown::scale, 1), c.turn_scale = value(Unknown::turn_scale, 1);
  (o.wheelbase > 0 ? c.steering_offset : c.turn_per_metre) = value(Unknown::uneven, 0);
  if (out[Unknown::uneven].used) c.way_per_turn = s.correction.way_per_turn;
  const Pose2& nominal = o.T_robot_laser;
  c.laser_x = value(Unknown::laser_x, nominal.x);
  c.laser_y = value(Unknown::laser_y, nominal.y);
  c.laser_theta = value(Unknown::laser_theta, nominal.theta);
  c.mounting =
      out[Unknown::laser_x].used || out[Unknown::laser_y].used || out[Unknown::laser_theta].used;
}

void say_what_is_not_told(const CalibrationOptions& o, Calibration& out) {
  const auto missing = [&](Unknown u) { return !out[u].used; };
  const auto say = [&](const char* text) { out.not_told.emplace_back(text); };
  if (out.contradicted())
    return say(
        "anything: more than a quarter of the steps contradict the wheels; look at the map of this "
        "log first (majak map), its poses do not hold");
  if (missing(Unknown::scale)) say("scale of ways: drive ten metres and more past things to see");
  if (missing(Unknown::turn_scale))
    say("scale of turns: turn by several full circles, to both sides");
  if (missing(Unknown::uneven))
    say(o.wheelbase > 0 ? "offset of the steering: drive straight on for some ten metres"
                        : "difference of the wheels: drive straight on for some ten metres");
  if (missing(Unknown::laser_x) || missing(Unknown::laser_y))
    say("place of the laser: turn by several full circles, on the spot where the robot can");
  if (missing(Unknown::laser_theta)) say("heading of the laser: drive straight on");
  if (missing(Unknown::lag))
    say(o.timed ? "time offset: drive off, brake and turn again and again"
                : "time offset: the stamps of this log do not tell when its scans were taken");
  if (o.wheelbase <= 0 && o.track <= 0)
    say("wheel difference in per cent and the track: tell the track that the odometry believes");
}

// A pose that comes late from laser or wheels spoils the steps to both its sides, one way and the
// other: without it they are one good step. What is bad still then is a slip.
void drop_bad_poses(const std::vector<SeenStep>& steps, const WhitenedSteps& white,
                    std::vector<LaserPose>& poses) {
  std::vector<LaserPose> kept;
  std::size_t step = 0;
  bool dropped = false;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    while (step < steps.size() && steps[step].end < k) ++step;
    const bool bad = step < steps.size() && steps[step].end == k && white.broken(step);
    dropped = bad && !dropped && k + 1 < poses.size();
    if (!dropped) kept.push_back(poses[k]);
  }
  poses = std::move(kept);
}

}  // namespace

Calibration calibrate(const std::vector<LaserPose>& laser, const std::vector<WheelSample>& wheels,
                      const CalibrationOptions& options) {
  std::vector<LaserPose> poses = thinned(laser, options);
  State state;
  state.correction.lag = options.timed ? options.start_lag : 0;
  Calibration out;
  Mat7 covariance = Mat7::Identity();
  for (int round = 0; round < options.rounds; ++round) {
    std::vector<SeenStep> steps = compare(poses, wheels, state, options);
    if (steps.size() < kLeastSteps)
      throw Error("fewer than forty steps that wheels and laser both have seen");
    if (round > 0 && round <= options.rounds / 2) {
      const WhitenedSteps gated(steps, state.noise, kGate);
      for (std::size_t i = 0; i < steps.size(); ++i) steps[i].broken = gated.broken(i);
      state.noise =
          learn_noise(steps, state.noise, {round == 1 ? 2 : kNearFactor, options.noise_factor});
      if (round >= kFirstDropping) {
        drop_bad_poses(steps, WhitenedSteps(steps, state.noise, kGate), poses);
        steps = compare(poses, wheels, state, options);
      }
    }
    const WhitenedSteps white(steps, state.noise, kGate);
    const Solution found = solve(derivatives(steps, white, state, options), white, state, options);
    move(state, found.dp, options);
    covariance = found.covariance;
    take_evidence(steps, white, out);
  }
  out.noise = state.noise;
  take_values(state, covariance, options, out);
  if (out.contradicted())
    for (Learnt& v : out.values) v.used = false;
  take_lengths(options, out);
  take_correction(state, options, out);
  say_what_is_not_told(options, out);
  return out;
}

}  // namespace majak::motion
