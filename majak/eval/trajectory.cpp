// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/trajectory.hpp"

#include <algorithm>
#include <cmath>

#include "majak/core/error.hpp"
#include "majak/eval/comment.hpp"
#include "majak/io/line_reader.hpp"
#include "majak/io/number.hpp"

namespace majak::eval {

namespace {

/// A line's pose, or nullptr and why not.
const char* parse_pose(io::Fields fields, StampedPose& stamped) {
  double x = 0, y = 0, z = 0, qx = 0, qy = 0, qz = 0, qw = 0;
  if (!fields.time(stamped.time) || !fields.number(x) || !fields.number(y) || !fields.number(z) ||
      !fields.number(qx) || !fields.number(qy) || !fields.number(qz) || !fields.number(qw) ||
      !fields.at_end() || !std::isfinite(x + y + z + qx + qy + qz + qw)) {
    return "trajectory: line is not `time x y z qx qy qz qw`";
  }
  const double norm = qx * qx + qy * qy + qz * qz + qw * qw;
  if (!(norm > 1e-12)) return "trajectory: quaternion is zero";
  const double yaw = std::atan2(2 * (qw * qz + qx * qy), norm - 2 * (qy * qy + qz * qz));
  stamped.pose = {x, y, wrap_angle(yaw)};
  return nullptr;
}

}  // namespace

Trajectory read_tum(std::unique_ptr<io::ByteStream> bytes, const std::string& name,
                    Report& report) {
  io::LineReader lines(std::move(bytes));
  Trajectory trajectory;
  while (const auto line = lines.next()) {
    if (is_comment(*line)) continue;
    StampedPose stamped;
    if (const char* const fault = parse_pose(io::Fields(*line), stamped)) {
      report.count(fault, lines.line());
    } else {
      trajectory.push_back(stamped);
    }
  }
  const Report noticed = lines.report();
  for (const auto& [what, entry] : noticed.entries()) report.add(what, entry);
  if (trajectory.empty()) {
    throw Error(name + ": no pose in it; expected lines `time x y z qx qy qz qw`");
  }
  return trajectory;
}

Trajectory read_tum(const std::string& path, Report& report) {
  return read_tum(io::open_bytes(path).bytes, path, report);
}

Trajectory truth_of(const std::vector<Truth>& truth) {
  Trajectory trajectory;
  trajectory.reserve(truth.size());
  for (const Truth& t : truth) trajectory.push_back({t.time, t.T_world_robot});
  return trajectory;
}

Trajectory odometry_of(const std::vector<Event>& events) {
  Trajectory trajectory;
  for (const Event& event : events) {
    const Scan* scan = std::get_if<Scan>(&event);
    if (scan && scan->T_odom_robot) trajectory.push_back({scan->time, *scan->T_odom_robot});
  }
  return trajectory;
}

TrajectoryIndex::TrajectoryIndex(const Trajectory& trajectory, LookupOptions options)
    : options_(options) {
  entries_.reserve(trajectory.size());
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    entries_.push_back({trajectory[i].time, trajectory[i].pose, i});
  }
  std::stable_sort(entries_.begin(), entries_.end(),
                   [](const Entry& a, const Entry& b) { return a.time < b.time; });
}

/// The first entry among those of the nearest stamp.
std::optional<std::size_t> TrajectoryIndex::nearest(Time time) const {
  if (entries_.empty()) return std::nullopt;
  const auto by_time = [](const Entry& e, Time t) { return e.time < t; };
  const auto after = std::lower_bound(entries_.begin(), entries_.end(), time, by_time);
  if (after == entries_.begin()) return 0;
  const auto before = std::prev(after);
  if (after != entries_.end() && after->time - time <= time - before->time) {
    return static_cast<std::size_t>(after - entries_.begin());
  }
  const auto first = std::lower_bound(entries_.begin(), before, before->time, by_time);
  return static_cast<std::size_t>(first - entries_.begin());
}

std::optional<Lookup> TrajectoryIndex::at(Time time, std::size_t occurrence) const {
  const auto near = nearest(time);
  if (!near) return std::nullopt;
  const Entry& hit = entries_[*near];
  if (std::abs(hit.time - time) <= options_.tolerance) {
    const std::size_t i = *near + occurrence;
    if (i >= entries_.size() || entries_[i].time != hit.time) return std::nullopt;
    return Lookup{entries_[i].pose, true, entries_[i].index};
  }
  const auto after = std::upper_bound(entries_.begin(), entries_.end(), time,
                                      [](Time t, const Entry& e) { return t < e.time; });
  if (after == entries_.begin() || after == entries_.end()) return std::nullopt;
  const auto before = std::prev(after);
  const Duration gap = after->time - before->time;
  if (gap > options_.max_gap) return std::nullopt;
  const double fraction = static_cast<double>(time - before->time) / static_cast<double>(gap);
  return Lookup{interpolate(before->pose, after->pose, fraction), false, hit.index};
}

Association associate(const Trajectory& estimate, const Trajectory& reference,
                      LookupOptions options) {
  const TrajectoryIndex index(reference, options);
  Trajectory sorted = estimate;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const StampedPose& a, const StampedPose& b) { return a.time < b.time; });
  std::vector<bool> used(reference.size(), false);
  Association result;
  std::size_t occurrence = 0;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    occurrence = i > 0 && sorted[i].time == sorted[i - 1].time ? occurrence + 1 : 0;
    const auto found = index.at(sorted[i].time, occurrence);
    if (!found || (found->exact && used[found->index])) {
      ++result.unmatched;
      continue;
    }
    if (found->exact) used[found->index] = true;
    ++(found->exact ? result.exact : result.interpolated);
    result.pairs.push_back({sorted[i].time, sorted[i].pose, found->pose, found->exact});
  }
  return result;
}

}  // namespace majak::eval
