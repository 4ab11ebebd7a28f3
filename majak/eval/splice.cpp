// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/splice.hpp"

#include <algorithm>
#include <utility>

namespace majak::eval {
namespace {

const Scan* front_scan(const Event& event) {
  const Scan* scan = std::get_if<Scan>(&event);
  return scan && scan->laser == 0 ? scan : nullptr;
}

std::vector<std::size_t> front_scans(const std::vector<Event>& events) {
  std::vector<std::size_t> at;
  for (std::size_t i = 0; i < events.size(); ++i)
    if (front_scan(events[i])) at.push_back(i);
  return at;
}

/// What the wheels say at a scan: in its own record, else in the last one before it.
std::optional<Pose2> wheels_at(const std::vector<Event>& events, std::size_t scan) {
  if (const auto& own = std::get<Scan>(events[scan]).T_odom_robot) return own;
  for (std::size_t i = scan; i-- > 0;)
    if (const auto* odometry = std::get_if<Odometry>(&events[i])) return odometry->T_odom_robot;
  return std::nullopt;
}

/// The scan (of `scans`) that the robot is carried to from the scan a.
std::optional<std::size_t> other_place(const std::vector<Event>& events,
                                       const std::vector<std::size_t>& scans, std::size_t a,
                                       const Trajectory& way, double apart) {
  const TrajectoryIndex index(way);
  const auto pose = [&](std::size_t k) { return index.at(time_of(events[scans[k]])); };
  const auto from = pose(a);
  const auto far = [&](std::size_t k) {
    const auto to = from ? pose(k) : std::nullopt;
    return !to || (to->pose.translation() - from->pose.translation()).norm() >= apart;
  };
  const std::size_t wanted = 2 * scans.size() / 3;
  for (std::size_t k = wanted; k < scans.size(); ++k)
    if (far(k)) return k;
  for (std::size_t k = wanted; k-- > a + 1;)
    if (far(k)) return k;
  return std::nullopt;
}

void shift(Event& event, Duration later, const Pose2& T_new_old) {
  std::visit([&](auto& e) { e.time -= later; }, event);
  if (auto* odometry = std::get_if<Odometry>(&event))
    odometry->T_odom_robot = T_new_old * odometry->T_odom_robot;
  if (auto* scan = std::get_if<Scan>(&event); scan && scan->T_odom_robot)
    scan->T_odom_robot = T_new_old * *scan->T_odom_robot;
}

}  // namespace

Trajectory wheels_of(const std::vector<Event>& events) {
  Trajectory records;
  for (const Event& event : events)
    if (const auto* o = std::get_if<Odometry>(&event))
      records.push_back({o->time, o->T_odom_robot});
  return records.empty() ? odometry_of(events) : records;
}

Trajectory Splice::spliced(const Trajectory& path) const {
  Trajectory result;
  for (const StampedPose& p : path) {
    if (p.time <= last) result.push_back(p);
    if (p.time >= jump + later) result.push_back({p.time - later, p.pose});
  }
  return result;
}

std::optional<Splice> splice(const std::vector<Event>& events, const Trajectory& way,
                             double apart) {
  const auto scans = front_scans(events);
  if (scans.size() < 6) return std::nullopt;
  const std::size_t a = scans.size() / 3;
  const auto b = other_place(events, scans, a, way, apart);
  if (!b) return std::nullopt;

  Splice result;
  result.last = time_of(events[scans[a]]);
  result.jump = result.last + std::max<Duration>(1, result.last - time_of(events[scans[a - 1]]));
  result.later = time_of(events[scans[*b]]) - result.jump;
  const auto before = wheels_at(events, scans[a]), after = wheels_at(events, scans[*b]);
  const Pose2 T_new_old = before && after ? *before * after->inverse() : Pose2{};
  result.events.assign(events.begin(), events.begin() + static_cast<std::ptrdiff_t>(scans[a]) + 1);
  for (std::size_t i = scans[*b]; i < events.size(); ++i) {
    result.events.push_back(events[i]);
    shift(result.events.back(), result.later, T_new_old);
  }
  return result;
}

}  // namespace majak::eval
