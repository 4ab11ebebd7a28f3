// SPDX-License-Identifier: Apache-2.0
// Corrections by hand, put to use (docs/MATH.md, "Corrected by hand"). A Site keeps what was
// measured and, beside it, what people corrected; with_edits() makes the site that everything else
// works on. io::read_site() does that, so nobody who reads a run can forget it.
//
//   Site shown = with_edits(site);
//   add_edit(site, anchored(shown, EditKind::erase, polygon));
//
// Points are in the frame of the poses of the site that is handed over: to tell or to take points
// of the map as it is shown, hand over the site that is shown.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "majak/core/site.hpp"
#include "majak/map/known_map.hpp"
#include "majak/map/occupancy_grid.hpp"
#include "majak/map/segments.hpp"

namespace majak::map {

/// An edit of a polygon or a line whose points hang on the key scans nearest to them (on any scan
/// where there are no key scans). Throws Error for points that are not finite or too few, and for a
/// site without scans.
Edit anchored(const Site& site, EditKind kind, std::span<const Vec2> points);

/// Where the points of an edit lie in the map as it stands.
std::vector<Vec2> points_in_map(const Site& site, const Edit& edit);

/// All polygons or lines of that kind, but those on scans without a place.
std::vector<std::vector<Vec2>> shapes_in_map(const Site& site, EditKind kind);

/// Adds it with the next id. Throws Error for a closure_off that names no closure, or one that is
/// off already, and for an angle that is no number.
void add_edit(Site& site, Edit edit);
/// Switches a closure off by an edit, or on again by taking that edit out of the list, wherever it
/// is in it. Throws Error where there is no such closure or it is so already. The map is then to be
/// optimised anew (slam/reoptimise).
void switch_closure(Site& site, std::size_t from, std::size_t to, bool on);

/// Takes the last edit off; nothing where there is none.
std::optional<Edit> undo_edit(Site& site);

/// The angle of all turns together, rad.
double turn_of(const Site& site);

/// The site as it is to be used. Returns that a polygon erases or a crop leaves out become
/// erased(): the beam was free so far, and what ended it does not count. Poses, covariances and
/// weak directions are turned. Edits stay listed. A site that is so already stays as it is.
Site with_edits(Site site);

/// Walls drawn by hand are occupied, a cell thick; outside a crop nothing is known.
/// build_occupancy_grid() does it.
void draw_edits(OccupancyGrid& grid, const Site& site);

/// Walls drawn by hand as segments that count as seen in `scans` scans; build_segments() adds them.
std::vector<Segment> drawn_walls(const Site& site, std::size_t scans);

/// Cells of forbidden zones, those that they only touch too, become unknown: no planner enters what
/// is not known to be free. Or `as` what is wanted.
void forbid(KnownMap& known, const Site& site, CellState as = CellState::unknown);

/// Even-odd rule; points on a side may count either way.
bool inside(std::span<const Vec2> polygon, const Vec2& point);

/// By how much the walls lie turned against the map's axes, rad in [-pi/4, pi/4): a turn by as much
/// the other way makes the map upright. Nothing where no straight wall was seen.
std::optional<double> main_direction(const Site& site);

}  // namespace majak::map
