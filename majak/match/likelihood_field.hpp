// SPDX-License-Identifier: Apache-2.0
// Likelihood field (Thrun, Burgard, Fox 2005, 6.4): how well a return fits a place depends on how
// far the nearest occupied cell is from where the beam ends. One byte a cell, so that a map stays
// in the cache; sums are of integers, so that their order does not matter.
//
//   p(z) = hit N(d; sigma) + random / max_range,   cost = -log(p(z) / max p) in units of kUnit
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "majak/map/distance_field.hpp"
#include "majak/map/known_map.hpp"
#include "majak/match/beams.hpp"

namespace majak::match {

struct LikelihoodFieldOptions {
  double sigma = 0.10;  ///< m, of a return off its surface: laser, map and cell together
  double hit = 0.8;     ///< share of returns that come from what is on the map
  double random = 0.2;  ///< share that comes from anywhere
  double range = 10;    ///< m, over which those are spread
  double slack = 0;     ///< m, forgiven to each return: a bound for all places that near
};

/// Poses as arrays, map frame.
struct PoseArrays {
  std::vector<float> x, y, cos, sin;

  std::size_t size() const { return x.size(); }
  void resize(std::size_t n) { x.resize(n), y.resize(n), cos.resize(n), sin.resize(n); }
  void set(std::size_t i, const Pose2& T_map_robot);
};

class LikelihoodField {
 public:
  static constexpr double kUnit = 1.0 / 48;  ///< nat

  LikelihoodField(const map::KnownMap& map, const map::DistanceField& distances,
                  const LikelihoodFieldOptions& options = {});

  /// Of a return that ends in the cell of a place; that of a random return outside the map.
  std::uint8_t cost(float x, float y) const { return costs_[cell(x, y)]; }
  std::uint8_t cost_at_most() const { return outside_; }
  const LikelihoodFieldOptions& options() const { return options_; }

  /// Sum of the costs of all returns of `beams` for poses [begin, end), in units of kUnit nats.
  void costs(const Beams& beams, const PoseArrays& poses, std::size_t begin, std::size_t end,
             std::uint32_t* sums) const;

 private:
  std::size_t cell(float x, float y) const;

  LikelihoodFieldOptions options_;
  float x0_, y0_, inverse_resolution_;  // of the grid with its margin
  int width_, height_;                  // cells, one of margin on each side
  std::uint8_t outside_;
  std::vector<std::uint8_t> costs_;
};

}  // namespace majak::match
