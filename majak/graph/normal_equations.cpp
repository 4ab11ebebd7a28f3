// SPDX-License-Identifier: Apache-2.0
#include "majak/graph/normal_equations.hpp"

#include <algorithm>

namespace majak::graph {

void NormalEquations::set(const PoseGraph& graph) {
  bool same = poses_ == graph.poses.size() && fixed_ == graph.fixed &&
              terms_.size() == graph.edges.size() && poses_ > 0;
  for (std::size_t k = 0; same && k < terms_.size(); ++k)
    same = terms_[k].from == graph.edges[k].from && terms_[k].to == graph.edges[k].to;
  if (!same) analyze(graph);

  for (std::size_t k = 0; k < terms_.size(); ++k) {
    const Edge& e = graph.edges[k];
    Term& t = terms_[k];
    const Mat3& o = e.information;
    t.angle = e.T_from_to.theta;
    t.c = std::cos(t.angle);
    t.s = std::sin(t.angle);
    t.x = t.c * e.T_from_to.x + t.s * e.T_from_to.y;
    t.y = -t.s * e.T_from_to.x + t.c * e.T_from_to.y;
    t.xx = o(0, 0), t.yy = o(1, 1), t.tt = o(2, 2);
    t.xy = o(0, 1), t.xt = o(0, 2), t.yt = o(1, 2);
  }
}

void NormalEquations::analyze(const PoseGraph& graph) {
  poses_ = graph.poses.size();
  fixed_ = graph.fixed;
  anchors_ = graph::anchors(graph);
  const int free = static_cast<int>(poses_ - anchors_.size());
  variable_.assign(poses_, -1);
  for (const int a : anchors_) variable_[a] = free;
  for (int next = 0; int& v : variable_)
    if (v < 0) v = next++;

  terms_.resize(graph.edges.size());
  std::vector<BlockCholesky::Pair> pairs(terms_.size());
  for (std::size_t k = 0; k < terms_.size(); ++k) {
    terms_[k].from = graph.edges[k].from;
    terms_[k].to = graph.edges[k].to;
    pairs[k] = {variable_[terms_[k].from], variable_[terms_[k].to]};
  }
  const auto slots = matrix_.analyze(free, pairs);
  for (std::size_t k = 0; k < terms_.size(); ++k) terms_[k].slot = slots[k];
  b_.assign(3 * (static_cast<std::size_t>(free) + 1), 0.0);
}

int NormalEquations::degrees_of_freedom() const {
  return 3 * (static_cast<int>(terms_.size()) - matrix_.size());
}

void NormalEquations::turn_poses(std::span<const Pose2> poses) {
  turns_.resize(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i)
    turns_[i] = {std::cos(poses[i].theta), std::sin(poses[i].theta)};
}

/// MATH 2.4: error and information turned by the heading of `from` plus the measured angle, which
/// leaves e' Omega e as it is and makes the derivative by `to` the identity.
NormalEquations::Local NormalEquations::local(const Term& t, std::span<const Pose2> poses) const {
  const Turn& f = turns_[t.from];
  const double c = f.c * t.c - f.s * t.s, s = f.s * t.c + f.c * t.s;
  const Pose2 &from = poses[t.from], &to = poses[t.to];
  Local l;
  l.dx = to.x - from.x;
  l.dy = to.y - from.y;
  l.rx = l.dx - (c * t.x - s * t.y);
  l.ry = l.dy - (s * t.x + c * t.y);
  l.rt = angle_diff(angle_diff(to.theta, from.theta), t.angle);
  const double cc = c * c, ss = s * s, cs = c * s;
  l.xx = cc * t.xx - 2 * cs * t.xy + ss * t.yy;
  l.yy = ss * t.xx + 2 * cs * t.xy + cc * t.yy;
  l.xy = cs * (t.xx - t.yy) + (cc - ss) * t.xy;
  l.xt = c * t.xt - s * t.yt;
  l.yt = s * t.xt + c * t.yt;
  l.tt = t.tt;
  return l;
}

double NormalEquations::linearize(std::span<const Pose2> poses, std::span<const double> weights) {
  return linearize(poses, weights, false);
}

double NormalEquations::linearize_positions(std::span<const Pose2> poses,
                                            std::span<const double> weights) {
  return linearize(poses, weights, true);
}

double NormalEquations::linearize(std::span<const Pose2> poses, std::span<const double> weights,
                                  bool positions) {
  turn_poses(poses);
  matrix_.set_zero();
  std::fill(b_.begin(), b_.end(), 0.0);
  double sum = 0;
  for (std::size_t k = 0; k < terms_.size(); ++k) {
    const Term& t = terms_[k];
    Local l = local(t, poses);
    if (!weights.empty()) {
      const double w = weights[k];
      l.xx *= w, l.xy *= w, l.yy *= w, l.xt *= w, l.yt *= w, l.tt *= w;
    }
    // J_to = I, J_from = -[I, g; 0, 1] with g = (-dy, dx).
    const double gx = positions ? l.ry - l.dy : -l.dy, gy = positions ? l.dx - l.rx : l.dx;
    const double qx = l.xx * l.rx + l.xy * l.ry + l.xt * l.rt;
    const double qy = l.xy * l.rx + l.yy * l.ry + l.yt * l.rt;
    const double qt = l.xt * l.rx + l.yt * l.ry + l.tt * l.rt;
    const double ux = l.xx * gx + l.xy * gy + l.xt;  // last column of Omega * [I, g; 0, 1]
    const double uy = l.xy * gx + l.yy * gy + l.yt;
    const double ut = l.xt * gx + l.yt * gy + l.tt;
    sum += l.rx * qx + l.ry * qy + l.rt * qt;

    const int vf = variable_[t.from], vt = variable_[t.to];
    double* bt = &b_[3 * vt];
    bt[0] -= qx, bt[1] -= qy, bt[2] -= qt;
    double* bf = &b_[3 * vf];
    bf[0] += qx, bf[1] += qy, bf[2] += gx * qx + gy * qy + qt;

    double* ht = matrix_.diagonal(vt);
    ht[0] += l.xx, ht[1] += l.xy, ht[2] += l.xt, ht[4] += l.yy, ht[5] += l.yt, ht[8] += l.tt;
    double* hf = matrix_.diagonal(vf);
    hf[0] += l.xx, hf[1] += l.xy, hf[2] += ux, hf[4] += l.yy, hf[5] += uy;
    hf[8] += gx * ux + gy * uy + ut;
    // H(to, from) = -Omega * [I, g; 0, 1], column-major; stored the other way round if from > to.
    double* h = matrix_.block(t.slot);
    if (t.slot.transposed) {
      h[0] -= l.xx, h[1] -= l.xy, h[2] -= l.xt, h[3] -= l.xy, h[4] -= l.yy, h[5] -= l.yt;
      h[6] -= ux, h[7] -= uy, h[8] -= ut;
    } else {
      h[0] -= l.xx, h[1] -= l.xy, h[2] -= ux, h[3] -= l.xy, h[4] -= l.yy, h[5] -= uy;
      h[6] -= l.xt, h[7] -= l.yt, h[8] -= ut;
    }
  }
  return sum;
}

void NormalEquations::build_rotations(std::span<const Pose2> poses,
                                      std::span<const double> weights) {
  turn_poses(poses);
  matrix_.set_zero();
  std::fill(b_.begin(), b_.end(), 0.0);
  const int free = matrix_.size();
  for (int v = 0; v < free; ++v) matrix_.diagonal(v)[8] = 1;  // the third number is not used
  for (std::size_t k = 0; k < terms_.size(); ++k) {
    const Term& t = terms_[k];
    const double w = t.tt * (weights.empty() ? 1.0 : weights[k]);
    const int vf = variable_[t.from], vt = variable_[t.to];
    for (const int v : {vf, vt}) matrix_.diagonal(v)[0] += w, matrix_.diagonal(v)[4] += w;
    // H(to, from) = -w R(angle)
    double* h = matrix_.block(t.slot);
    const double s = t.slot.transposed ? -t.s : t.s;
    h[0] -= w * t.c, h[3] -= w * s, h[1] += w * s, h[4] -= w * t.c;
    if (vf == free) {
      const Turn z = turns_[t.from];
      b_[3 * vt] += w * (t.c * z.c - t.s * z.s), b_[3 * vt + 1] += w * (t.s * z.c + t.c * z.s);
    } else if (vt == free) {
      const Turn z = turns_[t.to];
      b_[3 * vf] += w * (t.c * z.c + t.s * z.s), b_[3 * vf + 1] += w * (t.c * z.s - t.s * z.c);
    }
  }
}

bool NormalEquations::solve(double damping, std::vector<double>& dx) {
  if (!matrix_.factor(damping)) return false;
  solution_.assign(b_.begin(), b_.end() - 3);
  matrix_.solve(solution_);
  dx.resize(3 * poses_);
  for (std::size_t i = 0; i < poses_; ++i) {
    const bool fixed = variable_[i] == matrix_.size();
    for (int r = 0; r < 3; ++r) dx[3 * i + r] = fixed ? 0.0 : solution_[3 * variable_[i] + r];
  }
  return true;
}

double NormalEquations::predicted_decrease(std::span<const double> dx, double damping) const {
  // chi2(0) - chi2(dx) = 2 b'dx - dx'H dx, and dx'H dx = b'dx - damping dx'D dx.
  double linear = 0, damped = 0;
  for (std::size_t i = 0; i < poses_; ++i) {
    const int v = variable_[i];
    if (v == matrix_.size()) continue;
    for (int r = 0; r < 3; ++r) {
      const double d = dx[3 * i + r];
      linear += b_[3 * v + r] * d;
      damped += matrix_.diagonal(v)[4 * r] * d * d;
    }
  }
  return linear + damping * damped;
}

void NormalEquations::edge_chi2(std::span<const Pose2> poses, std::span<double> result) {
  turn_poses(poses);
  for (std::size_t k = 0; k < terms_.size(); ++k) {
    const Local l = local(terms_[k], poses);
    result[k] = l.rx * (l.xx * l.rx + 2 * (l.xy * l.ry + l.xt * l.rt)) +
                l.ry * (l.yy * l.ry + 2 * l.yt * l.rt) + l.rt * l.tt * l.rt;
  }
}

double NormalEquations::weighted_chi2(std::span<const Pose2> poses,
                                      std::span<const double> weights) {
  turn_poses(poses);
  double sum = 0;
  for (std::size_t k = 0; k < terms_.size(); ++k) {
    const Local l = local(terms_[k], poses);
    const double chi2 = l.rx * (l.xx * l.rx + 2 * (l.xy * l.ry + l.xt * l.rt)) +
                        l.ry * (l.yy * l.ry + 2 * l.yt * l.rt) + l.rt * l.tt * l.rt;
    sum += weights.empty() ? chi2 : weights[k] * chi2;
  }
  return sum;
}

}  // namespace majak::graph
