// SPDX-License-Identifier: Apache-2.0
#include "majak/map/returns.hpp"

#include <cmath>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/map/drawable.hpp"
#include "majak/map/edits.hpp"

namespace majak::map {
namespace {

constexpr std::size_t kDropped = std::numeric_limits<std::size_t>::max();

bool meets(const PosedScan& posed, Time first, const ScanSelection& selection) {
  const double seconds = to_seconds(posed.scan.time - first);
  if (seconds < selection.from || seconds > selection.to) return false;
  return !selection.near ||
         (posed.estimate.T_map_robot.translation() - *selection.near).norm() <= selection.radius;
}

}  // namespace

Site selected(const Site& site, const ScanSelection& selection) {
  Site part;
  part.source_name = site.source_name;
  part.odometry = site.odometry;
  part.used_odometry = site.used_odometry;
  part.options_toml = site.options_toml;
  std::vector<std::size_t> number(site.scans.size(), kDropped);
  for (std::size_t i = 0; i < site.scans.size(); ++i) {
    if (!meets(site.scans[i], site.scans.front().scan.time, selection)) continue;
    number[i] = part.scans.size();
    part.scans.push_back(site.scans[i]);
  }
  if (part.scans.empty()) throw Error("no scan of the run was taken then and there");
  for (Constraint constraint : site.constraints) {
    constraint.from = number[constraint.from], constraint.to = number[constraint.to];
    if (constraint.from != kDropped && constraint.to != kDropped)
      part.constraints.push_back(constraint);
  }
  part.edits_applied = site.edits_applied;
  for (const Edit& edit : site.edits) {
    if (edit.kind == EditKind::closure_off) continue;  // its scans have other numbers now
    part.edits.push_back(edit);
    if (!edit.points.empty())
      part.edits.back().points = anchored(part, edit.kind, points_in_map(site, edit)).points;
  }
  const Time begin = part.scans.front().scan.time, end = part.scans.back().scan.time;
  for (const Truth& truth : site.truth)
    if (truth.time >= begin && truth.time <= end) part.truth.push_back(truth);
  return part;
}

ReturnCounts count_returns(const Site& site, double resolution, double max_range) {
  ReturnCounts counts{.resolution = resolution};
  for (const PosedScan& posed : site.scans) {
    const Pose2 T_map_laser = posed.estimate.T_map_robot * posed.scan.T_robot_laser;
    if (!drawable(posed, resolution, max_range)) continue;
    ++counts.scans;
    for (std::size_t i = 0; i < posed.scan.ranges.size(); ++i) {
      const double range = posed.scan.ranges[i];
      if (std::isnan(range))
        ++counts.unknown;
      else if (range == kNoReturn)
        ++counts.no_returns;
      if (!(range > 0 && range <= max_range)) continue;
      ++counts.returns;
      const double angle = posed.scan.angle(i);
      const Vec2 p = T_map_laser * Vec2(range * std::cos(angle), range * std::sin(angle));
      std::uint16_t& cell = counts.cells(static_cast<int>(std::floor(p.x() / resolution)),
                                         static_cast<int>(std::floor(p.y() / resolution)));
      if (cell < std::numeric_limits<std::uint16_t>::max()) ++cell;
    }
  }
  return counts;
}

}  // namespace majak::map
