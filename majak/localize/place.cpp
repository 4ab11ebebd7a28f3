// SPDX-License-Identifier: Apache-2.0
#include "majak/localize/place.hpp"

#include <cmath>
#include <utility>

#include "majak/core/error.hpp"
#include "majak/map/occupancy_grid.hpp"
#include "majak/map/segment_raster.hpp"
#include "majak/match/map_surfaces.hpp"

namespace majak::localize {
namespace {

PlacePtr make(map::KnownMap known, map::SurfelMap surfaces, double surface_sigma,
              const match::LikelihoodFieldOptions& options) {
  if (known.area(map::CellState::occupied) == 0)
    throw Error("the map has no wall in it: no cell is occupied");
  if (known.area(map::CellState::free) == 0)
    throw Error("the map has no free space: no cell in which a robot could be");
  map::DistanceField distances(known);
  match::LikelihoodField likelihood(known, distances, options);
  return std::make_shared<const Place>(Place{std::move(known), std::move(distances),
                                             std::move(likelihood), std::move(surfaces),
                                             surface_sigma});
}

}  // namespace

PlacePtr place_of(map::KnownMap known, const match::LikelihoodFieldOptions& options) {
  map::SurfelMap surfaces = match::surfaces(known);
  const double within_a_cell = known.resolution / std::sqrt(12.0);
  return make(std::move(known), std::move(surfaces), within_a_cell, options);
}

PlacePtr place_of(const Site& site, const match::LikelihoodFieldOptions& options) {
  return make(map::known_map(map::build_occupancy_grid(site)), match::surfaces(site), 0, options);
}

PlacePtr place_of(std::span<const map::Segment> segments,
                  const match::LikelihoodFieldOptions& options) {
  return make(map::known_map(segments), match::surfaces(segments), 0, options);
}

}  // namespace majak::localize
