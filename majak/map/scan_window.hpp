// SPDX-License-Identifier: Apache-2.0
// ScanWindow: a scan drawn into a window of bytes around it, so that a cell changes once a scan and
// a hit wins over beams that pass. For the maps that are made of whole scans.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

#include "majak/map/occupancy_grid.hpp"
#include "majak/map/ray.hpp"

namespace majak::map {

/// Directions of the beams in the laser's frame; the same for all scans of a usual log.
class BeamTable {
 public:
  const std::vector<Vec2>& of(const Scan& scan) {
    if (directions_.size() != scan.ranges.size() || start_ != scan.start_angle ||
        step_ != scan.angle_step) {
      start_ = scan.start_angle;
      step_ = scan.angle_step;
      directions_.resize(scan.ranges.size());
      for (std::size_t i = 0; i < directions_.size(); ++i) {
        directions_[i] = {std::cos(scan.angle(i)), std::sin(scan.angle(i))};
      }
    }
    return directions_;
  }

 private:
  double start_ = 0, step_ = 0;
  std::vector<Vec2> directions_;
};

/// One scan drawn: marks of the cells of a box of whole tiles.
class ScanWindow {
 public:
  static constexpr int kTileSize = OccupancyGrid::kTileSize;
  enum Mark : std::uint8_t { kNothing = 0, kFree = 1, kHit = 2 };

  void draw(const PosedScan& posed, const OccupancyGridOptions& options) {
    find_ends(posed, options);
    fit_box();
    const auto pitch = static_cast<std::ptrdiff_t>(box_.width);
    std::uint8_t* marks = marks_.data();
    for (const End& end : ends_) {
      for_each_cell(local(origin_), local(end.point), pitch,
                    [marks](std::ptrdiff_t i) { marks[i] = kFree; });
    }
    for (const End& end : ends_) {
      if (!end.hit) continue;
      const SubCellPoint p = local(end.point);
      marks[cell_of(p.x) + cell_of(p.y) * pitch] = kHit;
    }
  }

  /// Cells beside a hit no longer count as free: poses and ranges err by as much.
  void forget_beside_hits() {
    const auto pitch = static_cast<std::ptrdiff_t>(box_.width);
    const auto cells = pitch * box_.height;
    for (const End& end : ends_) {
      if (!end.hit) continue;
      const SubCellPoint p = local(end.point);
      const std::ptrdiff_t at = cell_of(p.x) + cell_of(p.y) * pitch;
      for (const std::ptrdiff_t row : {-pitch, std::ptrdiff_t{0}, pitch})
        for (std::ptrdiff_t i = at + row - 1; i <= at + row + 1; ++i)
          if (i >= 0 && i < cells && marks_[static_cast<std::size_t>(i)] == kFree)
            marks_[static_cast<std::size_t>(i)] = kNothing;
    }
  }

  /// Calls row(tx, ty, y, marks) for every row of kTileSize marks that is not blank, of tile
  /// (tx, ty), and leaves the window blank.
  template <class Row>
  void take_rows(Row row) {
    const int tiles_x = box_.width / kTileSize, tiles_y = box_.height / kTileSize;
    for (int ty = 0; ty < tiles_y; ++ty)
      for (int tx = 0; tx < tiles_x; ++tx) {
        std::uint8_t* marks = marks_.data() +
                              static_cast<std::ptrdiff_t>(ty) * kTileSize * box_.width +
                              tx * kTileSize;
        for (int y = 0; y < kTileSize; ++y, marks += box_.width) {
          if (blank(marks)) continue;
          row(box_.x0 / kTileSize + tx, box_.y0 / kTileSize + ty, y,
              static_cast<const std::uint8_t*>(marks));
          std::memset(marks, kNothing, kTileSize);
        }
      }
  }

 private:
  static bool blank(const std::uint8_t* marks) {
    std::uint64_t any = 0;
    for (int i = 0; i < kTileSize; i += 8) {
      std::uint64_t word;
      std::memcpy(&word, marks + i, sizeof word);
      any |= word;
    }
    return any == 0;
  }

  struct End {
    SubCellPoint point;
    bool hit;
  };

  void find_ends(const PosedScan& posed, const OccupancyGridOptions& options) {
    const Scan& scan = posed.scan;
    const Pose2 T_map_laser = posed.estimate.T_map_robot * scan.T_robot_laser;
    const double per_cell = 1.0 / options.resolution;
    const double c = std::cos(T_map_laser.theta) * per_cell,
                 s = std::sin(T_map_laser.theta) * per_cell;
    const double x = T_map_laser.x * per_cell, y = T_map_laser.y * per_cell;
    const std::vector<Vec2>& directions = table_.of(scan);
    const double no_return = std::min(options.no_return_range, options.max_range);
    origin_ = {to_sub_cells(x), to_sub_cells(y)};
    ends_.clear();
    for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
      double range = static_cast<double>(scan.ranges[i]);
      const bool hit = range > 0 && range <= options.max_range;
      if (range < 0) range = -range;  // erased()
      if (range == kNoReturn) {
        range = no_return;
      } else if (range > options.max_range) {
        range = options.max_range;
      }
      if (!(range > 0)) continue;  // also not a number
      const Vec2& d = directions[i];
      ends_.push_back({{to_sub_cells(x + range * (c * d.x() - s * d.y())),
                        to_sub_cells(y + range * (s * d.x() + c * d.y()))},
                       hit});
    }
  }

  void fit_box() {
    std::int64_t x_low = origin_.x, x_high = origin_.x, y_low = origin_.y, y_high = origin_.y;
    for (const End& end : ends_) {
      x_low = std::min(x_low, end.point.x);
      x_high = std::max(x_high, end.point.x);
      y_low = std::min(y_low, end.point.y);
      y_high = std::max(y_high, end.point.y);
    }
    const auto down = [](std::int64_t v) { return cell_of(v) & ~(kTileSize - 1); };
    box_ = {down(x_low), down(y_low), 0, 0};
    box_.width = down(x_high) + kTileSize - box_.x0;
    box_.height = down(y_high) + kTileSize - box_.y0;
    const auto cells = static_cast<std::size_t>(box_.width) * static_cast<std::size_t>(box_.height);
    if (marks_.size() < cells) marks_.resize(cells, kNothing);
  }

  SubCellPoint local(SubCellPoint p) const {
    return {p.x - (std::int64_t{box_.x0} << kSubCellBits),
            p.y - (std::int64_t{box_.y0} << kSubCellBits)};
  }

  BeamTable table_;
  SubCellPoint origin_;
  std::vector<End> ends_;
  CellBox box_;
  std::vector<std::uint8_t> marks_;  ///< blank between scans
};

}  // namespace majak::map
