// SPDX-License-Identifier: Apache-2.0
// A run cut in two: some of its scans make the map, the others are questions to it.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/core/site.hpp"
#include "majak/io/source.hpp"
#include "majak/localize/place.hpp"
#include "majak/localize/scan_feed.hpp"
#include "majak/match/beams.hpp"

namespace majak::bench {

/// m, or rad turned, whichever is more.
inline double way_of(const Pose2& step) {
  return std::max(step.translation().norm(), std::abs(step.theta));
}

// Two cuts: of each scan the number of its piece; even ones make the map.
inline std::vector<int> by_minutes(const Site& site) {
  std::vector<int> piece;
  for (const PosedScan& s : site.scans)
    piece.push_back(
        static_cast<int>((s.scan.time - site.scans.front().scan.time) / (60 * kSecond)));
  return piece;
}
inline std::vector<int> by_way(const Site& site, double length = 12) {
  std::vector<int> piece;
  double way = 0;
  for (std::size_t i = 0; i < site.scans.size(); ++i) {
    if (i > 0)
      way += way_of(
          between(site.scans[i - 1].estimate.T_map_robot, site.scans[i].estimate.T_map_robot));
    piece.push_back(static_cast<int>(way / length));
  }
  return piece;
}

/// The scans of the log that a run is of, each with the motion before it; numbered as the run's.
inline std::vector<localize::FedScan> scans_of(const std::string& log, const Site& site) {
  localize::ScanFeed feed;
  std::vector<localize::FedScan> scans;
  const auto take = [&] {
    while (auto scan = feed.next()) {
      scans.push_back(std::move(*scan));
      feed.observe(scans.back().T_previous_robot, false);
    }
  };
  const auto source = io::open_log(log);
  while (const auto event = source->next()) feed.add(*event), take();
  feed.end(), take();
  if (scans.size() != site.scans.size()) throw Error("the run is not of this log");
  return scans;
}

struct SplitSite {
  Site site;
  std::vector<int> piece;
  localize::PlacePtr place;
  std::vector<bool> covered;  ///< of each scan: it stands on known floor, and 70 % of what it sees
                              ///< is on the map

  SplitSite(Site run, std::vector<int> pieces) : site(std::move(run)), piece(std::move(pieces)) {
    Site half;
    half.source_name = site.source_name;
    for (std::size_t i = 0; i < piece.size(); ++i)
      if (piece[i] % 2 == 0) half.scans.push_back(site.scans[i]);
    place = localize::place_of(half);
    for (const PosedScan& s : site.scans) covered.push_back(covers(s));
  }

  /// Covered scans of pieces that did not make the map.
  std::vector<std::size_t> questions() const {
    std::vector<std::size_t> found;
    for (std::size_t q = 0; q < piece.size(); ++q)
      if (piece[q] % 2 != 0 && covered[q]) found.push_back(q);
    return found;
  }
  /// Scans first ... last are of one piece, and at least `share` of them are covered.
  bool knows(std::size_t first, std::size_t last, double share) const {
    if (last >= piece.size() || piece[first] != piece[last]) return false;
    const auto begin = covered.begin() + static_cast<std::ptrdiff_t>(first),
               end = covered.begin() + static_cast<std::ptrdiff_t>(last) + 1;
    return static_cast<double>(std::count(begin, end, true)) >=
           share * static_cast<double>(end - begin);
  }
  /// Questions from which the robot goes `way` (see way_of) that the map knows so far.
  std::vector<std::size_t> starts(double way, double share) const {
    std::vector<std::size_t> found;
    for (const std::size_t q : questions()) {
      std::size_t last = q;
      for (double left = way; left > 0 && ++last < piece.size();)
        left -= way_of(between(site.scans[last - 1].estimate.T_map_robot,
                               site.scans[last].estimate.T_map_robot));
      if (knows(q, last, share)) found.push_back(q);
    }
    if (found.empty()) throw Error("no scan to start from");
    return found;
  }
  Pose2 error(std::size_t i, const Pose2& T_map_robot) const {
    return between(site.scans[i].estimate.T_map_robot, T_map_robot);
  }
  /// Within 0.5 m and 10 degrees of where the run puts the scan.
  bool right(std::size_t i, const Pose2& T_map_robot) const {
    const Pose2 off = error(i, T_map_robot);
    return off.translation().norm() < 0.5 && std::abs(off.theta) < radians(10);
  }

 private:
  bool covers(const PosedScan& s) const {
    const Pose2& at = s.estimate.T_map_robot;
    const match::Beams beams = match::beams(s.scan);
    std::size_t on = 0;
    for (std::size_t k = 0; k < beams.returns; ++k)
      on += place->distances.at(at * Vec2(beams.x[k], beams.y[k])) < 0.15;
    return beams.returns >= 20 && 10 * on >= 7 * beams.returns &&
           place->known.at(at.translation()) == map::CellState::free;
  }
};

}  // namespace majak::bench
