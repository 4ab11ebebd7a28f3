// SPDX-License-Identifier: Apache-2.0
// A finished run as the records that a viewer is told (io/view_records), each made when it is asked
// for: what is seen costs no second copy of the scans.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "majak/core/site.hpp"
#include "majak/map/occupancy_grid.hpp"

namespace majak::draw {

/// What the page has to know of a run, or of the work on one.
struct RunTold {
  std::string name, state;
  std::size_t scans = 0;
  Time begin = 0, end = 0;
  std::vector<Pose2> lasers;  ///< mountings
  std::string version{};
  std::vector<std::string> may{};
  std::vector<std::string> findings{};
  Report report{};
  std::uint32_t generation = 0;
};
std::string view_run(const RunTold& run);

/// The number of a mounting among them; a new one joins them.
std::size_t laser_number(std::vector<Pose2>& lasers, const Pose2& T_robot_laser);

struct SiteViewOptions {
  bool keys_only = false;             ///< scans between key scans are left out
  std::size_t most_scans = SIZE_MAX;  ///< that are told; of more, evenly some
  std::string state = "finished";
  std::string version{};           ///< of the program
  std::vector<std::string> may{};  ///< commands that whoever serves the view will take
  std::uint32_t generation = 0;    ///< a viewer forgets what belongs to another one
};

class SiteView {
 public:
  /// `site`: as it is to be used, with its edits; with a scan at least.
  SiteView(std::shared_ptr<const Site> site, SiteViewOptions options);

  // Records that are told at once.
  std::string run() const;
  std::string graph() const;
  std::string closures() const;
  std::string edits(bool can_redo, bool kept) const;  ///< kept: they are on the disk
  std::string truth() const;      ///< laid onto the map; empty where there is none
  std::string estimates() const;  ///< of all scans, one record each

  /// Scans, one by one: the key scans, then those between them.
  std::size_t scans() const { return scans_.size(); }
  std::string scan(std::size_t i) const { return scan_number(scans_[i]); }
  /// By its number in the run.
  std::string scan_number(std::size_t number) const;

 private:
  std::shared_ptr<const Site> site_;
  SiteViewOptions options_;
  std::vector<std::size_t> scans_;  ///< their numbers, as they are told
  std::vector<std::uint32_t> laser_of_;
  std::vector<Pose2> lasers_;  ///< mountings
};

/// All of that and the grid as one stream.
std::string view_stream(const SiteView& view, const map::OccupancyGrid& grid);

}  // namespace majak::draw
