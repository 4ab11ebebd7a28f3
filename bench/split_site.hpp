// SPDX-License-Identifier: Apache-2.0
// A run with the scans of its log, cut into pieces of 12 m of way (a radian counts as a metre):
// every other piece makes the map, the robot is localized in the others.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/io/site_file.hpp"
#include "majak/io/source.hpp"
#include "majak/localize/place.hpp"
#include "majak/localize/scan_feed.hpp"
#include "majak/match/beams.hpp"

namespace majak::bench {

inline double way_of(const Pose2& step) {
  return std::max(step.translation().norm(), std::abs(step.theta));
}

struct SplitSite {
  Site site;
  std::vector<localize::FedScan> scans;  ///< numbered as those of the site
  std::vector<int> piece;                ///< of each scan; even ones make the map
  localize::PlacePtr place;
  std::vector<bool> covered;  ///< on known floor, and 70 % of what it sees is on the map

  SplitSite(const std::string& site_file, const std::string& log) : site(io::read_site(site_file)) {
    read_scans(log);
    if (scans.size() != site.scans.size()) throw Error("the run is not of this log");
    cut();
  }

  /// Scans of a question piece that are covered and have `way` left in their piece.
  std::vector<std::size_t> starts(double way) const {
    std::vector<std::size_t> found;
    for (std::size_t q = 0; q < scans.size(); ++q) {
      if (piece[q] % 2 == 0 || !covered[q]) continue;
      double left = 0;
      for (std::size_t i = q + 1; i < scans.size() && piece[i] == piece[q]; ++i)
        left += way_of(scans[i].T_previous_robot);
      if (left >= way) found.push_back(q);
    }
    if (found.empty()) throw Error("no scan to start from");
    return found;
  }
  Pose2 error(std::size_t i, const Pose2& T_map_robot) const {
    return between(site.scans[i].estimate.T_map_robot, T_map_robot);
  }
  bool right(std::size_t i, const Pose2& T_map_robot) const {
    const Pose2 off = error(i, T_map_robot);
    return off.translation().norm() < 0.5 && std::abs(off.theta) < radians(10);
  }

 private:
  void read_scans(const std::string& log) {
    localize::ScanFeed feed;
    const auto take = [&] {
      while (auto scan = feed.next()) {
        scans.push_back(std::move(*scan));
        feed.observe(scans.back().T_previous_robot, false);
      }
    };
    const auto source = io::open_log(log);
    while (const auto event = source->next()) feed.add(*event), take();
    feed.end(), take();
  }
  void cut() {
    Site half;
    half.source_name = site.source_name;
    double way = 0;
    for (std::size_t i = 0; i < scans.size(); ++i) {
      if (i > 0)
        way += way_of(
            between(site.scans[i - 1].estimate.T_map_robot, site.scans[i].estimate.T_map_robot));
      piece.push_back(static_cast<int>(way / 12));
      if (piece.back() % 2 == 0) half.scans.push_back(site.scans[i]);
    }
    place = localize::place_of(half);
    for (const PosedScan& s : site.scans) {
      const match::Beams beams = match::beams(s.scan);
      std::size_t on = 0;
      for (std::size_t k = 0; k < beams.returns; ++k)
        on += place->distances.at(s.estimate.T_map_robot * Vec2(beams.x[k], beams.y[k])) < 0.15;
      covered.push_back(beams.returns >= 20 && 10 * on >= 7 * beams.returns &&
                        place->known.at(s.estimate.T_map_robot.translation()) ==
                            map::CellState::free);
    }
  }
};

}  // namespace majak::bench
