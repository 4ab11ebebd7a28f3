// SPDX-License-Identifier: Apache-2.0
#include "majak/match/beam_model.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace majak::match {
namespace {

double normal(double off, double sigma) {
  const double d = off / sigma;
  return std::exp(-d * d / 2) / (sigma * std::sqrt(2 * std::numbers::pi));
}

/// Share of the hits' normal distribution that lies in [0, max_range].
double within_reach(double expected, double sigma, double max_range) {
  const double k = 1 / (sigma * std::numbers::sqrt2);
  return 0.5 * (std::erf((max_range - expected) * k) + std::erf(expected * k));
}

/// What each cause adds to the probability of a beam.
struct Causes {
  double hit = 0, brief = 0, none = 0, random = 0;
  double sum() const { return hit + brief + none + random; }
};

Causes causes(const BeamModel& m, const BeamPair& b, double max_range) {
  const bool wall = b.expected < max_range;
  if (!(b.measured < max_range)) return {wall ? 0 : m.hit, 0, m.none, 0};
  Causes c;
  c.random = m.random / max_range;
  if (wall)
    c.hit = m.hit * normal(b.measured - b.expected, m.sigma) /
            std::max(0.01, within_reach(b.expected, m.sigma, max_range));
  const double way = std::min(b.expected, max_range);
  if (b.measured <= way && way > 0)
    c.brief = m.brief * m.rate * std::exp(-m.rate * b.measured) / -std::expm1(-m.rate * way);
  return c;
}

/// The returns that were cut short, each by how likely it was.
struct Shortened {
  double weight, measured, way;
};

// The mean of an exponential cut off at `way` is 1/rate - way / (exp(rate way) - 1); it falls with
// the rate, so the rate whose mean is the data's is found by halving, not far from the last one.
double rate_of(std::span<const Shortened> shortened, double last) {
  const auto excess = [&](double rate) {
    double sum = 0;
    for (const Shortened& s : shortened)
      sum += s.weight * (s.measured - 1 / rate + s.way / std::expm1(rate * s.way));
    return sum;
  };
  double low = std::max(1e-3, last / 2), high = std::min(100.0, last * 2);
  for (int k = 0; k < 12; ++k) {
    const double middle = std::sqrt(low * high);
    (excess(middle) > 0 ? high : low) = middle;
  }
  return std::sqrt(low * high);
}

}  // namespace

double probability(const BeamModel& model, const BeamPair& beam, double max_range) {
  return causes(model, beam, max_range).sum();
}

void expect(const Beams& beams, const map::DistanceField& distances, const Pose2& T_map_robot,
            std::vector<BeamPair>& pairs) {
  const Vec2 laser = T_map_robot * beams.laser;
  const double c = std::cos(T_map_robot.theta), s = std::sin(T_map_robot.theta);
  for (std::size_t i = 0; i < beams.size(); ++i) {
    const Vec2 direction(c * beams.cos[i] - s * beams.sin[i], s * beams.cos[i] + c * beams.sin[i]);
    pairs.push_back({beams.range[i], distances.cast(laser, direction, beams.max_range)});
  }
}

std::uint32_t cost(const BeamModel& model, const Beams& beams, const map::DistanceField& distances,
                   const Pose2& T_map_robot) {
  std::vector<BeamPair> pairs;
  expect(beams, distances, T_map_robot, pairs);
  const double perfect = model.hit * normal(0, model.sigma) + model.random / beams.max_range;
  double sum = 0;
  for (const BeamPair& b : pairs) {
    const bool nothing = !(b.measured < beams.max_range);
    const double best = nothing ? model.hit + model.none : perfect;
    const double p = std::max(probability(model, b, beams.max_range), 1e-6 * best);
    sum += std::max(0.0, std::log(best / p));
  }
  return static_cast<std::uint32_t>(std::lround(sum / LikelihoodField::kUnit));
}

// Expectation: how likely each cause is for each beam; maximization: shares, sigma and rate.
BeamModel learn_beam_model(std::span<const BeamPair> pairs, double max_range,
                           const BeamModel& start, int rounds) {
  BeamModel model = start;
  std::vector<Shortened> shortened;
  for (int round = 0; round < rounds && !pairs.empty(); ++round) {
    Causes share;
    double squares = 0, measured_hits = 0;
    shortened.clear();
    for (const BeamPair& b : pairs) {
      const Causes c = causes(model, b, max_range);
      const double p = c.sum();
      if (p <= 0) continue;
      share.hit += c.hit / p, share.brief += c.brief / p;
      share.none += c.none / p, share.random += c.random / p;
      if (!(b.measured < max_range)) continue;
      if (c.hit > 0) {
        squares += c.hit / p * (b.measured - b.expected) * (b.measured - b.expected);
        measured_hits += c.hit / p;
      }
      if (c.brief > 0)
        shortened.push_back({c.brief / p, b.measured, std::min(b.expected, max_range)});
    }
    const double all = share.sum();
    model.hit = share.hit / all, model.brief = share.brief / all;
    model.none = share.none / all, model.random = share.random / all;
    if (measured_hits > 0) model.sigma = std::max(1e-3, std::sqrt(squares / measured_hits));
    if (!shortened.empty()) model.rate = rate_of(shortened, model.rate);
  }
  return model;
}

LikelihoodFieldOptions learn_likelihood_field(std::span<const double> distances,
                                              const LikelihoodFieldOptions& start, int rounds) {
  LikelihoodFieldOptions field = start;
  for (int round = 0; round < rounds && !distances.empty(); ++round) {
    double hits = 0, squares = 0;
    for (const double d : distances) {
      const double hit = field.hit * normal(d, field.sigma), random = field.random / field.range;
      const double p = hit / (hit + random);
      hits += p, squares += p * d * d;
    }
    if (hits <= 0) break;
    field.hit = hits / static_cast<double>(distances.size());
    field.random = 1 - field.hit;
    field.sigma = std::max(1e-3, std::sqrt(squares / hits));
  }
  return field;
}

}  // namespace majak::match
