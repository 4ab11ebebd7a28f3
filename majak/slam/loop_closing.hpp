// SPDX-License-Identifier: Apache-2.0
// Loop closing: finds places that were seen before and says by how much the trajectory is off
// there. Works on submaps (a few metres of neighbouring key scans): they are more telling than
// single scans and few enough to look at all of them. A closure is accepted only with its evidence.
#pragma once

#include <array>
#include <cstddef>
#include <deque>
#include <memory>
#include <utility>
#include <vector>

#include "majak/graph/optimize.hpp"
#include "majak/map/surfel_map.hpp"
#include "majak/match/correlative.hpp"
#include "majak/match/point_to_line.hpp"
#include "majak/slam/key_scan.hpp"
#include "majak/slam/ways.hpp"

namespace majak::slam {

struct LoopClosingOptions {
  int submap_keys = 8;              ///< a submap is this many key scans ...
  int submap_margin = 8;            ///< ... and sees this many more on either side
  double near = 5.0;                ///< m, places nearer than this should see the same walls
  int candidates = 3;               ///< places tried for a submap
  double search_score = 0.50;       ///< least mean likelihood in a window search
  double agreement = 0.85;          ///< least share of comparable returns that agree
  double overlap = 0.30;            ///< least share of returns that can be compared and agree
  double drift_translation = 0.01;  ///< m per m of way: the front end's drift, for the windows
  double drift_rotation = 0.015;    ///< rad per sqrt(m)
  double weak_step = 30.0;          ///< m of way that a step not to be trusted counts for
  double weak_rotation = 1.6;       ///< rad, half width of the search beyond it
  double starving = 10.0;   ///< m without a closure though places are near: search the window
  double max_window = 8.0;  ///< m
  double certain_agreement = 0.95;  ///< with these, a searched closure needs no second witness
  double certain_overlap = 0.45;
  /// Closures that are not to be used, by the scans they join; they are listed all the same.
  std::vector<std::pair<std::size_t, std::size_t>> switched_off;
};

/// A place recognised, with its evidence. Relative pose between the anchors' robots.
struct Closure {
  std::size_t from_key = 0, to_key = 0;  ///< anchors: from is the older
  Pose2 T_from_to;
  Mat3 information = Mat3::Zero();  ///< axes of `to`
  double agreement = 0;             ///< share of comparable returns that agree
  double overlap = 0;               ///< share of returns that agree
  bool searched = false;            ///< found in a wide window, needs a second witness
  bool off = false;                 ///< switched off by the options
};

/// What a key scan sees in each direction from its laser: nearest and farthest return, 0 for none.
struct View {
  static constexpr int kBearings = 360;
  Pose2 T_submap_laser;
  std::array<float, kBearings> nearest{}, farthest{};
};

/// Some metres of neighbouring key scans as one map, in the frame of the anchor's robot.
struct Submap {
  std::size_t first = 0, last = 0;  ///< key scans [first, last)
  std::size_t anchor = 0;
  map::SurfelMap map;
  match::ScanPoints points;                           ///< the surfels, evenly thinned
  std::vector<View> views;                            ///< of a few of its key scans
  std::unique_ptr<match::LikelihoodPyramid> pyramid;  ///< made when first searched
};

class LoopCloser {
 public:
  explicit LoopCloser(const LoopClosingOptions& options) : options_(options) {}

  /// Looks for closures of all submaps that became complete with the newest key scans; keeps
  /// keys[..].T_map_robot optimal under what was accepted.
  void update(KeyScans& keys, bool last_call);

  /// Instead of that: all key scans are there, and what was recognised is known, in the order in
  /// which it was. Leaves the poses that update() left then.
  void replay(KeyScans& keys, const std::vector<Closure>& known);

  const std::vector<Closure>& closures() const { return accepted_; }
  /// Those that are not switched off, as edges between key scans, to be doubted; `weight` times
  /// their information.
  std::vector<graph::Edge> closure_edges(double weight) const;

  /// Ways between the submaps, and the submap that a key scan belongs to.
  const Ways& ways() const { return ways_; }
  std::size_t submap_of(std::size_t key) const;

 private:
  bool next_is_complete(const KeyScans& keys, std::size_t margin) const;
  std::size_t add_submap(const KeyScans& keys);
  void look(const KeyScans& keys, std::size_t query);
  bool accept(const KeyScans& keys, Closure closure, std::size_t query);
  std::vector<std::size_t> candidates(std::size_t query, const std::vector<double>& ways) const;
  bool try_close(const KeyScans& keys, std::size_t query, std::size_t target, double way,
                 bool search, Closure& closure);
  bool fits(const Submap& from, const Submap& to, const Pose2& guess, Closure& closure) const;
  bool switched_off(std::size_t from_scan, std::size_t to_scan) const;
  bool confirmed(const Closure& closure) const;
  double strain(const Closure& closure) const;
  void settle();
  void place(KeyScans& keys) const;
  std::size_t anchor_key(std::size_t submap) const;
  std::shared_ptr<Submap> submap(const KeyScans& keys, std::size_t index);

  LoopClosingOptions options_;
  std::vector<Pose2> anchors_;  ///< T_map_robot of each submap's anchor
  graph::PoseGraph graph_;      ///< of the anchors
  graph::Optimizer optimizer_{{.max_iterations = 10,
                               .relative_tolerance = 1e-4,
                               .start = graph::Start::given,
                               .robust = graph::Robust::cauchy}};
  bool waiting_ = false;     ///< accepted closures that the graph was not solved with yet
  double last_closure_ = 0;  ///< m driven at the newest closure
  Ways ways_;                ///< between the anchors
  std::vector<Closure> accepted_, pending_;
  std::deque<std::pair<std::size_t, std::shared_ptr<Submap>>> cache_;
};

}  // namespace majak::slam
