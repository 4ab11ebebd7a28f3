// SPDX-License-Identifier: Apache-2.0
// The segment map of a run, measured.
//   run_segments RUN [--mahalanobis] [NAME=VALUE ...]
// RUN is a run's folder or its site.majak. Static returns are those in or beside
// an occupied cell of the run's grid. Times are of one thread.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/io/known_map_files.hpp"
#include "majak/io/options_file.hpp"
#include "majak/map/known_map.hpp"
#include "majak/map/segment_map.hpp"

namespace {

using namespace majak;

double cpu() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Distance to the nearest segment, up to kReach.
class Nearest {
 public:
  static constexpr double kReach = 0.1, kCell = 0.5;

  explicit Nearest(const std::vector<map::Segment>& segments) : segments_(segments) {
    for (std::size_t i = 0; i < segments.size(); ++i) {
      const Vec2 low = segments[i].a.cwiseMin(segments[i].b),
                 high = segments[i].a.cwiseMax(segments[i].b);
      for (int x = cell(low.x() - kReach); x <= cell(high.x() + kReach); ++x)
        for (int y = cell(low.y() - kReach); y <= cell(high.y() + kReach); ++y)
          cells_[key(x, y)].push_back(i);
    }
  }
  double operator()(const Vec2& p) const {
    double nearest = kReach;
    if (const auto found = cells_.find(key(cell(p.x()), cell(p.y()))); found != cells_.end())
      for (const std::size_t i : found->second)
        nearest = std::min(nearest, map::distance_to(segments_[i], p));
    return nearest;
  }

 private:
  static int cell(double v) { return static_cast<int>(std::floor(v / kCell)); }
  static std::int64_t key(int x, int y) { return (static_cast<std::int64_t>(x) << 32) + y; }
  const std::vector<map::Segment>& segments_;
  std::unordered_map<std::int64_t, std::vector<std::size_t>> cells_;
};

bool beside_occupied(const map::KnownMap& grid, const Vec2& p) {
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx)
      if (grid.at(grid.column(p.x()) + dx, grid.row(p.y()) + dy) == map::CellState::occupied)
        return true;
  return false;
}

struct Shares {
  std::size_t returns = 0, fixed = 0, within_2_cm = 0, within_5_cm = 0;
};

Shares shares(const Site& site, const map::KnownMap& grid, const std::vector<map::Segment>& walls,
              double max_range) {
  Shares sum;
  const Nearest nearest(walls);
  for (const PosedScan& posed : site.scans) {
    if (posed.estimate.health == Health::lost || !posed.estimate.T_map_robot.finite()) continue;
    const Pose2 T_map_laser = posed.estimate.T_map_robot * posed.scan.T_robot_laser;
    for (std::size_t i = 0; i < posed.scan.ranges.size(); ++i) {
      const double r = posed.scan.ranges[i], angle = posed.scan.angle(i);
      if (!std::isfinite(r) || r <= 0 || r > max_range) continue;
      const Vec2 p = T_map_laser * Vec2(r * std::cos(angle), r * std::sin(angle));
      ++sum.returns;
      if (!beside_occupied(grid, p)) continue;
      const double distance = nearest(p);
      ++sum.fixed;
      sum.within_2_cm += distance <= 0.02;
      sum.within_5_cm += distance <= 0.05;
    }
  }
  return sum;
}

/// Of the returns beside a straight piece of 1 m or more of their own scan (within 8 cm), the share
/// within 2 cm of it: what no map with one segment a wall can surpass on these walls.
double own_line_share(const Site& site, const map::SegmentOptions& options) {
  std::size_t beside = 0, within = 0;
  for (std::size_t n = 0; n < site.scans.size(); n += 10) {
    const Scan& scan = site.scans[n].scan;
    for (const map::Segment& s : map::extract_segments(scan, options)) {
      if (s.length() < 1) continue;
      for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
        const double r = scan.ranges[i], angle = scan.angle(i);
        if (!std::isfinite(r) || r <= 0 || r > options.max_range) continue;
        const Vec2 p = scan.T_robot_laser * Vec2(r * std::cos(angle), r * std::sin(angle));
        const double u = s.direction().dot(p - s.a), v = std::abs(s.normal().dot(p - s.a));
        if (u < 0 || u > s.length() || v > 0.08) continue;
        ++beside;
        within += v <= 0.02;
      }
    }
  }
  return static_cast<double>(within) / static_cast<double>(std::max<std::size_t>(beside, 1));
}

void measure(const std::string& run, const map::SegmentMapOptions& options) {
  const auto input = io::read_map(run);
  if (!input.site) throw Error(run + ": not a run");
  const double begin = cpu();
  const map::SegmentMap built = map::build_segments(*input.site, options);
  const double seconds = cpu() - begin;
  const auto walls = built.walls();
  const map::OccupancyGrid grid = map::build_occupancy_grid(*input.site);
  const map::CellBox box = grid.bounds();
  const Shares s = shares(*input.site, known_map(grid), walls, options.scan.max_range);

  double length = 0;
  for (const map::Segment& w : walls) length += w.length();
  const std::size_t bytes = walls.size() * 4 * sizeof(double);
  const auto cells = static_cast<std::size_t>(box.width) * static_cast<std::size_t>(box.height);
  const auto percent = [](std::size_t part, std::size_t of) {
    return 100.0 * static_cast<double>(part) / static_cast<double>(std::max<std::size_t>(of, 1));
  };
  fmt::print("segments            {} of {} in the map (the others in fewer scans), {:.0f} m\n",
             walls.size(), built.segments().size(), length);
  fmt::print("static returns      {:.1f} % of {}\n", percent(s.fixed, s.returns), s.returns);
  fmt::print("  within 2 cm       {:.1f} %\n  within 5 cm       {:.1f} %\n",
             percent(s.within_2_cm, s.fixed), percent(s.within_5_cm, s.fixed));
  fmt::print("  of their own scan's line within 2 cm {:.1f} %\n",
             100 * own_line_share(*input.site, options.scan));
  fmt::print("bytes               {} (two ends of two doubles each)\n", bytes);
  fmt::print("grid, 1 byte a cell {} ({:.0f} : 1)\n", cells,
             static_cast<double>(cells) / static_cast<double>(std::max<std::size_t>(bytes, 1)));
  fmt::print("grid in memory      {} (tiles of 2 bytes a cell)\n", grid.bytes());
  fmt::print("seconds             {:.2f} for {} scans\n", seconds, input.site->scans.size());
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc < 2) throw Error("usage: run_segments RUN [--mahalanobis] [NAME=VALUE ...]");
    map::SegmentMapOptions options;
    OptionFields fields;
    describe(fields, options);
    for (int i = 2; i < argc; ++i) {
      if (std::string_view(argv[i]) == "--mahalanobis")
        options.correspondence = map::Correspondence::mahalanobis;
      else
        io::apply_option(fields, argv[i]);
    }
    measure(argv[1], options);
    return 0;
  } catch (const Error& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  }
}
