// SPDX-License-Identifier: Apache-2.0
// The surfaces of a known map, for matching scans to them: those of a run lie where its scans saw
// them, to the millimetre; those of a map file are read off its occupied cells.
#pragma once

#include <span>

#include "majak/core/site.hpp"
#include "majak/map/known_map.hpp"
#include "majak/map/segments.hpp"
#include "majak/map/surfel_map.hpp"

namespace majak::match {

/// From the key scans at their final poses; all scans if there are no key scans.
map::SurfelMap surfaces(const Site& site);

/// From the occupied cells that border on free ones: mean and normal of those around each.
map::SurfelMap surfaces(const map::KnownMap& map);

/// On the segments themselves, a surfel each 5 cm.
map::SurfelMap surfaces(std::span<const map::Segment> segments);

}  // namespace majak::match
