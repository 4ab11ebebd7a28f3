// SPDX-License-Identifier: Apache-2.0
// Work in progress on the page: scans as they come, where they are by now, the map as it grows.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "app/viewer.hpp"
#include "majak/core/site.hpp"
#include "majak/draw/site_view.hpp"
#include "majak/map/occupancy_grid.hpp"
#include "majak/slam/scan_chain.hpp"

namespace majak::app {

/// For the thread that works: looking costs it some microseconds a scan.
class WorkView {
 public:
  /// `state`: "mapping" or "recording". `viewer` outlives it.
  WorkView(Viewer& viewer, std::string name, const char* state,
           const map::OccupancyGridOptions& grid);
  ~WorkView();
  WorkView(const WorkView&) = delete;
  WorkView& operator=(const WorkView&) = delete;

  /// What was placed since the last look; `milliseconds`: that it took.
  void look(const slam::ScanChain& chain, double milliseconds);
  /// A scan without a place, as it is recorded.
  void show(const Scan& scan);
  void status(const char* activity);

 private:
  /// Key scans for the grid, handed to the thread that draws it.
  struct Growth {
    std::vector<PosedScan> added;
    std::vector<Pose2> poses;  ///< of all, in their order
  };

  void tell(const PosedScan& posed, std::size_t number, std::size_t key, double milliseconds);
  void tell_run();
  void tell_key_poses(const slam::KeyScans& keys);
  void draw_grids();

  Viewer& viewer_;
  draw::RunTold run_;
  map::OccupancyGridOptions grid_;
  std::size_t told_ = 0, scans_ = 0, scans_before_ = 0;
  Time scan_told_ = 0, status_told_ = 0, poses_told_ = 0;  ///< by the clock of the wall
  std::string activity_;
  std::vector<Pose2> key_poses_;  ///< as they were told last
  std::vector<std::size_t> keys_;
  std::optional<Pose2> T_odom_first_;

  std::mutex mutex_;
  std::condition_variable wake_;
  Growth growth_;
  bool ended_ = false;
  std::thread painter_;
};

}  // namespace majak::app
