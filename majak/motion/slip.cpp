// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/slip.hpp"

#include <algorithm>
#include <cmath>

#include "majak/core/error.hpp"

namespace majak::motion {
namespace {

constexpr double kLever = 0.2;  // m, weighs a turn against a way
constexpr double kStepSeconds = 0.3;
// A calibration for slips alone need not be exact.
constexpr int kQuickRounds = 8;
constexpr double kQuickFactor = 1.1;
constexpr std::size_t kGap = 1;  // quiet steps within one event

/// The steps [first, last] as one motion.
struct Whole {
  Pose2 wheels, laser;
  bool jump = false;
};

Whole whole(const std::vector<SeenStep>& steps, std::size_t first, std::size_t last) {
  Whole sum;
  for (std::size_t i = first; i <= last; ++i) {
    sum.wheels = sum.wheels * steps[i].wheels, sum.laser = sum.laser * steps[i].laser;
    sum.jump = sum.jump || steps[i].broken;
  }
  return sum;
}

double size_of(const Pose2& motion) {
  return motion.translation().norm() + kLever * std::abs(motion.theta);
}

SlipEvent event_of(const std::vector<LaserPose>& laser, const std::vector<SeenStep>& steps,
                   std::size_t first, std::size_t last) {
  const Whole sum = whole(steps, first, last);
  const Pose2 off = between(sum.wheels, sum.laser);
  SlipEvent event;
  event.begin = laser[steps[first].end - 1].time, event.end = laser[steps[last].end].time;
  event.way = off.translation().norm(), event.turn = off.theta;
  event.kind = sum.jump                                   ? SlipKind::jump
               : size_of(sum.wheels) > size_of(sum.laser) ? SlipKind::slip
                                                          : SlipKind::push;
  return event;
}

}  // namespace

void sort_by_size(std::vector<SlipEvent>& events) {
  const auto size = [](const SlipEvent& e) { return e.way + kLever * std::abs(e.turn); };
  std::stable_sort(events.begin(), events.end(),
                   [&](const SlipEvent& a, const SlipEvent& b) { return size(a) > size(b); });
}

std::vector<SlipEvent> find_slips(const std::vector<LaserPose>& laser,
                                  const std::vector<WheelSample>& wheels, const Calibration& found,
                                  const Pose2& T_robot_laser, double wheelbase,
                                  const SlipOptions& options) {
  std::vector<LaserPose> poses;
  for (std::size_t i = 0; i < laser.size(); i += options.stride) poses.push_back(laser[i]);
  const DriveCorrection& c = found.correction;
  const Pose2 D =
      c.mounting ? Pose2{c.laser_x, c.laser_y, c.laser_theta} * T_robot_laser.inverse() : Pose2{};
  const auto steps = seen_steps(poses, wheels, c, D, wheelbase);
  const WhitenedSteps white(steps, found.noise, options.gate);
  std::vector<SlipEvent> events;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (!white.broken(i)) continue;
    std::size_t last = i;
    for (std::size_t k = i + 1; k < steps.size() && k <= last + 1 + kGap; ++k)
      if (white.broken(k)) last = k;
    const SlipEvent event = event_of(poses, steps, i, last);
    // One pose that came late errs to one side and back: nothing is left of that.
    if (event.kind == SlipKind::jump || event.way > options.least_way ||
        std::abs(event.turn) > options.least_turn)
      events.push_back(event);
    i = last;
  }
  return events;
}

std::vector<SlipEvent> find_slips(const DriveLog& log, const Site& site,
                                  const LogCalibration& found, double wheelbase) {
  if (site.scans.empty()) return {};
  const std::vector<LaserPose> laser = laser_poses(site, found.source);
  SlipOptions options;
  const double seconds = to_seconds(site.scans.back().scan.time - site.scans.front().scan.time);
  const double period = seconds / static_cast<double>(site.scans.size());
  options.stride =
      period > 0
          ? static_cast<std::size_t>(std::clamp(std::lround(kStepSeconds / period), 1L, 100L))
          : options.stride;
  const bool reversed = found.calibration.correction.reversed;
  auto events = find_slips(laser, samples_of(log, found.source, reversed, wheelbase),
                           found.calibration, site.scans.front().scan.T_robot_laser,
                           found.source == WheelSource::wheels ? wheelbase : 0, options);
  if (found.source == WheelSource::ordered)  // their times are the scans' numbers
    for (SlipEvent& e : events)
      for (Time* t : {&e.begin, &e.end})
        *t = site.scans[static_cast<std::size_t>(*t / kSecond)].scan.time;
  return events;
}

std::vector<SlipEvent> find_slips(const Site& site) {
  if (site.scans.empty()) return {};
  DriveLog log;
  for (const PosedScan& s : site.scans)
    if (s.T_odom_robot) log.records.push_back({s.scan.time, *s.T_odom_robot, {}, {}});
  // The lag is mended already, so the scans' order is all that is needed of time.
  const bool complete = log.records.size() == site.scans.size();
  const WheelSource source = complete ? WheelSource::ordered : WheelSource::records;
  const std::vector<LaserPose> laser = laser_poses(site, source);
  const std::vector<WheelSample> wheels = samples_of(log, source, false, 0);
  CalibrationOptions options;
  options.timed = false;
  options.rounds = kQuickRounds, options.noise_factor = kQuickFactor;
  options.T_robot_laser = site.scans.front().scan.T_robot_laser;
  try {
    const LogCalibration found{calibrate(laser, wheels, options), source};
    if (!found.calibration.contradicted()) return find_slips(log, site, found);
  } catch (const Error&) {  // the robot went too little way
  }
  return {};
}

}  // namespace majak::motion
