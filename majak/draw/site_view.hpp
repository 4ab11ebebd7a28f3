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

namespace majak::draw {

struct SiteViewOptions {
  bool keys_only = false;  ///< scans between key scans are left out
  std::string state = "finished";
  std::string version;           ///< of the program
  std::vector<std::string> may;  ///< commands that whoever serves the view will take
  std::uint32_t generation = 0;  ///< a viewer forgets what belongs to another one
};

class SiteView {
 public:
  /// `site` must have a scan.
  SiteView(std::shared_ptr<const Site> site, SiteViewOptions options);

  /// What is small and comes first: the run, its closures, its graph, the truth laid onto the map.
  std::vector<std::string> head() const;

  /// Every scan's estimate, then the key scans, then the scans between them.
  std::size_t size() const { return estimates_.size() + scans_.size(); }
  std::string record(std::size_t i) const;

 private:
  std::string run() const;
  std::string closures() const;
  std::string estimate(std::size_t scan) const;

  std::shared_ptr<const Site> site_;
  SiteViewOptions options_;
  std::vector<std::size_t> estimates_, scans_;  ///< numbers of scans, as they are told
  std::vector<std::uint32_t> key_of_, laser_of_;
  std::vector<Pose2> lasers_;  ///< mountings
};

}  // namespace majak::draw
