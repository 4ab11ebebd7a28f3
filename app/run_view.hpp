// SPDX-License-Identifier: Apache-2.0
// A finished run on the page, and what people correct on it.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "app/results.hpp"
#include "app/robot_view.hpp"
#include "app/viewer.hpp"
#include "majak/core/parallel.hpp"
#include "majak/core/site.hpp"
#include "majak/draw/site_view.hpp"
#include "majak/map/occupancy_grid.hpp"

namespace majak::app {

class RunView {
 public:
  /// `kept`: the site as it is kept, whose edits are applied here. `folder`: of the run, where
  /// corrections are kept; nothing: they last as long as this.
  RunView(Viewer& viewer, Site kept, std::optional<std::filesystem::path> folder, Threads threads);
  /// Writes the run's files anew where they are older than the corrections.
  ~RunView();
  RunView(const RunView&) = delete;
  RunView& operator=(const RunView&) = delete;

 private:
  void begin();
  void run(const serve::Command& command);
  void edit(const serve::Edit& wanted);
  void undo();
  void redo();
  void switch_closure(const serve::SwitchClosure& wanted);
  void localize(const serve::Localize& wanted);
  void stop_localizing();
  RobotView& robot();
  void change(bool poses, const std::function<void(Site&)>& how);
  void tell_changes();
  void tell_changed_scans(const draw::SiteView& view);
  void tell_walls();
  void make_walls();
  void write_files();
  bool localizing() const { return robot_ != nullptr; }

  Viewer& viewer_;
  std::optional<std::filesystem::path> folder_;
  Threads threads_;
  RunOptions options_;
  Site kept_;
  std::shared_ptr<const Site> shown_;
  std::shared_ptr<const Site> told_;  ///< as it was when all was told
  std::vector<bool> changed_;         ///< scans that have looked otherwise since
  map::OccupancyGrid grid_;
  std::vector<Edit> undone_;    ///< that can be made again, the last one first
  bool files_are_old_ = false;  ///< the run's other files do not have the corrections yet
  std::unique_ptr<RobotView> robot_;

  // Walls as lines take seconds: they are made aside, and told when they are still true.
  std::mutex walls_mutex_;
  std::condition_variable walls_wanted_;
  std::shared_ptr<const Site> walls_of_;  ///< to be made; nothing: none
  bool ended_ = false;
  std::thread wall_maker_;
};

}  // namespace majak::app
