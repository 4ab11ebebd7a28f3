// SPDX-License-Identifier: Apache-2.0
// A simulated robot that drives in a finished map and does not know where: watched on the page.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "app/viewer.hpp"
#include "majak/core/event.hpp"
#include "majak/core/site.hpp"
#include "majak/io/view_records.hpp"
#include "majak/localize/monte_carlo.hpp"
#include "majak/map/occupancy_grid.hpp"
#include "majak/sim/simulator.hpp"

namespace majak::app {

class RobotView {
 public:
  /// It starts where the run ended. Its scans and estimates follow those of the run on the page.
  /// Throws Error for a method that does not work on a map, and for a map without a way to drive.
  RobotView(Viewer& viewer, const Site& site, const map::OccupancyGrid& grid,
            const std::string& method);
  ~RobotView();
  RobotView(const RobotView&) = delete;
  RobotView& operator=(const RobotView&) = delete;

  /// It drives from now on.
  void start();
  /// The method is told where the robot is, rightly or not.
  void start_at(const Pose2& T_map_robot);
  /// The robot is carried there, and goes on from there. Throws Error where it could not drive.
  void kidnap(const Pose2& T_map_robot);

 private:
  /// Turns an event into an estimate, where it can.
  using Method = std::function<std::optional<Estimate>(const Event&)>;

  void set_method(std::optional<Pose2> start);
  void set_monte_carlo(std::optional<Pose2> start);
  void set_simulator(const Pose2& T_map_robot);
  void drive();
  void take(Event event);
  void tell(const Scan& scan, const Estimate& estimate);
  void tell_cloud(Time time);

  Viewer& viewer_;
  std::string method_name_;
  localize::PlacePtr place_;
  sim::Scene scene_;
  Pose2 T_robot_laser_;         ///< as on the robot of the run
  std::size_t first_scan_ = 0;  ///< the run has so many
  std::size_t scans_ = 0;
  Time time_ = 0;  ///< of the newest event
  io::StampedPoses truth_;
  Time truth_told_ = 0;

  std::mutex mutex_;  ///< what follows is the driving thread's but for commands
  std::unique_ptr<sim::World> world_;
  std::unique_ptr<sim::Simulator> simulator_;
  Pose2 T_odom_begin_, T_odom_robot_;  ///< of this simulation, and the newest: no jump in between
  Method method_;
  std::deque<Scan> waiting_;                     ///< for their estimates
  std::shared_ptr<localize::MonteCarlo> cloud_;  ///< of the one method that has one
  std::atomic<bool> stopped_ = false;
  std::thread driver_;
};

}  // namespace majak::app
