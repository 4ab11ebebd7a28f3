// SPDX-License-Identifier: Apache-2.0
// Movable objects out of snapshots of one place, after Dogma (Biswas, Limketkai, Sanner, Thrun,
// "Towards object mapping in non-stationary environments with mobile robots", IROS 2002): what
// stays, which pieces of different snapshots show the same object, what each object looks like, and
// how many there are (MATH 21).
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "majak/core/parallel.hpp"
#include "majak/map/object_shape.hpp"

namespace majak::map {

struct ObjectOptions {
  PieceOptions pieces;
  ShapeOptions shape;
  double cost = 20;   ///< nats that an object must explain to be one
  double none = 0.1;  ///< chance of a cell of what is none of the objects
  double join = 1.0;  ///< m, parts of an object may be so far apart, what is between being hidden
  int most_objects = 12;  ///< 1 ... 16
  int most_pieces = 50;   ///< the largest ones; the time grows with their square
  int iterations = 12;    ///< of EM, at most, for each number of objects
};
void describe(OptionFields& fields, ObjectOptions& options);

/// That a piece shows an object.
struct ObjectSighting {
  std::size_t piece = 0;   ///< number in the list of pieces
  std::size_t object = 0;  ///< number in the list of objects
  Pose2 T_map_object;
  double probability = 0;  ///< that it is this object and no other, nor none of them
};

struct ObjectMap {
  KnownMap still;             ///< what stays
  std::vector<Piece> pieces;  ///< of all snapshots, in their order; parts of one object joined
  std::vector<ObjectShape> objects;       ///< those with more sightings first
  std::vector<ObjectSighting> sightings;  ///< at most one a piece, in the order of the pieces
  std::size_t left_out = 0;               ///< pieces beyond most_pieces
  double score = 0;                       ///< log-likelihood less the objects' cost, nats
};

/// EM over which piece shows which object, mutually exclusive within a snapshot; objects are added
/// and taken away as long as the score grows. Throws Error when an option is out of its range or
/// the snapshots' lattices differ. The result does not depend on the number of threads.
ObjectMap find_objects(std::span<const KnownMap> snapshots, const ObjectOptions& options = {},
                       Threads threads = {});

struct Recognition {
  std::vector<Piece> pieces;
  std::vector<ObjectSighting> sightings;  ///< `piece` counts in `pieces`
};
/// Which of the known objects stand where in a snapshot that was not learnt from.
Recognition recognize(const ObjectMap& objects, const KnownMap& snapshot,
                      const ObjectOptions& options = {}, Threads threads = {});

}  // namespace majak::map
