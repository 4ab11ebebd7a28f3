// SPDX-License-Identifier: Apache-2.0
// Relations: how the segments of a map lie to each other, as a graph whose nodes are segments:
// parallel, perpendicular, collinear, corner, opening. Each is a test against the segments' own
// covariance, with a tolerance for what walls are off in real buildings. MATH 15.7.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "majak/core/options.hpp"
#include "majak/map/segments.hpp"

namespace majak::map {

enum class RelationKind : std::uint8_t {
  parallel,       ///< beside each other for a part of their length; value: m between the lines
  perpendicular,  ///< turned by a right angle, ends or lines near; value: rad off it
  collinear,      ///< on one line, facing the same side; value: m of the gap between
  corner,         ///< an end of each in one place; value: rad, the angle between the walls inside
  opening,        ///< collinear, and a gap that one can pass; value: m, its clear width
};
const char* name_of(RelationKind kind);

/// An edge of the graph, first < second. Two segments may have several.
struct Relation {
  RelationKind kind = RelationKind::parallel;
  std::size_t first = 0, second = 0;  ///< numbers of segments
  double value = 0;                   ///< see the kind
  double sigma = 0;                   ///< of the value, from the segments' covariances
  Vec2 place = Vec2::Zero();          ///< m: of a corner, middle of a gap, else between the middles
};

struct RelationOptions {
  double max_turn = 0.05;    ///< rad, off parallel or the right angle, besides 3 sigma
  double max_offset = 0.05;  ///< m, between the lines of collinear ones, besides 3 sigma
  double max_distance = 4;   ///< m, between parallel ones
  double max_gap = 3;        ///< m, between collinear ones
  double corner_gap = 0.1;   ///< m, between the ends that meet in a corner
  double min_corner = 0.35;  ///< rad, between the lines that make one
  double min_opening = 0.6;  ///< m, a robot or a person passes ...
  double max_opening = 2.5;  ///< m, ... and it is no hall
  double min_length = 0.3;   ///< m; shorter segments have corners only
};

inline void describe(OptionFields& fields, RelationOptions& o) {
  fields.add("relations.max_turn", o.max_turn, {"rad", "off parallel or a right angle", 0, 0.5});
  fields.add("relations.max_offset", o.max_offset, {"m", "between lines of collinear ones", 0, 1});
  fields.add("relations.max_distance", o.max_distance, {"m", "between parallel ones", 0, 100});
  fields.add("relations.max_gap", o.max_gap, {"m", "between collinear ones", 0, 100});
  fields.add("relations.corner_gap", o.corner_gap, {"m", "between ends that meet", 0, 1});
  fields.add("relations.min_corner", o.min_corner, {"rad", "between lines that meet", 0.05, 1.5});
  fields.add("relations.min_opening", o.min_opening, {"m", "narrower ones nobody passes", 0, 10});
  fields.add("relations.max_opening", o.max_opening, {"m", "wider ones are no door", 0, 100});
  fields.add("relations.min_length", o.min_length, {"m", "shorter have corners only", 0, 100});
}

/// All relations, by first, then second, then kind. Only those that lie within reach of each other
/// are asked: time follows the segments, not their square.
std::vector<Relation> relations(std::span<const Segment> segments,
                                const RelationOptions& options = {});

}  // namespace majak::map
