// SPDX-License-Identifier: Apache-2.0
// A run cut in two: some of its scans make the map, the others are questions to it.
#pragma once

#include <vector>

#include "majak/core/site.hpp"
#include "majak/localize/place.hpp"
#include "majak/match/beams.hpp"

namespace majak::bench {

struct Halves {
  localize::PlacePtr place;
  std::vector<bool> covered;           ///< of each scan: it stands on known floor, and 70 % of
                                       ///< what it sees is on the map
  std::vector<std::size_t> questions;  ///< scans that are covered and did not make the map
};

inline std::vector<bool> every_other_minute(const Site& site) {
  std::vector<bool> known;
  for (const PosedScan& s : site.scans)
    known.push_back((s.scan.time - site.scans.front().scan.time) / (60 * kSecond) % 2 == 0);
  return known;
}

/// `known`: which scans make the map.
inline Halves split(const Site& site, const std::vector<bool>& known) {
  Site half;
  half.source_name = site.source_name;
  for (std::size_t i = 0; i < known.size(); ++i)
    if (known[i]) half.scans.push_back(site.scans[i]);
  Halves halves{localize::place_of(half), std::vector<bool>(known.size()), {}};
  const localize::Place& place = *halves.place;
  for (std::size_t i = 0; i < known.size(); ++i) {
    const PosedScan& s = site.scans[i];
    const match::Beams beams = match::beams(s.scan);
    std::size_t on = 0;
    for (std::size_t k = 0; k < beams.returns; ++k)
      on += place.distances.at(s.estimate.T_map_robot * Vec2(beams.x[k], beams.y[k])) < 0.15;
    halves.covered[i] =
        beams.returns >= 20 && 10 * on >= 7 * beams.returns &&
        place.known.at(s.estimate.T_map_robot.translation()) == map::CellState::free;
    if (halves.covered[i] && !known[i]) halves.questions.push_back(i);
  }
  return halves;
}

}  // namespace majak::bench
