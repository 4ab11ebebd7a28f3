// SPDX-License-Identifier: Apache-2.0
// The Kalman filter's pass over its nodes, and the smoother: Gauss and Newton over the whole path.
#include <algorithm>
#include <cmath>
#include <limits>

#include "majak/localize/kalman.hpp"

namespace majak::localize {
namespace {

constexpr double kStudent = 4;  // degrees of freedom of the fixes' errors
constexpr double kLeastSlowWeight = 0.2;
constexpr std::size_t kPieces = 5;
constexpr double kNoGate = 1e9;
constexpr int kRoundsPerStage = 30;
constexpr double kSettled = 0.3;    // m, before fixes are weighed by how well they fit
constexpr double kMostTurn = 0.5;   // rad, by which a round may turn the path
constexpr double kTurnApart = 0.4;  // rad between stretches that are tried
constexpr double kBendSigmas = 2.5, kMostTries = 20;

}  // namespace

// `linear`: the equations are made linear at the smoothed state of the round before.
void Kalman::filter_node(std::size_t k, bool linear, double gate, std::size_t& piece,
                         std::vector<Innovation>* innovations) {
  Node& node = nodes_[k];
  const bool trusted = node.fix != kNone && verdicts_[node.fix].trusted;
  const std::size_t own_piece = trusted ? verdicts_[node.fix].piece : piece;
  node.new_piece = piece != kNone && own_piece != piece;
  piece = own_piece;
  const State before = node.smoothed.nominal;
  if (k == 0) {
    node.predicted = beginning();
    if (linear) {
      node.predicted.mean = node.predicted.nominal.minus(before);
      node.predicted.nominal = before;
    }
  } else {
    node.predicted = nodes_[k - 1].filtered;
    node.predicted.predict(motion_to(k, linear), linear ? &before : nullptr);
  }
  node.filtered = node.predicted;
  if (trusted) {
    const auto z = see(fixes_[node.fix], weights_[node.fix], node.filtered.nominal);
    const auto done = node.filtered.correct(z, gate);
    cost_ += done.nis + done.log_det;
    if (innovations) innovations->push_back({node.time, "gps", done.nis, 2, done.share == 1});
  }
  for (const BeaconSighting& s : node.seen) see(s, gate, node.filtered, innovations);
  if (!linear) node.filtered.settle();
}

// One round of Gauss and Newton over all nodes: filter forth, smoother back, about the nominal
// path; then the path moves, by no more than the equations can be trusted. Returns how far it would
// have.
double Kalman::round() {
  std::size_t piece = kNone;
  cost_ = 0;
  for (std::size_t k = 0; k < nodes_.size(); ++k) filter_node(k, true, kNoGate, piece, nullptr);
  double moved = 0, turned = 0;
  for (std::size_t k = nodes_.size(); k-- > 0;) {
    Node& node = nodes_[k];
    node.smoothed = node.filtered;
    if (k + 1 < nodes_.size())
      node.smoothed = filter::smooth(node.filtered, nodes_[k + 1].predicted, motion_to(k + 1, true),
                                     nodes_[k + 1].smoothed);
    moved = std::max(moved, node.smoothed.mean.head<2>().norm());
    turned = std::max(turned, std::abs(node.smoothed.mean(2)));
  }
  const double share = std::min(1.0, kMostTurn / std::max(turned, 1e-12));
  for (Node& node : nodes_) {
    node.smoothed.mean *= share;
    node.smoothed.settle();
  }
  return moved;
}

// Where the path is not smoothed yet, the nominal one is that of the wheels, `bend` added to what
// straight ahead turns.
void Kalman::extend(std::size_t from, double bend) {
  for (std::size_t k = from; k < nodes_.size(); ++k) {
    State& nominal = nodes_[k].smoothed.nominal;
    nominal =
        k == 0 ? beginning().nominal : motion_to(k, false).apply(nodes_[k - 1].smoothed.nominal);
    if (k == from) nominal.extra(kTurnOffset) += bend;
  }
}

// Rounds until the path stands still; minus twice the log likelihood of the fixes there.
double Kalman::converge() {
  for (int k = 0; k < kRoundsPerStage && round() > kSettled; ++k) continue;
  return cost_;
}

// Student's t: a fix far from where the others put it counts less, and so does a piece whose slow
// error is large (iteratively reweighted least squares).
void Kalman::weigh() {
  std::size_t piece = kNone;
  // With few pieces nothing tells a slow error from the path: freed, they slide away together.
  const bool few = verdicts_.empty() || verdicts_.back().piece + 1 < kPieces;
  for (const Node& node : nodes_) {
    if (node.fix == kNone || !verdicts_[node.fix].trusted) continue;
    const auto z = see(fixes_[node.fix], 1, node.smoothed.nominal);
    const double squared = z.residual.squaredNorm() / z.noise(0, 0);
    weights_[node.fix] = (kStudent + 2) / (kStudent + squared);
    if (few || verdicts_[node.fix].piece == piece) continue;
    piece = verdicts_[node.fix].piece;
    const double sigma = sigma_of(fixes_[node.fix]);
    const double slow = node.smoothed.nominal.extra.segment<2>(kSlow).squaredNorm();
    slow_weights_.resize(std::max(slow_weights_.size(), piece + 1), 1);
    slow_weights_[piece] =
        std::clamp((kStudent + 2) / (kStudent + slow / (sigma * sigma)), kLeastSlowWeight, 1.0);
  }
}

double Kalman::slow_weight(std::size_t piece) const {
  return piece < slow_weights_.size() ? slow_weights_[piece] : 1;
}

// After an outage the path hangs on the first fix from a lever of its whole length. All that was is
// made linear anew before the next stretch is hung on. Where the wheels' own bend could have wound
// that stretch up, several bends are tried, and the one that the fixes like best is kept.
void Kalman::settle() {
  const std::size_t from = settled_;
  const double way = way_ - settled_way_;
  const double bend_sigma =
      std::sqrt(nodes_.back().predicted.covariance(3 + kTurnOffset, 3 + kTurnOffset));
  const double step = kTurnApart / std::max(way, 1e-3);
  const int tries = static_cast<int>(std::min(kBendSigmas * bend_sigma / step, kMostTries));
  std::vector<State> before, best;
  for (const Node& node : nodes_) before.push_back(node.smoothed.nominal);
  double best_cost = std::numeric_limits<double>::infinity();
  for (int k = -tries; k <= tries; ++k) {
    for (std::size_t i = 0; i < from; ++i) nodes_[i].smoothed.nominal = before[i];
    extend(from, k * step);
    const double cost = converge();
    if (!(cost < best_cost)) continue;
    best_cost = cost;
    best.clear();
    for (const Node& node : nodes_) best.push_back(node.smoothed.nominal);
  }
  if (tries > 0) {
    for (std::size_t i = 0; i < nodes_.size(); ++i) nodes_[i].smoothed.nominal = best[i];
    round();
  }
  settled_ = nodes_.size();
  settled_way_ = way_;
  weigh();
  nodes_.back().filtered = nodes_.back().smoothed;
}

}  // namespace majak::localize
