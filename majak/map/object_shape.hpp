// SPDX-License-Identifier: Apache-2.0
// ObjectShape: how a movable object looks from above, as a small occupancy grid in a frame of its
// own, learnt from pieces that show it in different places and from different sides (MATH 21.2,
// 21.3).
#pragma once

#include <span>
#include <vector>

#include "majak/core/options.hpp"
#include "majak/map/pieces.hpp"

namespace majak::map {

struct ShapeOptions {
  double reach = 1.8;          ///< m, the grid's half side
  double unseen = 0.12;        ///< chance that a cell that was never seen is occupied
  double unseen_weight = 0.3;  ///< sightings that this is worth
  double point_weight = 0.3;   ///< what one cell of a piece counts, of an independent reading
};
void describe(OptionFields& fields, ShapeOptions& options);

/// The snapshot, in which free cells beside an occupied one are unknown: the errors of poses reach
/// so far.
KnownMap clear_floor(const KnownMap& snapshot);

/// A piece and what its snapshot saw around it.
struct SeenPiece {
  const Piece* piece = nullptr;
  const KnownMap* clear = nullptr;  ///< clear_floor()
};

class ObjectShape {
 public:
  struct Surface {
    Vec2 at;          ///< m, object frame
    double log_free;  ///< log of the chance that it is free
  };
  struct Sighting {
    SeenPiece seen;
    Pose2 T_map_object;
    double weight = 1;
  };

  /// Cells hold the weighted share of sightings that saw them occupied, of those that saw them.
  ObjectShape(std::span<const Sighting> sightings, double resolution, const ShapeOptions& options);

  double resolution() const { return resolution_; }
  /// Cells -half ... half along both axes; cell (0, 0) has its middle in the frame's origin.
  int half() const { return half_; }
  /// Chance that the cell is occupied; outside the grid that of cells never seen.
  double chance(int ix, int iy) const;
  /// Log of the chance at a point of the object frame, between four cells' middles.
  double log_chance(const Vec2& p) const;
  /// The same, the best within a cell, without interpolation: for the search.
  double best_log_chance(const Vec2& p) const {
    constexpr double kUp = 1 << 20;  // so that truncation rounds to the nearest
    const int x = static_cast<int>(p.x() / resolution_ + (kUp + 0.5)) - (1 << 20),
              y = static_cast<int>(p.y() / resolution_ + (kUp + 0.5)) - (1 << 20);
    return inside(x, y) ? static_cast<double>(best_log_chance_[index(x, y)]) : outside_;
  }
  /// Cells that are more likely occupied than not seen at all.
  const std::vector<Surface>& surface() const { return surface_; }
  /// The surface's middle.
  const Vec2& middle() const { return middle_; }

 private:
  std::size_t index(int ix, int iy) const {
    return static_cast<std::size_t>(iy + half_) * static_cast<std::size_t>(2 * half_ + 1) +
           static_cast<std::size_t>(ix + half_);
  }
  bool inside(int ix, int iy) const { return std::abs(ix) <= half_ && std::abs(iy) <= half_; }
  void add(const Sighting& sighting, std::vector<double>& hits, std::vector<double>& seen) const;
  void finish();

  double resolution_;
  int half_;
  double outside_;  ///< log of the chance of cells never seen
  std::vector<float> chance_, log_chance_, best_log_chance_;
  std::vector<Surface> surface_;
  Vec2 middle_ = Vec2::Zero();
};

/// How likely the piece is if the object is there: its points meet the shape, and no surface of the
/// shape lies where the snapshot saw free floor.
double log_likelihood(const ObjectShape& shape, const SeenPiece& seen, const Pose2& T_map_object,
                      const ShapeOptions& options);

struct ShapeFit {
  Pose2 T_map_object;
  double log_likelihood = 0;
};
/// The best place and heading, searched everywhere.
ShapeFit best_fit(const ObjectShape& shape, const SeenPiece& seen, const ShapeOptions& options);
/// The best one uphill from `start`.
ShapeFit refined_fit(const ObjectShape& shape, const SeenPiece& seen, const Pose2& start,
                     const ShapeOptions& options);

}  // namespace majak::map
