// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/trajectory.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <istream>
#include <limits>

#include "majak/core/error.hpp"
#include "majak/eval/fields.hpp"

namespace majak::eval {

std::optional<Time> parse_stamp(std::string_view text) {
  const bool negative = !text.empty() && text.front() == '-';
  if (negative) text.remove_prefix(1);
  const std::size_t dot = std::min(text.find('.'), text.size());
  const std::string_view whole = text.substr(0, dot);
  const std::string_view part = dot < text.size() ? text.substr(dot + 1) : std::string_view{};
  if (whole.empty() && part.empty()) return std::nullopt;
  constexpr Time kMaxSeconds = std::numeric_limits<Time>::max() / kSecond - 1;
  Time seconds = 0, nanoseconds = 0, digit_value = kSecond;
  for (const char c : whole) {
    if (c < '0' || c > '9') return std::nullopt;
    seconds = 10 * seconds + (c - '0');
    if (seconds > kMaxSeconds) return std::nullopt;
  }
  for (std::size_t i = 0; i < part.size(); ++i) {
    if (part[i] < '0' || part[i] > '9') return std::nullopt;
    if (i < 9) nanoseconds += (part[i] - '0') * (digit_value /= 10);
    if (i == 9 && part[i] >= '5') ++nanoseconds;
  }
  const Time time = seconds * kSecond + nanoseconds;
  return negative ? -time : time;
}

Trajectory read_tum(std::istream& in, const std::string& name, Report& report) {
  Trajectory trajectory;
  std::string line;
  for (std::int64_t number = 1; std::getline(in, line); ++number) {
    const auto fields = split_fields(line);
    if (fields.empty()) continue;
    const auto time = parse_stamp(fields[0]);
    const auto values = fields.size() == 8 ? parse_numbers<7>(fields, 1) : std::nullopt;
    if (!time || !values) {
      report.count("trajectory: line is not `time x y z qx qy qz qw`", number);
      continue;
    }
    const auto& [x, y, z, qx, qy, qz, qw] = *values;
    const double norm = qx * qx + qy * qy + qz * qz + qw * qw;
    if (!(norm > 1e-12)) {
      report.count("trajectory: quaternion is zero", number);
      continue;
    }
    const double yaw = std::atan2(2 * (qw * qz + qx * qy), norm - 2 * (qy * qy + qz * qz));
    trajectory.push_back({*time, {x, y, wrap_angle(yaw)}});
  }
  if (trajectory.empty()) {
    throw Error(name + ": no pose in it; expected lines `time x y z qx qy qz qw`");
  }
  return trajectory;
}

Trajectory read_tum(const std::string& path, Report& report) {
  std::ifstream in(path);
  if (!in) throw Error(path + ": cannot be read; check the name and the reading rights");
  return read_tum(in, path, report);
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

Association associate(const Trajectory& estimate, const Trajectory& reference, LookupOptions options) {
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
