// SPDX-License-Identifier: Apache-2.0
// BeliefWeighing: P(s | l) of a scan for all cells of a belief, coarse to fine. Blocks of 4 x 4
// cells are bounded first: no cell in one can fit better than the block's middle does where each
// return is forgiven the way from there. Cells are looked at one by one only in blocks that may
// matter by that bound; the others keep it. So nothing is ever weighed down too far.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "majak/filter/pose_histogram.hpp"
#include "majak/localize/place.hpp"
#include "majak/match/beams.hpp"

namespace majak::localize {

/// What is looked at, and what is taken for the rest.
struct Look {
  double least = 0;        ///< cells below this times the largest before are not looked at; 0: all
  double share = 1e-4;     ///< blocks that cannot come to this times the largest after are not
  double elsewhere = 1.0;  ///< nat, mean cost of a beam where nobody looks
};

struct Weighed {
  double best = 0;                    ///< nat, mean cost of a beam at what is then likeliest
  double elsewhere = 1;               ///< what the probability of cells not looked at was times
  std::size_t blocks = 0, cells = 0;  ///< bounded, and looked at one by one
};

class BeliefWeighing {
 public:
  /// effective: beams of a scan that err by themselves; neighbours err together.
  BeliefWeighing(PlacePtr place, std::shared_ptr<const filter::PoseLattice> lattice,
                 double effective);

  /// Bel = P(s | l) Bel-, up to a factor.
  Weighed weigh(filter::PoseHistogram& belief, const match::Beams& beams, const Look& look,
                Threads threads = {}) const;

 private:
  struct Block;
  /// Cells of a tile, and what the scan costs there.
  struct Cells {
    std::vector<std::size_t> at;
    std::vector<std::uint32_t> cost;
  };
  struct Best {
    double log_p = -std::numeric_limits<double>::infinity();
    std::uint32_t cost = 0;
  };
  std::vector<Block> blocks_that_matter(const filter::PoseHistogram& belief,
                                        const std::vector<std::size_t>& held, double least,
                                        Threads threads) const;
  void bound(std::vector<Block>& blocks, const std::vector<std::size_t>& held,
             const match::Beams& beams, double nat, Threads threads) const;
  Cells look_at(const std::vector<float>& belief, std::size_t tile,
                const std::vector<Block>& blocks, const match::Beams& beams) const;
  Best best_of(const filter::PoseHistogram& belief, const std::vector<std::size_t>& held,
               std::vector<Block> blocks, const match::Beams& beams, double nat) const;
  void place(match::PoseArrays& poses, std::size_t i, const Vec2& at, int heading) const;

  PlacePtr place_;
  std::shared_ptr<const filter::PoseLattice> lattice_;
  double effective_;
  match::LikelihoodField coarse_;
  std::vector<float> cos_, sin_;  // of each heading
};

}  // namespace majak::localize
