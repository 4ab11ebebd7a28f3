// SPDX-License-Identifier: Apache-2.0
// SegmentMap: a place as straight pieces of its surfaces, each once, however often and in whatever
// parts it was seen. The eight steps of the method are functions of their own; poses are taken to
// be exact. MATH 15.3.
//
//   SegmentMap map(options);                            // 1 begin, empty or with what is known
//   for (const PosedScan& posed : site.scans) {         // 2 take a scan
//     auto seen = map.approximate(posed.scan, pose);    // 3 as segments
//     auto pairs = map.find_pairs(seen);                // 4 which may correspond
//     pairs = map.keep_good(pairs, seen);               // 5 the criterion
//     map.remove_passed(posed.scan, pose, pairs);       // 6 what beams pass through
//     map.update(seen, pairs);                          // 7 fuse, insert, merge
//   }                                                   // 8 repeat
#pragma once

#include <cstdint>

#include "majak/core/site.hpp"
#include "majak/map/segment_refinement.hpp"
#include "majak/map/segments.hpp"

namespace majak::map {

enum class Correspondence : std::uint8_t {
  thresholds,   ///< nearly parallel and close
  mahalanobis,  ///< (offset, turn) within their covariance
};

struct SegmentMapOptions {
  SegmentOptions scan;
  Correspondence correspondence = Correspondence::thresholds;
  double max_angle = 0.15;       ///< rad, between segments of one wall
  double max_distance = 0.05;    ///< m, between their lines where both were seen
  double max_gap = 0.3;          ///< m, along the line between them
  double pose_sigma = 0.01;      ///< m, for Mahalanobis: error of a pose across a wall ...
  double heading_sigma = 0.01;   ///< rad, ... and of its heading
  double chi2 = 9.21;            ///< for Mahalanobis: 99 % of 2 degrees of freedom
  int min_scans = 3;             ///< fewer make no wall of the result
  int removal_scans = 4;         ///< so many scans that see through a segment in turn remove it
  int removal_beams = 3;         ///< in each of them so many beams pass, and more than end there
  double removal_margin = 0.15;  ///< m, so far behind the segment (and inside its ends)
  double key_spacing = 0.15;     ///< m, a scan nearer than this to the last one taken and
  double key_turn = 0.15;        ///< rad, turned less is left out
  SegmentRefinementOptions refinement;
};

inline void describe(OptionFields& fields, SegmentMapOptions& o) {
  describe(fields, o.scan);
  fields.add("segment_map.max_angle", o.max_angle,
             {"rad", "between segments of one wall", 0.001, 1.5});
  fields.add("segment_map.max_distance", o.max_distance,
             {"m", "between their lines where both were seen", 0.001, 10});
  fields.add("segment_map.max_gap", o.max_gap, {"m", "along the line between them", 0, 100});
  fields.add("segment_map.pose_sigma", o.pose_sigma,
             {"m", "Mahalanobis: error of a pose across a wall", 0, 10});
  fields.add("segment_map.heading_sigma", o.heading_sigma,
             {"rad", "Mahalanobis: error of a heading", 0, 1});
  fields.add("segment_map.chi2", o.chi2, {"1", "Mahalanobis: two degrees of freedom", 0.1, 100});
  fields.add("segment_map.min_scans", o.min_scans, {"1", "fewer make no wall", 1, 1000});
  fields.add("segment_map.removal_scans", o.removal_scans,
             {"1", "so many that see through a segment in turn remove it", 1, 1000});
  fields.add("segment_map.removal_beams", o.removal_beams,
             {"1", "of a scan that pass, for it to count", 1, 1000});
  fields.add("segment_map.removal_margin", o.removal_margin,
             {"m", "behind a segment and inside its ends", 0.001, 10});
  fields.add("segment_map.key_spacing", o.key_spacing,
             {"m", "a scan nearer to the last one is left out unless it turned", 0, 100});
  fields.add("segment_map.key_turn", o.key_turn,
             {"rad", "a scan turned less is left out unless it moved", 0, 4});
  describe(fields, o.refinement);
}

/// A segment of the map and one of the scan that may be of the same wall.
struct SegmentPair {
  std::size_t map = 0, seen = 0;
  bool operator==(const SegmentPair&) const = default;
};

/// What the steps did with one scan: for logs, and to see which of them goes wrong.
struct SegmentSteps {
  Time time = 0;     ///< the scan's
  int seen = 0;      ///< 3: segments of the scan
  int pairs = 0;     ///< 4: that may correspond
  int kept = 0;      ///< 5: that meet the criterion; step 7 fuses each
  int removed = 0;   ///< 6: segments of the map that were seen through
  int inserted = 0;  ///< 7: as new
  int merged = 0;    ///< 7: segments of the map that became part of another
  int in_map = 0;    ///< afterwards
};

class SegmentMap {
 public:
  /// Step 1. `known`: map frame, what is known beforehand; its segments count as often as they
  /// state (Segment::scans).
  explicit SegmentMap(const SegmentMapOptions& options = {},
                      const std::vector<Segment>& known = {});

  /// Step 3: the scan's segments in the map's frame.
  std::vector<Segment> approximate(const Scan& scan, const Pose2& T_map_robot) const;

  /// Step 4: all pairs that face the same side and whose boxes, widened by max_gap, overlap.
  std::vector<SegmentPair> find_pairs(const std::vector<Segment>& seen) const;

  /// Step 5: of each seen segment the best pair that meets the criterion (see same_wall).
  std::vector<SegmentPair> keep_good(const std::vector<SegmentPair>& pairs,
                                     const std::vector<Segment>& seen) const;

  /// Step 6: removes the unmatched segments that this scan and those before it saw through, and
  /// mends the numbers in `pairs`. Returns what was removed. Beams without return tell nothing.
  std::vector<Segment> remove_passed(const Scan& scan, const Pose2& T_map_robot,
                                     std::vector<SegmentPair>& pairs);

  /// Step 7: fuses each pair, inserts what has none, then merges until no two are of one wall.
  /// Returns how many became part of another.
  int update(const std::vector<Segment>& seen, const std::vector<SegmentPair>& pairs);

  /// Steps 3 to 7.
  SegmentSteps add(const Scan& scan, const Pose2& T_map_robot);

  /// Everything, map frame.
  const std::vector<Segment>& segments() const { return segments_; }
  /// What was seen in min_scans scans or more.
  std::vector<Segment> walls() const;

 private:
  int merge_with_others(std::size_t changed);
  void erase(std::size_t index);

  SegmentMapOptions options_;
  std::vector<Segment> segments_;
  std::vector<int> passed_;  // scans in turn that saw through each
};

/// Are they parts of one wall? Both face the same side, lie along each other but for max_gap, and
/// either angle and distance are below their thresholds or the Mahalanobis distance is.
bool same_wall(const Segment& a, const Segment& b, const SegmentMapOptions& options);

/// The information-weighted line of both, with the extent of both. They must face the same side.
Segment fused(const Segment& a, const Segment& b);

/// The map of a site's scans at their final poses, in log order. Lost scans and poses that are not
/// finite are left out. Its walls are then refined (map/segment_refinement), unless the options say
/// no or something was `known` beforehand (map frame), which no return need bear out. Walls drawn
/// by hand (map/edits) come last, as they are. `log`: gets a row for each scan taken. Throws Error
/// when an option is out of its range.
SegmentMap build_segments(const Site& site, const SegmentMapOptions& options = {},
                          std::vector<SegmentSteps>* log = nullptr,
                          const std::vector<Segment>& known = {});

}  // namespace majak::map
