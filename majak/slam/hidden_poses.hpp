// SPDX-License-Identifier: Apache-2.0
// The two steps of expectation maximisation over poses (docs/MATH.md, "Expectation maximisation"):
// of a chain of hidden poses, each with finitely many hypotheses, the posterior given a map; and
// the map of highest likelihood given that posterior. Both are exact and in closed form, so that
// the likelihood never falls from one round to the next.
#pragma once

#include <cstdint>
#include <vector>

#include "majak/core/parallel.hpp"
#include "majak/core/pose2.hpp"

namespace majak::slam {

/// p(pose t of the next piece | pose s of this one): rows by s, each sums to one.
struct Transitions {
  std::vector<std::uint32_t> row;  ///< where each row begins, and the end of the last
  std::vector<std::uint32_t> to;
  std::vector<float> probability;
};

/// Gaussian of the relative pose, of which each row is normalised; what is e^-9 times as
/// likely as the row's most likely, or less, is left out. `covariance`: in the axes of the pose
/// reached.
Transitions transitions(const std::vector<Pose2>& from, const std::vector<Pose2>& to,
                        const Pose2& T_from_to, const Mat3& covariance);

/// The hypotheses of every hidden pose, and how one leads to the next. The first pose's are equally
/// likely.
struct HiddenPoses {
  std::vector<std::vector<Pose2>> supports;
  std::vector<Transitions> steps;  ///< one fewer
};

/// A number for every hypothesis of every pose.
using PerHypothesis = std::vector<std::vector<double>>;

struct HiddenPosterior {
  PerHypothesis probability;  ///< those of a pose sum to one
  double log_evidence = 0;    ///< of everything, summed over all paths
};

/// Forward and backward over the chain.
HiddenPosterior forward_backward(const HiddenPoses& hidden, const PerHypothesis& log_likelihood);

/// What was seen from one hidden pose, as places in its frame (m): first those where returns end,
/// then those that beams went through.
struct Piece {
  std::vector<float> x, y;
  std::size_t hits = 0;    ///< places of the first kind
  double miss_weight = 1;  ///< what one of the others stands for
};

/// For every cell the probability that something is there, as logarithms of it and of its
/// complement.
struct HitMap {
  double cell = 0.2;      ///< m
  double x0 = 0, y0 = 0;  ///< m, corner
  int width = 0, height = 0;
  std::vector<float> log_hit, log_miss;  ///< row by row
  double log_prior = 0;                  ///< of all cells, up to a constant
};

struct HitMapOptions {
  double cell = 0.2;    ///< m
  double hits = 0.05;   ///< that every cell is thought to have had beforehand
  double misses = 0.2;  ///< the same
  double weight = 0.3;  ///< of a place: neighbours share their errors
};

/// M-step: the map under which what is expected by the posterior is most likely.
HitMap maximise(const std::vector<Piece>& pieces, const HiddenPoses& hidden,
                const PerHypothesis& probability, const HitMapOptions& options);

/// log p(piece | pose, map) of every hypothesis.
PerHypothesis log_likelihoods(const std::vector<Piece>& pieces, const HiddenPoses& hidden,
                              const HitMap& map, const HitMapOptions& options, Threads threads);

}  // namespace majak::slam
