// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/step_noise.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

namespace majak::motion {
namespace {

constexpr double kLever = 0.2;            // m: a turn on the spot rolls the wheels, too
constexpr double kLeast = 0.0002;         // m and rad, of any step
constexpr double kLow = 1e-4, kHigh = 1;  // what a noise may be
constexpr double kUsualLogSigma = 0.7;
constexpr double kLeastLogDet = -100;

double squared(double x) { return x * x; }
Mat3 floor_of_steps() { return Vec3::Constant(squared(kLeast)).asDiagonal(); }

}  // namespace

Mat3 StepNoise::pose(const Vec3& velocity, const Vec3& doubt) const {
  const Vec3 laser(squared(laser_translation), squared(laser_translation), squared(laser_rotation));
  Mat3 R = squared(jitter) * velocity * velocity.transpose();
  R.diagonal() += laser + doubt.cwiseAbs2();
  return R;
}

Mat3 StepNoise::wheels(double way, double turn) const {
  const double rolled = way + kLever * turn;
  return Vec3(squared(ahead) * rolled, squared(aside) * rolled,
              squared(turn_of_way) * way + squared(turn_of_turn) * turn)
      .asDiagonal();
}

// Cov(e_i) = Q_i + P_i + A P_(i-1) A', Cov(e_i, e_(i-1)) = -A P_(i-1), A = Ad(step^-1), P = R - B
// of the pose between two steps; its L D L' by blocks.
WhitenedSteps::WhitenedSteps(const std::vector<SeenStep>& steps, const StepNoise& noise,
                             double gate) {
  steps_.resize(steps.size());
  for (std::size_t i = 0; i < steps.size(); ++i) {
    steps_[i].error = steps[i].error();
    steps_[i].A = adjoint(steps[i].wheels.inverse());
  }
  weigh(steps, noise, gate);
}

void WhitenedSteps::weigh(const std::vector<SeenStep>& steps, const StepNoise& noise, double gate) {
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const SeenStep& s = steps[i];
    Step& w = steps_[i];
    w.Q = noise.wheels(s.way, s.turn) + floor_of_steps();
    w.B_before = noise.wheels(s.split_way_before, s.split_turn_before);
    w.B_after = noise.wheels(s.split_way_after, s.split_turn_after);
    const Mat3 AR = w.A * (noise.pose(s.velocity_before, s.doubt_before) - w.B_before);
    w.v = w.error;
    w.gain.setZero();
    Mat3 S = w.Q + noise.pose(s.velocity_after, s.doubt_after) - w.B_after + AR * w.A.transpose();
    if (i > 0) {
      w.gain = -AR * steps_[i - 1].S_inverse;
      S += w.gain * AR.transpose();
      w.v -= w.gain * steps_[i - 1].v;
    }
    w.S_inverse = S.inverse();
    w.log_det = std::log(S.determinant());
    w.nis = w.v.dot(w.S_inverse * w.v);
    // Steps shorter than an odometry record can share so much that nothing of their own is left.
    w.broken = s.broken || !(w.nis >= 0 && w.nis <= gate && w.log_det > kLeastLogDet);
    if (w.broken) w.gain.setZero(), w.S_inverse.setZero();  // as if its noise were without bound
  }
}

std::vector<Vec3> WhitenedSteps::wheel_errors() const {
  std::vector<Vec3> lambda(steps_.size() + 1, Vec3::Zero());  // Cov^-1 e
  for (std::size_t i = steps_.size(); i-- > 0;) {
    const Step& s = steps_[i];
    if (s.broken) continue;
    lambda[i] = s.S_inverse * s.v;
    if (i + 1 < steps_.size()) lambda[i] -= steps_[i + 1].gain.transpose() * lambda[i + 1];
  }
  std::vector<Vec3> out(steps_.size(), Vec3::Zero());
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    const Step& s = steps_[i];
    Vec3 after = lambda[i], before = -s.A.transpose() * lambda[i];
    if (i + 1 < steps_.size()) after -= steps_[i + 1].A.transpose() * lambda[i + 1];
    if (i > 0) before += lambda[i - 1];
    out[i] = s.Q * lambda[i] - s.B_after * after + s.A * s.B_before * before;
  }
  return out;
}

double WhitenedSteps::log_likelihood() const {
  double sum = 0;
  for (const Step& s : steps_)
    if (!s.broken) sum -= 0.5 * (s.log_det + s.nis);
  return sum;
}

namespace {

constexpr std::array<double StepNoise::*, 7> kNoises{
    &StepNoise::laser_translation, &StepNoise::laser_rotation, &StepNoise::ahead, &StepNoise::aside,
    &StepNoise::turn_of_way,       &StepNoise::turn_of_turn,   &StepNoise::jitter};

// Twice what is usual, or half of it, is no surprise; a few turns alone do not tell their noise.
double log_posterior(const std::vector<SeenStep>& steps, const StepNoise& noise,
                     WhitenedSteps& white) {
  white.weigh(steps, noise);
  double sum = white.log_likelihood();
  for (const auto value : kNoises)
    sum -= 0.5 * squared(std::log(noise.*value / (StepNoise{}.*value)) / kUsualLogSigma);
  return sum;
}

}  // namespace

StepNoise learn_noise(const std::vector<SeenStep>& steps, const StepNoise& start,
                      const NoiseSearch& search) {
  StepNoise best = start;
  WhitenedSteps white(steps, best);
  double posterior = log_posterior(steps, best, white);
  for (double factor = search.first; factor > search.last; factor = std::sqrt(factor)) {
    for (const auto value : kNoises) {
      const double before = posterior;
      for (const double by : {factor, 1 / factor}) {
        if (posterior > before) break;  // back is worse
        for (bool better = true; better;) {
          StepNoise tried = best;
          tried.*value = std::clamp(tried.*value * by, kLow, kHigh);
          const double found = log_posterior(steps, tried, white);
          better = found > posterior;
          if (better) best = tried, posterior = found;
        }
      }
    }
  }
  return best;
}

}  // namespace majak::motion
