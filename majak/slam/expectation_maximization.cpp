// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/expectation_maximization.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <utility>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/slam/chain.hpp"

namespace majak::slam {
namespace {

constexpr std::size_t kMostMisses = 300;  // places of a piece that beams went through

// What key scans [first, last) saw, by squares of `size` m in the frame of `anchor`.
class Squares {
 public:
  Squares(const KeyScans& keys, std::size_t first, std::size_t last, std::size_t anchor,
          double size)
      : size_(size) {
    for (std::size_t k = first; k < last; ++k) {
      const Pose2 T = between(keys[anchor].T_front_robot, keys[k].T_front_robot);
      const match::ScanPoints& points = keys[k].points;
      const Vec2 laser = T * points.laser;
      for (std::size_t i = 0; i < points.size(); ++i)
        add(laser, T * Vec2(points.x[i], points.y[i]));
    }
  }

  Piece piece(RandomStream random) const {
    Piece piece;
    std::vector<Vec2> misses;
    for (const Square& s : squares_) {
      if (s.hits > 0) {
        piece.x.push_back(static_cast<float>(s.sum.x() / s.hits));
        piece.y.push_back(static_cast<float>(s.sum.y() / s.hits));
      } else if (!beside_hit(s)) {
        misses.push_back(size_ * Vec2(s.x + 0.5, s.y + 0.5));
      }
    }
    piece.hits = piece.x.size();
    const std::size_t kept = std::min(misses.size(), kMostMisses);
    for (std::size_t i = 0; i < kept; ++i) {
      std::swap(misses[i], misses[i + random.below(misses.size() - i)]);
      piece.x.push_back(static_cast<float>(misses[i].x()));
      piece.y.push_back(static_cast<float>(misses[i].y()));
    }
    if (kept > 0)
      piece.miss_weight = static_cast<double>(misses.size()) / static_cast<double>(kept);
    return piece;
  }

 private:
  struct Square {
    std::int64_t x = 0, y = 0;
    Vec2 sum = Vec2::Zero();
    double hits = 0;
  };
  std::int64_t index(double v) const { return static_cast<std::int64_t>(std::floor(v / size_)); }
  static std::int64_t number(std::int64_t x, std::int64_t y) { return x * 0x40000000 + y; }
  Square& at(const Vec2& p) {
    const std::int64_t x = index(p.x()), y = index(p.y());
    const auto [found, fresh] = at_.try_emplace(number(x, y), squares_.size());
    if (fresh) squares_.push_back({x, y, Vec2::Zero(), 0});
    return squares_[found->second];
  }
  void add(const Vec2& laser, const Vec2& end) {
    const Vec2 way = end - laser;
    const int steps = static_cast<int>(way.norm() / (0.5 * size_));
    for (int i = 0; i < steps; ++i) at(laser + way * (static_cast<double>(i) / steps));
    Square& last = at(end);
    last.sum += end, last.hits += 1;
  }
  bool beside_hit(const Square& s) const {
    for (std::int64_t dx = -1; dx <= 1; ++dx)
      for (std::int64_t dy = -1; dy <= 1; ++dy) {
        const auto found = at_.find(number(s.x + dx, s.y + dy));
        if (found != at_.end() && squares_[found->second].hits > 0) return true;
      }
    return false;
  }

  double size_;
  std::vector<Square> squares_;
  std::unordered_map<std::int64_t, std::size_t> at_;
};

Pose2 moved_at_random(const Pose2& pose, const Mat3& covariance, RandomStream& random) {
  const Vec3 white(random.normal(), random.normal(), random.normal());
  return pose * exp(covariance.llt().matrixL() * white);
}

std::size_t most_likely(const std::vector<double>& probability) {
  return static_cast<std::size_t>(std::max_element(probability.begin(), probability.end()) -
                                  probability.begin());
}

std::size_t drawn(const std::vector<double>& probability, RandomStream& random) {
  double left = random.uniform();
  for (std::size_t s = 0; s < probability.size(); ++s)
    if ((left -= probability[s]) < 0) return s;
  return most_likely(probability);
}

std::size_t bytes(const HitMap& map) {
  return map.log_hit.size() * sizeof(float) + map.log_miss.size() * sizeof(float);
}

std::size_t bytes(const HiddenPoses& hidden) {
  std::size_t sum = 0;
  for (const auto& support : hidden.supports)
    sum += support.size() * (sizeof(Pose2) + sizeof(double));
  for (const Transitions& step : hidden.steps) sum += step.to.size() * 8 + step.row.size() * 4;
  return sum;
}

}  // namespace

ExpectationMaximization::ExpectationMaximization(const ScanChainOptions& chain,
                                                 const ExpectationMaximizationOptions& options,
                                                 Threads threads)
    : options_(options), threads_(threads), chain_(chain) {}

std::optional<Estimate> ExpectationMaximization::add(Event event) {
  chain_.add(std::move(event));
  while (chain_.next()) chain_.settle();
  return std::nullopt;
}

// A piece ends after some metres, and where the front end does not trust itself.
void ExpectationMaximization::cut_pieces() {
  const KeyScans& keys = chain_.keys();
  std::size_t first = 0;
  double way = 0;
  begins_.push_back(0);
  const auto end_at = [&](std::size_t last) {
    anchors_.push_back((first + last) / 2);
    first = last, way = 0;
    begins_.push_back(first);
  };
  for (std::size_t k = 1; k < keys.size(); ++k) {
    way += between(keys[k - 1].T_front_robot, keys[k].T_front_robot).translation().norm();
    if (way >= options_.piece_way || keys[k].weak_step) end_at(k);
  }
  end_at(keys.size());
  const double doubt2 = options_.doubt * options_.doubt;
  spread_.push_back(Mat3::Zero());
  for (std::size_t p = 1; p < anchors_.size(); ++p) {
    steps_.push_back(doubt2 * chain_information(keys, anchors_[p - 1], anchors_[p]).inverse());
    const Mat3 back =
        adjoint(between(keys[anchors_[p]].T_front_robot, keys[anchors_[p - 1]].T_front_robot));
    spread_.push_back(back * spread_.back() * back.transpose() + steps_.back());
  }
}

void ExpectationMaximization::see_pieces(double cell) {
  pieces_.resize(anchors_.size());
  parallel_for(threads_, pieces_.size(), [&](std::size_t p) {
    const Squares squares(chain_.keys(), begins_[p], begins_[p + 1], anchors_[p], cell);
    pieces_[p] = squares.piece(RandomStream(static_cast<std::uint64_t>(options_.seed), p));
  });
}

// p(path): every hypothesis follows one of the piece before; the first of all is the front end's.
HiddenPoses ExpectationMaximization::drawn_from_motion() const {
  const KeyScans& keys = chain_.keys();
  HiddenPoses hidden;
  hidden.supports.push_back({keys[anchors_[0]].T_front_robot});
  for (std::size_t p = 1; p < anchors_.size(); ++p) {
    const Pose2 T = between(keys[anchors_[p - 1]].T_front_robot, keys[anchors_[p]].T_front_robot);
    const std::vector<Pose2>& before = hidden.supports.back();
    std::vector<Pose2> support{before[0] * T};
    for (std::size_t s = 1; s < static_cast<std::size_t>(options_.hypotheses); ++s) {
      RandomStream random(static_cast<std::uint64_t>(options_.seed), p, s);
      support.push_back(moved_at_random(before[s % before.size()] * T, steps_[p - 1], random));
    }
    hidden.supports.push_back(std::move(support));
  }
  connect(hidden, options_.shrink);
  return hidden;
}

// Hypotheses about those that are likely, apart by what separated them there.
HiddenPoses ExpectationMaximization::drawn_from(const HiddenPoses& hidden,
                                                const HiddenPosterior& posterior, int level) const {
  const double spread = std::pow(options_.shrink, level);
  HiddenPoses next;
  next.supports.push_back(hidden.supports[0]);
  for (std::size_t p = 1; p < anchors_.size(); ++p) {
    const std::vector<double>& probability = posterior.probability[p];
    const Mat3 covariance = spread * spread * spread_[p];
    std::vector<Pose2> support{hidden.supports[p][most_likely(probability)]};
    for (std::size_t s = 1; s < static_cast<std::size_t>(options_.hypotheses); ++s) {
      RandomStream random(static_cast<std::uint64_t>(options_.seed),
                          static_cast<std::uint64_t>(level) * 0x100000000ULL + p, s);
      const Pose2& about = hidden.supports[p][drawn(probability, random)];
      support.push_back(moved_at_random(about, covariance, random));
    }
    next.supports.push_back(std::move(support));
  }
  connect(next, spread * options_.shrink);
  return next;
}

// The motion model, blurred by how far apart hypotheses are.
void ExpectationMaximization::connect(HiddenPoses& hidden, double spread) const {
  const KeyScans& keys = chain_.keys();
  hidden.steps.resize(hidden.supports.size() - 1);
  parallel_for(threads_, hidden.steps.size(), [&](std::size_t p) {
    const Pose2 T = between(keys[anchors_[p]].T_front_robot, keys[anchors_[p + 1]].T_front_robot);
    hidden.steps[p] = transitions(hidden.supports[p], hidden.supports[p + 1], T,
                                  steps_[p] + spread * spread * spread_[p + 1]);
  });
}

HiddenPosterior ExpectationMaximization::climb(const HiddenPoses& hidden, HiddenPosterior posterior,
                                               double cell, Mapping& mapping) const {
  std::vector<double>& series = mapping.log_likelihoods.emplace_back();
  const HitMapOptions options{cell, options_.hits, options_.misses, options_.weight};
  for (int round = 0; round < options_.rounds; ++round) {
    const HitMap map = maximise(pieces_, hidden, posterior.probability, options);
    posterior = forward_backward(hidden, log_likelihoods(pieces_, hidden, map, options, threads_));
    series.push_back(posterior.log_evidence + map.log_prior);
    mapping.belief_bytes = std::max(mapping.belief_bytes, bytes(hidden) + bytes(map));
    const std::size_t n = series.size();
    if (n > 1 && series[n - 1] - series[n - 2] < options_.gain) break;
  }
  return posterior;
}

// Every key scan hangs on its piece; between the anchors of two pieces, on both.
void ExpectationMaximization::hang_keys(const std::vector<Pose2>& poses) {
  KeyScans& keys = chain_.keys();
  const auto seen_from = [&](std::size_t p, std::size_t k) {
    return poses[p] * between(keys[anchors_[p]].T_front_robot, keys[k].T_front_robot);
  };
  std::size_t p = 0;
  for (std::size_t k = 0; k < keys.size(); ++k) {
    while (p + 1 < anchors_.size() && anchors_[p + 1] <= k) ++p;
    keys[k].T_map_robot = seen_from(p, k);
    if (k < anchors_[p] || p + 1 == anchors_.size()) continue;
    const double passed =
        static_cast<double>(k - anchors_[p]) / static_cast<double>(anchors_[p + 1] - anchors_[p]);
    keys[k].T_map_robot = interpolate(keys[k].T_map_robot, seen_from(p + 1, k), passed);
  }
}

// Coarse to fine: new hypotheses and smaller cells; each level begins with all its hypotheses
// equally likely. The most likely poses of the last.
std::vector<Pose2> ExpectationMaximization::most_likely_poses(Mapping& mapping) {
  HiddenPoses hidden = drawn_from_motion();
  HiddenPosterior posterior;
  for (int level = 0; level < options_.levels; ++level) {
    if (level > 0) hidden = drawn_from(hidden, posterior, level);
    HiddenPosterior begin;
    for (const auto& support : hidden.supports)
      begin.probability.emplace_back(support.size(), 1.0 / static_cast<double>(support.size()));
    const double cell = std::max(options_.finest, options_.coarsest * std::pow(0.5, level));
    see_pieces(cell);
    posterior = climb(hidden, std::move(begin), cell, mapping);
  }
  std::vector<Pose2> poses;
  for (std::size_t p = 0; p < pieces_.size(); ++p)
    poses.push_back(hidden.supports[p][most_likely(posterior.probability[p])]);
  return poses;
}

Mapping ExpectationMaximization::finish() {
  chain_.end();
  while (chain_.next()) chain_.settle();
  require_keys(chain_.keys());
  const auto& scans = chain_.site().scans;
  if (std::none_of(scans.begin(), scans.end(),
                   [](const PosedScan& s) { return s.T_odom_robot.has_value(); }))
    throw Error(
        "expectation maximisation needs odometry: it draws its poses from the robot's motion");
  cut_pieces();
  Mapping mapping;
  hang_keys(most_likely_poses(mapping));
  for (const KeyScan& key : chain_.keys()) mapping.belief_bytes += bytes(key);
  if (options_.refine) align_pairs(chain_.keys(), options_.refinement, threads_);
  chain_.hang_all(threads_);
  mapping.site = chain_.finish();
  return mapping;
}

void describe(OptionFields& f, ExpectationMaximizationOptions& o) {
  f.add("em.seed", o.seed, {"1", "of the hypotheses drawn", 0, 1000000000});
  f.add("em.piece_way", o.piece_way, {"m", "driven within a piece", 0.1, 100});
  f.add("em.hypotheses", o.hypotheses, {"1", "of the pose of each piece", 1, 100000});
  f.add("em.doubt", o.doubt, {"1", "times the motion model's standard deviations", 0.1, 100});
  f.add("em.shrink", o.shrink, {"1", "of the hypotheses' spread, level by level", 0.01, 1});
  f.add("em.levels", o.levels, {"1", "each with new hypotheses and finer cells", 1, 20});
  f.add("em.coarsest", o.coarsest, {"m", "cells of the first level", 0.02, 10});
  f.add("em.finest", o.finest, {"m", "smallest cells", 0.02, 10});
  f.add("em.rounds", o.rounds, {"1", "E- and M-steps of a level, at most", 1, 10000});
  f.add("em.gain", o.gain, {"1", "of log likelihood, below which a level ends", 0, 1000});
  f.add("em.hits", o.hits, {"1", "of every cell beforehand", 1e-6, 10});
  f.add("em.misses", o.misses, {"1", "of every cell beforehand", 1e-6, 10});
  f.add("em.refine", o.refine,
        {"", "false: poses are left as expectation maximisation found them"});
  f.add("em.weight", o.weight, {"1", "of a point: neighbours share their errors", 1e-3, 1});
}

}  // namespace majak::slam
