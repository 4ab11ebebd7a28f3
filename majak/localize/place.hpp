// SPDX-License-Identifier: Apache-2.0
// Place: a known map with all that localization looks up in it. Made once, shared by all methods.
#pragma once

#include <memory>
#include <span>

#include "majak/core/site.hpp"
#include "majak/map/distance_field.hpp"
#include "majak/map/known_map.hpp"
#include "majak/map/segments.hpp"
#include "majak/map/surfel_map.hpp"
#include "majak/match/likelihood_field.hpp"

namespace majak::localize {

struct Place {
  map::KnownMap known;
  map::DistanceField distances;
  match::LikelihoodField likelihood;
  map::SurfelMap surfaces;
  double surface_sigma = 0;  ///< m, by which they may lie beside the walls: within a cell
};
using PlacePtr = std::shared_ptr<const Place>;

/// Of a map file. Throws Error where nobody could be localized: no wall in it, or no free cell.
PlacePtr place_of(map::KnownMap known, const match::LikelihoodFieldOptions& options = {});

/// Of a run: its surfaces are where its scans saw them, not where cells lie.
PlacePtr place_of(const Site& site, const match::LikelihoodFieldOptions& options = {});

/// Of a segment map: its surfaces are where its segments lie.
PlacePtr place_of(std::span<const map::Segment> segments,
                  const match::LikelihoodFieldOptions& options = {});

}  // namespace majak::localize
