// SPDX-License-Identifier: Apache-2.0
// Beam model (Thrun, Burgard, Fox 2005, 6.3): what a beam returns where the map lets expect z*. It
// meets the wall there, or something short of it, or nothing, or is anything at all:
//
//   p(z) = hit N(z; z*, sigma) / eta + brief Exp(z; rate) / (1 - exp(-rate z*)) [z <= z*]
//        + random / max_range,        p(no return) = none (+ hit where z* is beyond reach)
//
// Its parameters are learnt from data by expectation maximization, those of the likelihood field
// as well (docs/MATH.md "Monte Carlo localization").
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "majak/map/distance_field.hpp"
#include "majak/match/beams.hpp"
#include "majak/match/likelihood_field.hpp"

namespace majak::match {

struct BeamModel {
  double hit = 0.75, brief = 0.1, none = 0.05, random = 0.1;  ///< shares, sum 1
  double sigma = 0.1;                                         ///< m, of a hit
  double rate = 0.5;                                          ///< 1/m, of what stands in the way
};

/// What a beam measured and what the map let expect, m; infinite: nothing within max_range.
struct BeamPair {
  double measured, expected;
};

/// Density in 1/m of a return, or the probability of none.
double probability(const BeamModel& model, const BeamPair& beam, double max_range);

/// Each beam against the map, seen from T_map_robot; appended to `pairs`.
void expect(const Beams& beams, const map::DistanceField& distances, const Pose2& T_map_robot,
            std::vector<BeamPair>& pairs);

/// Sum over all beams of -log(p / p of a perfect hit), none below 0, in units of
/// LikelihoodField::kUnit nats. A hundred times as dear as the likelihood field.
std::uint32_t cost(const BeamModel& model, const Beams& beams, const map::DistanceField& distances,
                   const Pose2& T_map_robot);

/// Parameters under which the pairs are likeliest, from poses that are known.
BeamModel learn_beam_model(std::span<const BeamPair> pairs, double max_range,
                           const BeamModel& start = {}, int rounds = 50);

/// Shares and sigma of a likelihood field from how far off the map's surfaces returns end (m).
LikelihoodFieldOptions learn_likelihood_field(std::span<const double> distances,
                                              const LikelihoodFieldOptions& start = {},
                                              int rounds = 50);

}  // namespace majak::match
