// SPDX-License-Identifier: Apache-2.0
// Correlative scan matching: the best pose in a whole window, exactly, by branch and bound over a
// pyramid of likelihood grids (Olson 2009; Hess et al. 2016, algorithms 2 and 3).
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "majak/core/pose2.hpp"
#include "majak/map/surfel_map.hpp"
#include "majak/match/scan_points.hpp"

namespace majak::match {

struct LikelihoodPyramidOptions {
  double cell = 0.10;            ///< m
  double sigma = 0.08;           ///< m, a cell this far from a surface counts exp(-1/2)
  double radius = 25.0;          ///< m, surfaces farther from the centre are left out
  double max_translation = 8.0;  ///< m, widest search that will be asked for
};

/// Likelihood of a return at a place, 0 ... 255, and its maxima over squares of 2, 4, 8, 16 cells.
class LikelihoodPyramid {
 public:
  static constexpr int kLevels = 5;

  LikelihoodPyramid(const map::SurfelMap& map, const Vec2& centre,
                    const LikelihoodPyramidOptions& options);

  double cell() const { return options_.cell; }
  const LikelihoodPyramidOptions& options() const { return options_; }
  int width() const { return width_; }
  /// Cell that holds a coordinate, counted from the padded grid's corner.
  int column(double x) const { return static_cast<int>(std::floor((x - x0_) / options_.cell)); }
  int row(double y) const { return static_cast<int>(std::floor((y - y0_) / options_.cell)); }
  /// Can a point of this cell meet a surface when it is moved by up to `reach` cells?
  bool near(int column, int row, int reach) const {
    return column + reach >= margin_ && column - reach < width_ - margin_ &&
           row + reach >= margin_ && row - reach < height_ - margin_;
  }
  /// Values of one level, row by row: the largest likelihood of [c, c + 2^level) x [r, r +
  /// 2^level).
  const std::uint8_t* level(int l) const {
    return values_.data() + static_cast<std::size_t>(l) * static_cast<std::size_t>(width_) *
                                static_cast<std::size_t>(height_);
  }

 private:
  void stamp_surfaces(const std::vector<map::Surfel>& surfels);
  void build_level(int l);

  LikelihoodPyramidOptions options_;
  double x0_ = 0, y0_ = 0;
  int width_ = 0, height_ = 0, margin_ = 0;  // the margin of empty cells takes moved points
  std::vector<std::uint8_t> values_;
};

/// Mean likelihood of the points at a pose, 0 ... 1, as search() measures it.
double likelihood(const ScanPoints& points, const LikelihoodPyramid& pyramid,
                  const Pose2& T_map_robot, int max_points = 120);

/// Half widths of the search about the given pose.
struct SearchWindow {
  double translation = 0.5;  ///< m, in x and in y
  double rotation = 0.35;    ///< rad
};

struct CorrelativeMatch {
  Pose2 T_map_robot;
  double score = 0;      ///< mean likelihood of the points, 0 ... 1
  long evaluations = 0;  ///< candidate squares looked at
};

/// The pose with the highest score in the window, if that is at least min_score. At most max_points
/// of the points within the pyramid's radius are used, spread evenly. Rotation is searched in steps
/// in which nine points of ten move by less than a cell and a half.
std::optional<CorrelativeMatch> search(const ScanPoints& points, const LikelihoodPyramid& pyramid,
                                       const Pose2& around, const SearchWindow& window,
                                       double min_score, int max_points = 120);

}  // namespace majak::match
