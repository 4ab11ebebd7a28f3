// SPDX-License-Identifier: Apache-2.0
// What a laser out of the plane has seen, as points in space: the beams of its scans at the poses
// of a site, gathered in cubes, so that memory follows the place and not the log. MATH 22.1.
//
//   SolidPoints points(site, mounting);
//   while (auto event = log.next())
//     if (const auto* scan = std::get_if<Scan>(&*event)) points.add(*scan);
//   const SolidCloud cloud = points.cloud();
#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "majak/core/parallel.hpp"
#include "majak/core/report.hpp"
#include "majak/map/laser_mounting.hpp"
#include "majak/map/trajectory.hpp"

namespace majak::map {

struct SolidPointsOptions {
  double voxel = 0.1;             ///< m, side of a cube
  double min_range = 0.1;         ///< m, shorter beams are left out (the robot itself) ...
  double max_range = 20;          ///< m, ... and longer ones
  double max_edge = 0.3;          ///< m, neighbouring beams farther apart are of two things
  double max_gap = 1;             ///< s, between scans of the site, for a pose between them
  double mirror_turn = 1.0 / 75;  ///< s, of the laser's mirror; 0: all beams at the scan's stamp
};

inline void describe(OptionFields& fields, SolidPointsOptions& o) {
  fields.add("points.voxel", o.voxel, {"m", "side of a cube", 0.01, 10});
  fields.add("points.min_range", o.min_range, {"m", "shorter beams are left out", 0, 100});
  fields.add("points.max_range", o.max_range, {"m", "longer beams are left out", 0.1, 1000});
  fields.add("points.max_edge", o.max_edge,
             {"m", "neighbouring beams farther apart are of two things", 0.01, 100});
  fields.add("points.max_gap", o.max_gap, {"s", "between the site's scans", 0.01, 1000});
  fields.add("points.mirror_turn", o.mirror_turn, {"s", "of the laser's mirror, 0: none", 0, 1});
}

/// All returns of one cube. Map frame, z up.
struct SolidPoint {
  Vec3 mean = Vec3::Zero();     ///< m
  Vec3 normal = Vec3::Zero();   ///< unit, towards the laser; zero where neighbours do not tell
  Vec3 towards = Vec3::Zero();  ///< unit, to the laser, on average
  double variance_z = 0;        ///< m^2, of the returns' heights
  int count = 0;
  float intensity = 0;  ///< mean, raw units; 0 where the scans have none
  std::array<std::int32_t, 3> cell{};
};

struct SolidCloud {
  double voxel = 0.1;              ///< m
  std::vector<SolidPoint> points;  ///< by cell: z, then y, then x
  /// Of neighbouring beams of one scan and the next, numbers into `points`, counter-clockwise as
  /// the laser saw them; an edge is of two at most.
  std::vector<std::array<std::uint32_t, 3>> triangles;
  bool has_intensity = false;
  /// Number of the point in that cell, -1 for none.
  std::int64_t find(const std::array<std::int32_t, 3>& cell) const;
};

class SolidPoints {
 public:
  /// Throws Error when an option is out of its range.
  SolidPoints(const Site& site, const LaserMounting& mounting,
              const SolidPointsOptions& options = {}, TiltTrack tilt = {});

  /// Scans of other lasers than the mounting's are passed over.
  void add(const Scan& scan);

  /// With normals: of the points in a cube and its 26 neighbours that were seen from the same side,
  /// where they are flat.
  SolidCloud cloud() const;

  /// What was left out, and why.
  const Report& report() const { return report_; }
  std::size_t beams() const { return beams_; }  ///< that count

 private:
  struct Voxel {
    Vec3 sum = Vec3::Zero(), towards = Vec3::Zero();  // m; of unit vectors to the laser
    double sum_zz = 0, intensity = 0;
    std::int32_t count = 0;
    std::array<std::int32_t, 3> cell{};
  };
  static constexpr std::uint32_t kNone = UINT32_MAX;
  struct Seen {
    std::uint32_t voxel = kNone;
    Vec3 at = Vec3::Zero();
  };

  Seen see(const Scan& scan, std::size_t beam);
  std::uint32_t put(const Vec3& p, const Vec3& laser, float intensity);
  void join(const std::vector<Seen>& seen);
  void triangle(const Seen& a, const Seen& b, const Seen& c);

  LaserMounting mounting_;
  SolidPointsOptions options_;
  Trajectory trajectory_;
  TiltTrack tilt_;
  std::vector<Voxel> voxels_;  // in the order in which they were seen
  std::unordered_map<std::uint64_t, std::uint32_t> index_;
  std::unordered_map<std::uint64_t, std::uint8_t> edges_;  // how many triangles have it
  std::vector<std::array<std::uint32_t, 3>> triangles_;    // of voxels_
  std::vector<Seen> last_;
  Time last_time_ = 0;
  std::size_t beams_ = 0;
  bool has_intensity_ = false;
  Report report_;
};

}  // namespace majak::map
