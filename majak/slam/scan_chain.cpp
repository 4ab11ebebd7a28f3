// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/scan_chain.hpp"

#include <algorithm>
#include <utility>

#include "majak/core/error.hpp"
#include "majak/match/point_to_line.hpp"
#include "majak/slam/chain.hpp"

namespace majak::slam {
namespace {

constexpr double kOnSurface = 0.08;    // m
constexpr std::size_t kPatience = 10;  // scans that may queue behind one that waits for odometry

}  // namespace

ScanChain::ScanChain(const ScanChainOptions& options)
    : options_(options),
      drive_(options.drive),
      odometry_(motion::with_wheelbase(options.odometry, options.drive)),
      front_end_(options.front_end) {}

void ScanChain::add(Event event) {
  drive_.apply(event);
  if (auto* scan = std::get_if<Scan>(&event)) {
    if (scan->laser != 0) return;  // the front laser maps
    odometry_.add(*scan);
    site_.scans.push_back({std::move(*scan), {}, {}, {}, false, 0});
    key_of_.push_back(0);
  } else if (const auto* odometry = std::get_if<Odometry>(&event)) {
    odometry_.add(*odometry);
  } else if (const auto* wheels = std::get_if<WheelMotion>(&event)) {
    odometry_.add(*wheels);
  } else if (const auto* truth = std::get_if<Truth>(&event)) {
    site_.truth.push_back(*truth);
  }
}

std::optional<ScanChain::Step> ScanChain::next() {
  const std::size_t index = placed_;
  if (index >= site_.scans.size()) return std::nullopt;
  if (options_.use_odometry && !ended_ && !odometry_.ready(index) &&
      index + kPatience >= site_.scans.size())
    return std::nullopt;
  ++placed_;
  PosedScan& posed = site_.scans[index];
  std::optional<MotionPrior> motion;
  if (options_.use_odometry) {
    if (const auto predicted = odometry_.predict(index))
      motion = MotionPrior{predicted->T_previous_robot, predicted->sigma_translation,
                           predicted->sigma_rotation};
    posed.T_odom_robot = odometry_.pose(index);
  }
  FrontEndStep step = front_end_.add(posed.scan, motion);
  const bool weak = index > 0 && (step.broken || step.match.score < options_.front_end.weak_score);
  posed.T_map_robot_front_end = step.T_map_robot;
  const Pose2 seen = index == 0
                         ? Pose2{}
                         : between(site_.scans[index - 1].T_map_robot_front_end, step.T_map_robot);
  if (index > 0) odometry_.observe(index, seen, !weak && !step.searched);
  posed.match_score = static_cast<float>(step.match.score);  // until all scans are placed together
  posed.key = step.key;
  if (step.key) {
    KeyScan key = key_scan(std::move(step), index, posed.scan.T_robot_laser, weak);
    key.T_map_robot = in_map(key.T_front_robot);
    keys_.push_back(std::move(key));
  }
  key_of_[index] = keys_.empty() ? 0 : keys_.size() - 1;
  return Step{index, motion && index > 0 ? motion->T_previous_robot : seen, posed.key};
}

// The newest key scan's correction carries over to what follows it.
Pose2 ScanChain::in_map(const Pose2& T_front_robot) const {
  return keys_.empty()
             ? T_front_robot
             : keys_.back().T_map_robot * between(keys_.back().T_front_robot, T_front_robot);
}

const Estimate& ScanChain::settle() {
  PosedScan& posed = site_.scans[placed_ - 1];
  posed.estimate.time = posed.scan.time;
  posed.estimate.T_map_robot = in_map(posed.T_map_robot_front_end);
  return posed.estimate;
}

Hung hang(const std::vector<PosedScan>& scans, const KeyScans& keys, std::size_t k,
          std::size_t scan) {
  const auto seen_from = [&](const KeyScan& key) {
    return key.T_map_robot * between(key.T_front_robot, scans[scan].T_map_robot_front_end);
  };
  const Pose2 T = seen_from(keys[k]);
  if (k + 1 >= keys.size() || keys[k + 1].weak_step || scan < keys[k].scan) return {T, k};
  const double passed = static_cast<double>(scan - keys[k].scan) /
                        static_cast<double>(keys[k + 1].scan - keys[k].scan);
  return {interpolate(T, seen_from(keys[k + 1]), passed), k + (passed > 0.5 ? 1 : 0)};
}

Hung ScanChain::hang(std::size_t scan) const {
  return slam::hang(site_.scans, keys_, key_of_[scan], scan);
}

void ScanChain::hang_all(Threads threads) {
  map::SurfelMapOptions options = options_.front_end.map;
  options.max_count = 1000;
  map::SurfelMap map(options);
  for (const KeyScan& key : keys_) match::add_to(map, key.points, key.T_map_robot);
  parallel_for(threads, site_.scans.size(), [&](std::size_t i) {
    PosedScan& posed = site_.scans[i];
    const auto points = match::scan_points(posed.scan, options_.front_end.points, false);
    posed.estimate.T_map_robot = hang(i).T_map_robot;
    const double score = match::share_on(points, map, posed.estimate.T_map_robot, kOnSurface);
    posed.match_score = static_cast<float>(score);
    if (score < kLostScore) posed.estimate.health = Health::lost;
  });
}

void ScanChain::mend_odometry() {
  if (!options_.use_odometry) return;
  for (std::size_t i = 0; i < site_.scans.size(); ++i)
    site_.scans[i].T_odom_robot = odometry_.pose(i);
}

Site ScanChain::finish() {
  require_keys(keys_);
  mend_odometry();
  site_.odometry = odometry_.findings();
  OdometryFindings& found = site_.odometry;  // the model knows the place against the nominal one
  const Pose2 T_robot_laser =
      Pose2{found.laser_x_m.value, found.laser_y_m.value, found.laser_theta_rad.value} *
      site_.scans.front().scan.T_robot_laser;
  if (found.laser_x_m.used) found.laser_x_m.value = T_robot_laser.x;
  if (found.laser_y_m.used) found.laser_y_m.value = T_robot_laser.y;
  if (found.laser_theta_rad.used) found.laser_theta_rad.value = T_robot_laser.theta;
  site_.used_odometry = std::any_of(site_.scans.begin(), site_.scans.end(),
                                    [](const PosedScan& s) { return s.T_odom_robot.has_value(); });
  return std::move(site_);
}

void describe(OptionFields& f, ScanChainOptions& o) {
  f.add("slam.use_odometry", o.use_odometry, {"", "false: the laser alone"});
  FrontEndOptions& e = o.front_end;
  f.add("front_end.key_distance", e.key_distance, {"m", "a new key scan after this way", 0.01, 10});
  f.add("front_end.key_turn", e.key_turn, {"rad", "a new key scan after this turn", 0.01, 3});
  f.add("front_end.local_map_keys", e.local_map_keys, {"1", "key scans in a local map", 1, 1000});
  f.add("front_end.trusted_score", e.trusted_score,
        {"1", "share of matched returns below which the window is searched", 0, 1});
  f.add("front_end.search_translation", e.search_translation,
        {"m", "half width of that search", 0.1, 10});
  f.add("front_end.search_rotation", e.search_rotation,
        {"rad", "half width of that search", 0.05, 3.15});
  f.add("scan.max_range", e.points.max_range, {"m", "longer returns are not matched", 1, 1000});
  f.add("scan.min_range", e.points.min_range, {"m", "shorter returns are the robot itself", 0, 10});
  motion::describe(f, o.drive);
}

void require_keys(const KeyScans& keys) {
  if (keys.empty()) throw Error("no laser scan with at least ten returns: there is nothing to map");
}

}  // namespace majak::slam
