// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/path_score.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "majak/core/rigid_fit.hpp"
#include "majak/eval/consistency.hpp"
#include "majak/eval/trajectory.hpp"

namespace majak::eval {
namespace {

/// The path where there is a witness: which one, the estimate then, and the point on the robot.
struct Met {
  const Witness* witness;
  Pose2 T_map_robot;
  Mat3 covariance;
  Vec2 p_map;
};

std::vector<Met> meet(const std::vector<Estimate>& estimates, const Reference& reference,
                      const std::vector<bool>& chosen) {
  Trajectory path;
  for (const Estimate& e : estimates) path.push_back({e.time, e.T_map_robot});
  const TrajectoryIndex index(path);
  std::vector<Met> met;
  for (std::size_t i = 0; i < reference.witnesses.size(); ++i) {
    if (!chosen.empty() && !chosen[i]) continue;
    const Witness& w = reference.witnesses[i];
    if (const auto at = index.at(w.time))
      met.push_back({&w, at->pose, estimates[at->index].covariance, at->pose * reference.point});
  }
  return met;
}

Pose2 frame(const std::vector<Met>& met, const Reference& reference, Against against) {
  if (met.empty()) return {};
  if (against == Against::aligned) {
    std::vector<Vec2> path, witnesses;
    for (const Met& m : met)
      if (m.witness->sound) path.push_back(m.p_map), witnesses.push_back(m.witness->p);
    return rigid_fit(path, witnesses);
  }
  if (against != Against::first_pose) return {};
  const Pose2 turn{0, 0, reference.heading - met.front().T_map_robot.theta};
  const Vec2 off = met.front().witness->p - turn * met.front().p_map;
  return {off.x(), off.y(), turn.theta};
}

std::optional<double> nis_of(const Met& m, const Reference& reference, const Pose2& T) {
  if (m.witness->truth) return nees(m.T_map_robot, m.covariance, T.inverse() * *m.witness->truth);
  Eigen::Matrix<double, 2, 3> by_pose;
  const Vec2 lever = m.p_map - m.T_map_robot.translation();
  by_pose << 1, 0, -lever.y(), 0, 1, lever.x();
  Eigen::Matrix2d s = by_pose * m.covariance * by_pose.transpose();
  s.diagonal().array() += reference.variance;
  const Vec2 off = T.inverse() * m.witness->p - m.p_map;
  return off.dot(s.inverse() * off);
}

}  // namespace

const char* name_of(Against against) {
  constexpr const char* kNames[] = {"after one alignment", "from the first pose alone",
                                    "not fed with, nothing aligned", "fed with, nothing aligned"};
  return kNames[static_cast<std::size_t>(against)];
}

PathScore score(const std::vector<Estimate>& estimates, const Reference& reference,
                const std::vector<bool>& chosen, Against against) {
  const std::vector<Met> met = meet(estimates, reference, chosen);
  PathScore s{against, frame(met, reference, against), {}};
  for (const Met& m : met) {
    PlaceError e{m.witness->time,
                 s.T_reference_map * m.p_map - m.witness->p,
                 m.witness->group,
                 m.witness->sound,
                 {}};
    // Where the frame comes from fixes, the path's covariance says nothing of it.
    if (against == Against::held_out || against == Against::fed ||
        (against == Against::first_pose && m.witness->truth))
      e.nis = nis_of(m, reference, s.T_reference_map);
    s.errors.push_back(e);
  }
  return s;
}

Headline headline(const std::vector<PlaceError>& errors, bool sound_only) {
  Headline h;
  std::vector<double> sizes;
  std::vector<int> groups;
  std::map<int, std::vector<Vec2>> by_group;
  double nis = 0, known = 0;
  for (const PlaceError& e : errors) {
    if (sound_only && !e.sound) continue;
    sizes.push_back(e.error());
    groups.push_back(e.group);
    by_group[e.group].push_back(e.off);
    if (e.nis) nis += *e.nis, known += 1;
  }
  if (sizes.empty()) return h;
  h.groups = by_group.size();
  double spread = 0, dof = 0;
  for (const auto& [group, offs] : by_group) {
    Vec2 mean = Vec2::Zero();
    for (const Vec2& off : offs) mean += off / static_cast<double>(offs.size());
    for (const Vec2& off : offs) spread += (off - mean).squaredNorm();
    dof += 2 * static_cast<double>(offs.size() - 1);
  }
  if (dof > 0) h.scatter = std::sqrt(spread / dof);
  if (known > 0) h.nis = nis / known;
  h.mean = mean_with_confidence(sizes, groups);
  h.stats = error_stats(std::move(sizes));
  return h;
}

}  // namespace majak::eval
