// SPDX-License-Identifier: Apache-2.0
// Correlative scan matching: the best pose in a whole window, exactly, by branch and bound over a
// pyramid of likelihood grids (Olson 2009; Hess et al. 2016, algorithms 2 and 3).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "majak/core/pose2.hpp"
#include "majak/map/surfel_map.hpp"
#include "majak/match/scan_points.hpp"

namespace majak::match {

struct LikelihoodPyramidOptions {
  double cell = 0.10;   ///< m
  double sigma = 0.08;  ///< m, a return this far off a surface counts exp(-1/2)
  int levels = 5;       ///< level l holds maxima over 2^l x 2^l cells
};

/// Likelihood of a return at a place, 0 ... 255, and its maxima over ever larger squares.
class LikelihoodPyramid {
 public:
  LikelihoodPyramid(const map::SurfelMap& map, const LikelihoodPyramidOptions& options);

  double cell() const { return cell_; }
  int levels() const { return static_cast<int>(levels_.size()); }
  /// Cell that holds a coordinate, counted from the grid's corner.
  int column(double x) const { return static_cast<int>(std::floor((x - x0_) / cell_)); }
  int row(double y) const { return static_cast<int>(std::floor((y - y0_) / cell_)); }
  /// Largest likelihood of the cells [column, column + 2^level) x [row, row + 2^level); 0 outside.
  int at(int level, int column, int row) const {
    const int shift = (1 << level) - 1;  // a square may begin left of or below the grid
    const auto c = static_cast<unsigned>(column + shift), r = static_cast<unsigned>(row + shift);
    const Level& l = levels_[static_cast<std::size_t>(level)];
    return c < l.width && r < l.height ? l.values[static_cast<std::size_t>(r) * l.width + c] : 0;
  }

 private:
  struct Level {
    unsigned width = 0, height = 0;
    std::vector<std::uint8_t> values;
  };
  double cell_, x0_ = 0, y0_ = 0;
  std::vector<Level> levels_;
};

/// Half widths of the search about the given pose.
struct SearchWindow {
  double translation = 0.5;  ///< m, in x and in y
  double rotation = 0.35;    ///< rad
};

struct CorrelativeMatch {
  Pose2 T_map_robot;
  double score = 0;       ///< mean likelihood of the points, 0 ... 1
  long evaluations = 0;   ///< candidate squares looked at
};

/// The pose with the highest score in the window, if that is at least min_score. At most max_points
/// of the points are used, spread evenly. Rotation is searched in steps in which the farthest of
/// them moves by one cell.
std::optional<CorrelativeMatch> search(const ScanPoints& points, const LikelihoodPyramid& pyramid, const Pose2& around,
                                       const SearchWindow& window, double min_score, int max_points = 120);

}  // namespace majak::match
