// SPDX-License-Identifier: Apache-2.0
// PoseFilter: the extended Kalman filter on SE(2), for a pose and `Extra` further numbers (biases,
// calibration) that are learnt beside it, and the fixed-interval smoother that goes with it.
//
// Errors live in the tangent space at a nominal state: T = T_nominal exp(xi), extra = nominal + d,
// e = (xi, d). An error in the robot's own axes is carried on by Ad(T_from_to^-1) whatever the pose
// is, so a heading that is not known yet bends the ellipse, but not the equations (Barfoot 2017,
// section 7.2; Barrau and Bonnabel 2017). Relative information predicts, absolute corrects
// (docs/MATH.md "Kalman filter").
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "majak/core/pose2.hpp"

namespace majak::filter {

template <int Extra>
struct PoseState {
  static constexpr int kSize = 3 + Extra;
  using Vector = Eigen::Matrix<double, kSize, 1>;
  using Matrix = Eigen::Matrix<double, kSize, kSize>;

  Pose2 T_map_robot;
  Eigen::Matrix<double, Extra, 1> extra = Eigen::Matrix<double, Extra, 1>::Zero();

  /// The state whose error against this one is e.
  PoseState plus(const Vector& e) const {
    return {T_map_robot * exp(e.template head<3>()), extra + e.template tail<Extra>()};
  }
  /// The error e with nominal.plus(e) == *this.
  Vector minus(const PoseState& nominal) const {
    Vector e;
    e << log(between(nominal.T_map_robot, T_map_robot)), extra - nominal.extra;
    return e;
  }
};

/// Relative information: how the robot moved, as its wheels or its laser say, and what becomes of
/// the extra numbers meanwhile. Inputs that follow each other are put together by then().
template <int Extra>
struct RelativeInput {
  using State = PoseState<Extra>;

  Pose2 T_from_to;  ///< with the extra numbers at `at`
  Eigen::Matrix<double, Extra, 1> at = Eigen::Matrix<double, Extra, 1>::Zero();
  /// Derivative of T_from_to by the extra numbers, in the axes of `to`.
  Eigen::Matrix<double, 3, Extra> by_extra = Eigen::Matrix<double, 3, Extra>::Zero();
  Mat3 noise = Mat3::Zero();  ///< covariance of T_from_to, in the axes of `to`
  /// extra_to = keep .* extra_from + noise of this variance.
  Eigen::Matrix<double, Extra, 1> keep = Eigen::Matrix<double, Extra, 1>::Ones();
  Eigen::Matrix<double, Extra, 1> extra_noise = Eigen::Matrix<double, Extra, 1>::Zero();

  /// `next` has its extra numbers at keep .* at. Noise of the extra numbers meanwhile is not felt
  /// by the motion of `next`: numbers that wander have no by_extra, or do so slowly.
  void then(const RelativeInput& next) {
    const Mat3 carry = adjoint(next.T_from_to.inverse());
    T_from_to = T_from_to * next.T_from_to;
    by_extra = carry * by_extra + next.by_extra * keep.asDiagonal();
    noise = carry * noise * carry.transpose() + next.noise;
    keep.array() *= next.keep.array();
    extra_noise = (next.keep.array().square() * extra_noise.array()).matrix() + next.extra_noise;
  }

  State apply(const State& from) const {
    return {from.T_map_robot * T_from_to * exp(by_extra * (from.extra - at)),
            (keep.array() * from.extra.array()).matrix()};
  }
  /// F: error at the end by error at the begin, with these extra numbers there; Q: what is added.
  typename State::Matrix transition(const Eigen::Matrix<double, Extra, 1>& extra) const {
    const Vec3 beside = by_extra * (extra - at);
    typename State::Matrix f = State::Matrix::Zero();
    f.template topLeftCorner<3, 3>() = adjoint((T_from_to * exp(beside)).inverse());
    f.template topRightCorner<3, Extra>() = right_jacobian(beside) * by_extra;
    f.template bottomRightCorner<Extra, Extra>().diagonal() = keep;
    return f;
  }
  typename State::Matrix transition() const { return transition(at); }
  /// The same between nominal states that the motion does not join: the error at `to` in the axes
  /// of `to` itself. Left in those of the foretold state, the turns that the noise made would add
  /// up, and shifting the whole path, which no relative input can notice, would seem measured.
  typename State::Matrix transition(const State& from, const State& to) const {
    typename State::Matrix f = transition(from.extra);
    const Pose2 T_to_foretold = between(to.T_map_robot, apply(from).T_map_robot);
    f.template topRows<3>() = (adjoint(T_to_foretold) * f.template topRows<3>()).eval();
    return f;
  }
  typename State::Matrix added() const {
    typename State::Matrix q = State::Matrix::Zero();
    q.template topLeftCorner<3, 3>() = noise;
    q.template bottomRightCorner<Extra, Extra>().diagonal() = extra_noise;
    return q;
  }
};

/// Absolute information, made linear at a state: residual = z - h(state), H = dh/de there.
template <int Extra, int Dim>
struct AbsoluteInput {
  Eigen::Matrix<double, Dim, 1> residual;
  Eigen::Matrix<double, Dim, 3 + Extra> H;
  Eigen::Matrix<double, Dim, Dim> noise;  ///< R
};

/// What a correction did.
struct Correction {
  double nis = 0;      ///< normalized innovation squared, chi-square with Dim degrees of freedom
  double share = 1;    ///< of the innovation that was believed, 1 within the gate
  double log_det = 0;  ///< of the innovation's covariance as expected
};

/// Mean and covariance of the error against a nominal state.
template <int Extra>
struct PoseBelief {
  using State = PoseState<Extra>;

  State nominal;
  typename State::Vector mean = State::Vector::Zero();
  typename State::Matrix covariance = State::Matrix::Zero();

  State state() const { return nominal.plus(mean); }
  /// Nominal becomes the mean: what the extended filter does after each step.
  void settle() {
    typename State::Matrix turn = State::Matrix::Identity();
    turn.template topLeftCorner<3, 3>() = right_jacobian(mean.template head<3>());
    covariance = (turn * covariance * turn.transpose()).eval();
    nominal = nominal.plus(mean);
    mean.setZero();
  }

  /// Prediction to `to`, the nominal state at the end; the motion's own where there is none better.
  void predict(const RelativeInput<Extra>& motion, const State* to = nullptr) {
    const State foretold = motion.apply(nominal);
    const typename State::Matrix f = motion.transition(nominal, to ? *to : foretold);
    nominal = to ? *to : foretold;
    mean = f * mean;
    if (to) mean += foretold.minus(*to);
    covariance = f * covariance * f.transpose() + motion.added();
    covariance = (0.5 * (covariance + covariance.transpose())).eval();
  }

  /// Correction in Joseph's form, which keeps P symmetric and positive. An innovation beyond
  /// `gate` (in units of the NIS) counts as measured that much worse, so no measurement moves the
  /// estimate by more than sqrt(gate) sigmas.
  template <int Dim>
  Correction correct(const AbsoluteInput<Extra, Dim>& z, double gate) {
    using Square = Eigen::Matrix<double, Dim, Dim>;
    const Eigen::Matrix<double, Dim, 1> innovation = z.residual - z.H * mean;
    Square s = z.H * covariance * z.H.transpose() + z.noise;
    Correction done;
    done.nis = innovation.dot(s.inverse() * innovation);
    done.log_det = std::log(s.determinant());
    Square noise = z.noise;
    if (done.nis > gate) {
      done.share = gate / done.nis;
      noise += s * (1 / done.share - 1);
      s /= done.share;
    }
    const Eigen::Matrix<double, State::kSize, Dim> gain =
        covariance * z.H.transpose() * s.inverse();
    mean += gain * innovation;
    const typename State::Matrix keep = State::Matrix::Identity() - gain * z.H;
    covariance = keep * covariance * keep.transpose() + gain * noise * gain.transpose();
    covariance = (0.5 * (covariance + covariance.transpose())).eval();
    return done;
  }
};

/// One step back of the fixed-interval smoother (Rauch, Tung, Striebel 1965): the belief at a time,
/// given that at the next time. `filtered`: by the filter at this time; `predicted`: from it for
/// the next time, about the nominal
/// state of `next`; `motion` is between them.
template <int Extra>
PoseBelief<Extra> smooth(const PoseBelief<Extra>& filtered, const PoseBelief<Extra>& predicted,
                         const RelativeInput<Extra>& motion, const PoseBelief<Extra>& next) {
  using Matrix = typename PoseState<Extra>::Matrix;
  const Matrix cross = motion.transition(filtered.nominal, predicted.nominal) * filtered.covariance;
  // What does not change has no spread to divide by: the smallest possible regularisation.
  Matrix p = predicted.covariance;
  p.diagonal().array() += 1e-12 * p.diagonal().array().max(1e-12);
  const Matrix gain = p.ldlt().solve(cross).transpose();
  PoseBelief<Extra> smoothed = filtered;
  smoothed.mean += gain * (next.mean - predicted.mean);
  smoothed.covariance += gain * (next.covariance - predicted.covariance) * gain.transpose();
  smoothed.covariance = (0.5 * (smoothed.covariance + smoothed.covariance.transpose())).eval();
  return smoothed;
}

}  // namespace majak::filter
