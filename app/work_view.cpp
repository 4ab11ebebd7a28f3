// SPDX-License-Identifier: Apache-2.0
#include "app/work_view.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

#include "app/live.hpp"
#include "app/progress.hpp"
#include "majak/io/view_records.hpp"

namespace majak::app {
namespace {

constexpr Duration kBetweenScans = kSecond / 60;  // scans between key scans: what an eye can see
constexpr Duration kBetweenStatus = kSecond / 2;
constexpr Duration kBetweenPoses = kSecond / 2;
constexpr std::chrono::seconds kBetweenGrids{3};
constexpr double kMoved = 0.002;  // m and rad, of a key scan, that the page is told of

bool moved(const Pose2& from, const Pose2& to) {
  const Pose2 off = between(from, to);
  return off.translation().norm() > kMoved || std::abs(off.theta) > kMoved;
}

}  // namespace

WorkView::WorkView(Viewer& viewer, std::string name, const char* state,
                   const map::OccupancyGridOptions& grid)
    : viewer_(viewer), grid_(grid), painter_([this] { draw_grids(); }) {
  run_.name = std::move(name);
  run_.state = state;
  run_.generation = viewer.next_generation();
  viewer_.hub().reset({}, {{"/run", draw::view_run(run_)}});
}

WorkView::~WorkView() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  wake_.notify_one();
  painter_.join();
}

void WorkView::look(const slam::ScanChain& chain, double milliseconds) {
  const std::vector<PosedScan>& scans = chain.site().scans;
  const std::size_t fresh = chain.placed() - told_;
  for (; told_ < chain.placed(); ++told_)
    tell(scans[told_], told_, chain.keys()[chain.key_of(told_)].scan,
         milliseconds / static_cast<double>(fresh));
  if (fresh == 0) return;
  status(activity_.c_str());
  const Time now = live_clock();
  if (now - poses_told_ < kBetweenPoses) return;
  poses_told_ = now;
  tell_key_poses(chain.keys());
}

void WorkView::tell(const PosedScan& posed, std::size_t number, std::size_t key,
                    double milliseconds) {
  const std::size_t lasers = run_.lasers.size();
  const std::size_t laser = draw::laser_number(run_.lasers, posed.scan.T_robot_laser);
  if (number == 0) run_.begin = posed.scan.time, T_odom_first_ = posed.T_odom_robot;
  if (number == 0 || run_.lasers.size() != lasers) tell_run();
  ++scans_;

  io::ViewedPose view;
  view.scan = number;
  view.key = key;
  view.is_key = posed.key;
  view.estimate = posed.estimate;
  view.estimate.time = posed.scan.time;
  // How sure the place is only the whole run tells. Against what the first scan matched was
  // nothing.
  view.estimate.covariance.setConstant(std::numeric_limits<double>::quiet_NaN());
  view.match_score = number == 0 ? 1.0F : posed.match_score;
  if (view.match_score < slam::kLostScore) view.estimate.health = Health::lost;
  view.milliseconds = static_cast<float>(milliseconds);
  view.T_map_front_end = posed.T_map_robot_front_end;
  if (posed.T_odom_robot && T_odom_first_)
    view.T_map_odometry = between(*T_odom_first_, *posed.T_odom_robot);
  // Of a recording nothing stays here: it may go on for days.
  if (run_.state == "recording")
    viewer_.hub().set("/estimate", io::view_estimate(view), serve::kInOrder);
  else
    viewer_.hub().append(io::view_estimate(view));

  const Time now = live_clock();
  if (posed.key) {
    viewer_.hub().append(io::view_scan(number, posed.scan, laser));
    const std::lock_guard lock(mutex_);
    growth_.added.push_back(posed);
    growth_.poses.push_back(posed.estimate.T_map_robot);
  } else if (now - scan_told_ >= kBetweenScans) {
    scan_told_ = now;
    viewer_.hub().set("/scan", io::view_scan(number, posed.scan, laser), serve::kInOrder);
  }
}

void WorkView::show(const Scan& scan) {
  PosedScan posed;
  posed.scan = scan;
  posed.match_score = 1;
  tell(posed, told_, told_, 0);
  ++told_;
  status("recording");
}

void WorkView::tell_run() { viewer_.hub().set("/run", draw::view_run(run_)); }

// Loops that were closed have moved key scans, and what hangs on them.
void WorkView::tell_key_poses(const slam::KeyScans& keys) {
  bool any = false;
  for (std::size_t k = 0; k < keys.size(); ++k) {
    if (k == key_poses_.size()) {
      key_poses_.push_back(keys[k].T_map_robot);
      keys_.push_back(keys[k].scan);
    }
    any = any || moved(key_poses_[k], keys[k].T_map_robot);
  }
  if (!any) return;
  for (std::size_t k = 0; k < keys.size(); ++k) key_poses_[k] = keys[k].T_map_robot;
  viewer_.hub().set("/key_poses", io::view_key_poses(keys_, key_poses_), serve::kInOrder);
  const std::lock_guard lock(mutex_);
  growth_.poses = key_poses_;
}

void WorkView::status(const char* activity) {
  activity_ = activity;
  const Time now = live_clock();
  if (now - status_told_ < kBetweenStatus) return;
  const double rate = static_cast<double>(scans_ - scans_before_) / to_seconds(now - status_told_);
  scans_before_ = scans_;
  status_told_ = now;
  viewer_.hub().set(
      "/status",
      io::view_json(
          io::ViewTopic::status,
          fmt::format(R"({{"activity":"{}","scans":{},"scans_per_second":{:.1f},)"
                      R"("clients":{},"memory_mb":{:.0f}}})",
                      activity, scans_, rate, viewer_.statistics().clients, resident_megabytes())));
}

// On a thread of its own, so that who works need not wait for a picture.
void WorkView::draw_grids() {
  Site site;
  bool end = false;
  while (!end) {
    Growth growth;
    {
      std::unique_lock lock(mutex_);
      wake_.wait_for(lock, kBetweenGrids, [&] { return ended_; });
      end = ended_;
      growth.added = std::exchange(growth_.added, {});
      growth.poses = growth_.poses;
    }
    if (end || growth.added.empty()) continue;
    for (PosedScan& posed : growth.added) site.scans.push_back(std::move(posed));
    for (std::size_t k = 0; k < site.scans.size(); ++k)
      site.scans[k].estimate.T_map_robot = growth.poses[k];
    try {
      viewer_.hub().set("/map", io::view_map(map::build_occupancy_grid(site, grid_, {1})));
    } catch (const std::exception&) {  // who works will meet the same, and say so
      return;
    }
  }
}

}  // namespace majak::app
