// SPDX-License-Identifier: Apache-2.0
// Global search: where on a whole map, in which heading, does a scan fit? Branch and bound over
// (x, y, heading) as in correlative.hpp, but over everything at once and for the best few places
// instead of one: all coarse blocks are bounded in one dense pass, then opened best first (Land and
// Doig 1960), so that places come out in the order of their fit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "majak/map/distance_field.hpp"
#include "majak/map/known_map.hpp"
#include "majak/match/beams.hpp"

namespace majak::match {

struct GlobalSearchOptions {
  double cell = 0.10;        ///< m, of the finest grid searched
  double sigma = 0.12;       ///< m, of a return off its surface
  double random = 0.05;      ///< likelihood of any return against that of a perfect one
  double reach = 25;         ///< m, returns farther off are left out
  int returns = 60;          ///< of a scan that are looked at; 250 at most
  int most = 40;             ///< places that are told
  double apart = 0.8;        ///< m; nearer ones are one place
  double apart_turn = 0.35;  ///< rad
  double worse = 0.30;       ///< places whose mean fit is worse by more than this are not told
  int blocks = 400000;       ///< opened at most; what is left then is counted as not searched
};

/// A place that fits. `fit`: mean likelihood of the returns against that of perfect ones, as a
/// geometric mean, random ... 1.
struct FittingPlace {
  Pose2 T_map_robot;  ///< to the grid of the search
  double fit = 0;
};

struct GlobalSearchResult {
  std::vector<FittingPlace> places;  ///< best first
  std::size_t evaluated = 0;         ///< blocks bounded one by one
  bool complete = true;              ///< false: the budget ended it
};

class GlobalSearch {
 public:
  /// Needs the map only while it is made.
  GlobalSearch(const map::KnownMap& map, const map::DistanceField& distances,
               const GlobalSearchOptions& options = {});

  GlobalSearchResult find(const Beams& beams) const;
  std::size_t bytes() const;

 private:
  static constexpr int kLevels = 4;  // blocks of 1, 2, 4 and 8 cells
  static constexpr int kTop = kLevels - 1, kBlock = 1 << kTop;
  struct Rotated;  // the returns in one heading, in cells
  struct Block;
  struct Queue;

  std::vector<Rotated> rotate(const Beams& beams) const;
  void bound_all(const Rotated& returns, std::uint16_t* sums) const;
  std::uint32_t cost(const Rotated& returns, int level, int column, int row) const;
  bool free_within(int level, int column, int row) const;

  GlobalSearchOptions options_;
  double cell_, x0_, y0_;  // m; the corner of the grid without its margin
  int width_, height_;     // cells without the margin
  int columns_, rows_;     // blocks of the top level
  int margin_;             // cells on each side
  std::size_t stride_;     // cells in a padded row
  std::uint8_t outside_;
  std::vector<std::uint8_t> least_[kLevels];  // least cost in [c, c + 2^l) x [r, r + 2^l), padded
  std::vector<std::uint8_t> by_phase_;       // the top level, block by block for each offset in one
  std::vector<std::uint8_t> free_[kLevels];  // has the block at (c, r) a free cell? not padded
};

}  // namespace majak::match
