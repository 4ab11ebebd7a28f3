// SPDX-License-Identifier: Apache-2.0
// The faces of a Site: one way each to look at the same place. A new face is a builder in map/, a
// function here that says it as a page, and a row in faces.cpp.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "majak/core/options.hpp"
#include "majak/core/parallel.hpp"
#include "majak/core/site.hpp"
#include "majak/draw/figure.hpp"
#include "majak/io/summary.hpp"
#include "majak/map/contours.hpp"
#include "majak/map/doors.hpp"
#include "majak/map/elevation.hpp"
#include "majak/map/forward_grid.hpp"
#include "majak/map/inflation.hpp"
#include "majak/map/intensity.hpp"
#include "majak/map/objects.hpp"
#include "majak/map/occupancy_grid.hpp"
#include "majak/map/planes.hpp"
#include "majak/map/raised_walls.hpp"
#include "majak/map/relations.hpp"
#include "majak/map/room_labels.hpp"
#include "majak/map/segment_map.hpp"
#include "majak/map/solid_map.hpp"
#include "majak/map/topology.hpp"
#include "majak/map/visits.hpp"

namespace majak::draw {

struct FaceFile {
  std::string name, bytes;
};

/// A face as people look at it.
struct FacePage {
  std::string lead;  ///< plain text: what is seen, and how sure it is
  Figure figure;
  std::vector<io::NamedFigure> figures;  ///< the name ends in its unit
  std::size_t bytes = 0;                 ///< that the face itself takes in memory
  std::vector<FaceFile> files;           ///< for programs
};

/// A robot as the planner's face has it.
struct RobotSize {
  double radius = 0.3;  ///< m
};

/// When the map of the dynamics' face is shown as it was.
struct MapTime {
  double time = -1;       ///< s since the first scan; less than 0: the cells by kind instead
  bool hindsight = true;  ///< false: what was believed then
};

struct FaceOptions {
  map::OccupancyGridOptions grid;
  map::SegmentMapOptions segments;
  std::vector<map::Segment> known_walls;  ///< map frame: what the segments begin with
  map::ForwardGridOptions forward;
  map::IntensityOptions intensity;
  RobotSize robot;
  map::InflationOptions inflation;
  map::RelationOptions relations;
  map::TopologyOptions rooms;
  std::vector<map::RoomLabel> labels;  ///< names that people gave to rooms
  map::RaiseOptions raise;
  map::PlaneOptions planes;
  map::SolidOptions solid;
  map::ElevationOptions elevation;
  /// What a laser out of the plane has seen; null: nothing.
  const map::SolidCloud* cloud = nullptr;
  map::DynamicsOptions dynamics;  ///< its grid is `grid`
  MapTime map_at;
  map::DoorOptions doors;
  map::VisitOptions visits;
  map::ObjectOptions objects;
  Threads threads;
};
void describe(OptionFields& fields, FaceOptions& options);

struct Face {
  const char* name;
  const char* after;  ///< whose idea it was, an other name for it: "moravec-elfes"; or empty
  const char* shows;
  /// Throws Error where the site cannot be looked at so, and says why.
  FacePage (*make)(const Site& site, const FaceOptions& options);
};

std::span<const Face> faces();

/// By its name or by whose idea it was. Throws Error that lists the names there are.
const Face& face(std::string_view name);

FacePage sensor_face(const Site& site, const FaceOptions& options);
FacePage occupancy_face(const Site& site, const FaceOptions& options);
FacePage inflated_face(const Site& site, const FaceOptions& options);
FacePage forward_face(const Site& site, const FaceOptions& options);
FacePage intensity_face(const Site& site, const FaceOptions& options);
FacePage dynamics_face(const Site& site, const FaceOptions& options);
FacePage objects_face(const Site& site, const FaceOptions& options);
FacePage segments_face(const Site& site, const FaceOptions& options);
FacePage relations_face(const Site& site, const FaceOptions& options);
FacePage rooms_face(const Site& site, const FaceOptions& options);
FacePage raised_face(const Site& site, const FaceOptions& options);
FacePage solid_face(const Site& site, const FaceOptions& options);
FacePage elevation_face(const Site& site, const FaceOptions& options);

/// The same page of any walls, and of the walls of a map of cells (m of T_world_map's world), with
/// what the conversion lost and made up. Throws Error when there is none.
FacePage segments_page(const std::vector<map::Segment>& walls,
                       const std::vector<std::vector<Vec2>>& forbidden = {});
FacePage contours_page(const map::KnownMap& map, const Pose2& T_world_map);

/// A page that went well, or why it did not.
struct MadeFace {
  const Face* face = nullptr;
  FacePage page{};
  std::string error{};  ///< empty: it went well
  double seconds = 0;   ///< that it took
};

/// All of them in one file that needs nothing else. `name` of the place.
std::string faces_html(const std::string& name, std::span<const MadeFace> made);

}  // namespace majak::draw
