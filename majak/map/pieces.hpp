// SPDX-License-Identifier: Apache-2.0
// Pieces: what stands in one snapshot of a place and not in the others (MATH 21.1). A snapshot is
// the map of one visit; all of them share the map frame and the lattice of cells.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "majak/core/options.hpp"
#include "majak/map/known_map.hpp"

namespace majak::map {

struct PieceOptions {
  double margin = 0.08;      ///< m, so near to a thing that stays nothing is told from it
  double gap = 0.16;         ///< m, cells that near to each other are of one piece
  double least_size = 0.15;  ///< m, diagonal of the box around a piece
  double most_size = 3.0;    ///< m
  int least_cells = 6;       ///< occupied cells of a piece
};
void describe(OptionFields& fields, PieceOptions& options);

/// Outline of a thing as a snapshot saw it: mostly not all around.
struct Piece {
  std::size_t snapshot = 0;
  std::vector<Vec2> points;  ///< m, map frame: middles of occupied cells, in the order of the map
};

/// What stays: occupied where two thirds or more of the snapshots that know the cell say so, two at
/// the least; free where fewer do. A cell beside an occupied one votes for neither.
/// Throws Error when the snapshots' resolutions or lattices differ.
KnownMap still_map(std::span<const KnownMap> snapshots);

/// The pieces of a snapshot: connected groups of occupied cells that are free in the still map and
/// farther than the margin from what is occupied there.
std::vector<Piece> pieces_of(const KnownMap& still, const KnownMap& snapshot,
                             std::size_t snapshot_number, const PieceOptions& options = {});

}  // namespace majak::map
