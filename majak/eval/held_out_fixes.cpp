// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/held_out_fixes.hpp"

#include <cmath>
#include <optional>

#include "majak/localize/gps_pieces.hpp"

namespace majak::eval {
namespace {

constexpr Duration kOutage = 5 * kSecond;
constexpr int kLeast = 5;  // fixes that are a witness

template <class Held>
std::vector<bool> hold_out(const ReferenceFixes& reference, const Held& held) {
  std::vector<bool> out;
  for (const ReferenceFix& fix : reference.fixes) out.push_back(held(fix));
  return out;
}

}  // namespace

ReferenceFixes reference_fixes(const std::vector<Event>& events, double wheelbase) {
  localize::GpsPieces pieces({.least = kLeast});
  std::optional<WheelMotion> wheels;
  std::optional<Pose2> T_odom_robot;
  double way = 0, turned = 0;
  ReferenceFixes reference;
  for (const Event& event : events) {
    if (const auto* fix = std::get_if<GpsFix>(&event)) {
      auto& fixes = reference.fixes;
      reference.bursts += fixes.empty() || fix->time - fixes.back().time > kOutage;
      fixes.push_back({fix->time, {fix->east, fix->north}, reference.bursts - 1, false});
      pieces.add(*fix, way, turned);
    }
    if (const auto* now = std::get_if<WheelMotion>(&event)) {
      const double step = wheels ? wheels->speed * to_seconds(now->time - wheels->time) : 0;
      way += step;
      if (wheels) turned += std::abs(step * std::tan(wheels->steering) / wheelbase);
      wheels = *now;
    }
    if (const auto* now = std::get_if<Odometry>(&event)) {
      const Pose2 step = T_odom_robot ? between(*T_odom_robot, now->T_odom_robot) : Pose2{};
      way += step.translation().norm(), turned += std::abs(step.theta);
      T_odom_robot = now->T_odom_robot;
    }
  }
  const auto verdicts = pieces.verdicts();
  for (std::size_t i = 0; i < verdicts.size(); ++i) reference.fixes[i].sound = verdicts[i].trusted;
  return reference;
}

std::vector<bool> hold_out_fold(const ReferenceFixes& reference, std::size_t fold) {
  return hold_out(reference, [&](const ReferenceFix& fix) {
    return fix.burst > 0 && fix.burst + 1 < reference.bursts && fix.burst % 2 != fold;
  });
}

std::vector<bool> hold_out_burst(const ReferenceFixes& reference, std::size_t burst) {
  return hold_out(reference, [&](const ReferenceFix& fix) { return fix.burst == burst; });
}

std::vector<bool> hold_out_between(const ReferenceFixes& reference, Time from, Time to) {
  return hold_out(reference,
                  [&](const ReferenceFix& fix) { return fix.time >= from && fix.time <= to; });
}

}  // namespace majak::eval
