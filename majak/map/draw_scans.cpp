// SPDX-License-Identifier: Apache-2.0
// build_occupancy_grid: a scan is first drawn into a window of bytes around it (free, then hit, so
// that a cell changes once a scan and a hit wins), then the window is added to the tiles, row by
// row.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>

#include "majak/core/error.hpp"
#include "majak/map/drawable.hpp"
#include "majak/map/occupancy_grid.hpp"
#include "majak/map/ray.hpp"

namespace majak::map {

namespace {

constexpr int kTileSize = OccupancyGrid::kTileSize;
constexpr std::int16_t kUnknown = OccupancyGrid::kUnknown;

enum Mark : std::uint8_t { kNothing = 0, kFree = 1, kHit = 2 };

/// Integers in units of OccupancyGrid::kUnit. Sums stay inside int16 by the ranges of the options.
struct Steps {
  std::int16_t hit, miss, limit;
};

bool blank(const std::uint8_t* marks) {
  std::uint64_t any = 0;
  for (int i = 0; i < kTileSize; i += 8) {
    std::uint64_t word;
    std::memcpy(&word, marks + i, sizeof word);
    any |= word;
  }
  return any == 0;
}

/// A row of a window onto a row of a tile. Without a branch, so that it becomes vector code.
#if defined(__x86_64__) && defined(__linux__) && !defined(__SANITIZE_ADDRESS__)
__attribute__((target_clones("avx2", "default")))  // integers: the same result either way
#endif
void add_row(std::int16_t* cells, const std::uint8_t* marks, const Steps& steps) {
  const Steps s = steps;
  const auto low = static_cast<std::int16_t>(-s.limit);
  for (int i = 0; i < kTileSize; ++i) {
    const std::int16_t old = cells[i], mark = marks[i];
    const std::int16_t base = old == kUnknown ? std::int16_t{0} : old;
    const std::int16_t change = mark == kHit ? s.hit : s.miss;
    const auto sum = static_cast<std::int16_t>(base + change);
    const std::int16_t next = std::min(std::max(sum, low), s.limit);
    cells[i] = mark != kNothing ? next : old;
  }
}

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

  /// Adds the window to the grid and leaves the window blank.
  void add_to(OccupancyGrid& grid, const Steps& steps) {
    const int tiles_x = box_.width / kTileSize, tiles_y = box_.height / kTileSize;
    for (int ty = 0; ty < tiles_y; ++ty) {
      for (int tx = 0; tx < tiles_x; ++tx) {
        add_tile(grid, tx, ty, steps);
      }
    }
  }

 private:
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
      const bool hit = range <= options.max_range;
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

  void add_tile(OccupancyGrid& grid, int tx, int ty, const Steps& steps) {
    std::uint8_t* marks =
        marks_.data() + static_cast<std::ptrdiff_t>(ty) * kTileSize * box_.width + tx * kTileSize;
    std::int16_t* cells = nullptr;
    for (int y = 0; y < kTileSize; ++y, marks += box_.width) {
      if (blank(marks)) continue;
      if (!cells) cells = grid.tile(box_.x0 / kTileSize + tx, box_.y0 / kTileSize + ty);
      add_row(cells + y * kTileSize, marks, steps);
      std::memset(marks, kNothing, kTileSize);
    }
  }

  BeamTable table_;
  SubCellPoint origin_;
  std::vector<End> ends_;
  CellBox box_;
  std::vector<std::uint8_t> marks_;  ///< blank between scans
};

/// Scans that moved or turned far enough from the last chosen one of the same laser.
std::vector<std::size_t> choose_scans(const Site& site, const OccupancyGridOptions& options) {
  std::vector<std::size_t> chosen;
  std::vector<std::pair<int, Pose2>> last;  // by laser
  for (std::size_t i = 0; i < site.scans.size(); ++i) {
    const PosedScan& posed = site.scans[i];
    if (!drawable(posed, options.resolution, options.max_range)) continue;
    const Pose2& pose = posed.estimate.T_map_robot;
    const auto same = std::find_if(last.begin(), last.end(),
                                   [&](const auto& l) { return l.first == posed.scan.laser; });
    if (same != last.end()) {
      const double moved = (pose.translation() - same->second.translation()).norm();
      const double turned = std::abs(angle_diff(pose.theta, same->second.theta));
      if (moved < options.scan_spacing && turned < options.scan_turn) continue;
      same->second = pose;
    } else {
      last.emplace_back(posed.scan.laser, pose);
    }
    chosen.push_back(i);
  }
  return chosen;
}

void check(OccupancyGridOptions options) {
  OptionFields fields;
  describe(fields, options);
  for (const OptionField& field : fields.list) {
    const double value = *std::get<double*>(field.value);
    if (!(value >= field.info.min && value <= field.info.max)) {
      throw Error("option " + field.name + " is out of its range");
    }
  }
}

std::int16_t to_units(double log_odds) {
  return static_cast<std::int16_t>(std::lround(log_odds / OccupancyGrid::kUnit));
}

}  // namespace

OccupancyGrid build_occupancy_grid(const Site& site, const OccupancyGridOptions& options,
                                   Threads threads) {
  check(options);
  const Steps steps{to_units(options.log_odds_hit), to_units(-options.log_odds_miss),
                    to_units(options.log_odds_limit)};
  OccupancyGrid grid(options.resolution);
  const std::vector<std::size_t> chosen = choose_scans(site, options);
  // A batch is drawn side by side and added in the order of the log.
  std::vector<ScanWindow> windows(static_cast<std::size_t>(std::max(1, threads.count)));
  for (std::size_t first = 0; first < chosen.size(); first += windows.size()) {
    const std::size_t count = std::min(windows.size(), chosen.size() - first);
    parallel_for(threads, count,
                 [&](std::size_t i) { windows[i].draw(site.scans[chosen[first + i]], options); });
    for (std::size_t i = 0; i < count; ++i) windows[i].add_to(grid, steps);
  }
  grid.scans_drawn_ = chosen.size();
  return grid;
}

}  // namespace majak::map
