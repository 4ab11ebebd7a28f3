// SPDX-License-Identifier: Apache-2.0
// ScalarKalman: the Kalman filter for one number, as small as it gets. It is an average that
// chooses its own gain: with P, Q and R in balance an exponential one (P = 0.9, Q = 0.1, R = 9 keep
// K = 0.1), never one over a window. Thrun, Burgard, Fox, Probabilistic Robotics, table 3.1.
#pragma once

namespace majak::filter {

struct ScalarKalman {
  double mean = 0;
  double variance = 1;  ///< P, >= 0

  /// Relative information: the number has changed by `change`, with variance Q.
  void predict(double q, double change = 0) {
    mean += change;
    variance += q;  // P = P + Q
  }

  /// Absolute information: y was measured, with variance R. Returns the gain K = P / (P + R) in
  /// [0, 1]; it is 1 where the measurement has no error (R = 0), 0 where nothing is to be learnt.
  double correct(double y, double r) {
    const double k = variance > 0 ? variance / (variance + r) : 0;
    mean += k * (y - mean);
    variance *= 1 - k;  // P = (1 - K) P
    return k;
  }
};

}  // namespace majak::filter
