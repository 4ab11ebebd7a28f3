// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/graph_slam.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "majak/core/error.hpp"
#include "majak/slam/chain.hpp"
#include "majak/slam/pose_covariance.hpp"

namespace majak::slam {
namespace {

constexpr double kContradicted =
    50;  // chi2 of a closure at the final poses: the rest of the map speaks against it
constexpr double kClosureWeight = 0.1;  // beside pairs of single scans: submaps bend a little

// Every scan, key or not, against the map that all key scans make together.
class Placing {
 public:
  Placing(Site& site, const KeyScans& keys, const std::vector<Mat3>& covariances,
          const GraphSlamOptions& options)
      : site_(site),
        keys_(keys),
        covariances_(covariances),
        options_(options),
        align_(options.chain.front_end.align),
        map_(map_options(options)) {
    align_.gate = 0.15;
    align_.final_gate = 0.08;
    align_.tolerance = 1e-3;
    for (const KeyScan& key : keys) match::add_to(map_, key.points, key.T_map_robot);
    std::size_t passed = 0;
    for (const PosedScan& posed : site.scans) {
      passed += posed.key;
      key_of_.push_back(passed - (passed > 0));
    }
  }

  void place_all(Threads threads) const {
    constexpr std::size_t kChunk = 64;
    const std::size_t scans = site_.scans.size();
    parallel_for(threads, (scans + kChunk - 1) / kChunk, [&](std::size_t chunk) {
      match::BeamDirections directions;
      const std::size_t end = std::min(scans, (chunk + 1) * kChunk);
      for (std::size_t i = chunk * kChunk; i < end; ++i) place(i, directions);
    });
  }

 private:
  static map::SurfelMapOptions map_options(const GraphSlamOptions& options) {
    map::SurfelMapOptions o = options.chain.front_end.map;
    o.max_count = 1000;
    return o;
  }

  void place(std::size_t scan, match::BeamDirections& directions) const {
    PosedScan& posed = site_.scans[scan];
    const Hung hung = hang(site_.scans, keys_, key_of_[scan], scan);
    const KeyScan& nearer = keys_[hung.key];
    match::PosePrior prior;
    prior.T_map_robot = hung.T_map_robot;
    prior.information.diagonal() << 2500, 2500, 10000;
    const auto points =
        match::scan_points(posed.scan, options_.chain.front_end.points, false, directions);
    const match::Match match = match::align(points, map_, prior, align_);
    Estimate& estimate = posed.estimate;
    estimate.T_map_robot = match.T_map_robot;
    estimate.covariance = scan_covariance(covariances_[hung.key], match,
                                          unseen_motion(site_.scans[nearer.scan], posed));
    posed.match_score = static_cast<float>(match.score);
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes;
    axes.computeDirect(match.information.topLeftCorner<2, 2>());
    if (match.score < kLostScore) {
      estimate.health = Health::lost;
    } else if (axes.eigenvalues()(0) < prior.information(0, 0)) {
      estimate.health = Health::degraded;
      estimate.weak_direction = axes.eigenvectors().col(0);
    }
  }

  Site& site_;
  const KeyScans& keys_;
  const std::vector<Mat3>& covariances_;
  const GraphSlamOptions& options_;
  match::AlignOptions align_;
  map::SurfelMap map_;
  std::vector<std::size_t> key_of_;  // of each scan: the key scan before it
};

double chi2_of(const KeyScans& keys, std::size_t from, std::size_t to, const Pose2& T_from_to,
               const Mat3& information) {
  const Vec3 e = between(T_from_to, between(keys[from].T_map_robot, keys[to].T_map_robot)).vector();
  return e.dot(information * e);
}

Constraint constraint_of(const KeyScans& keys, const graph::Edge& edge, ConstraintKind kind) {
  const auto from = static_cast<std::size_t>(edge.from), to = static_cast<std::size_t>(edge.to);
  Constraint c;
  c.kind = kind;
  c.from = keys[from].scan, c.to = keys[to].scan;
  c.T_from_to = edge.T_from_to;
  c.information = edge.information;
  c.chi2 = chi2_of(keys, from, to, edge.T_from_to, edge.information);
  return c;
}

Constraint constraint_of(const KeyScans& keys, const Closure& closure) {
  Constraint c;
  c.kind = ConstraintKind::closure;
  c.from = keys[closure.from_key].scan, c.to = keys[closure.to_key].scan;
  c.T_from_to = closure.T_from_to;
  c.information = closure.information;
  c.score = closure.agreement;
  c.overlap = closure.overlap;
  c.chi2 = chi2_of(keys, closure.from_key, closure.to_key, closure.T_from_to, closure.information);
  c.enabled = !closure.off && c.chi2 < kContradicted;
  return c;
}

void record(Site& site, const KeyScans& keys, const JointRefinement& refined,
            const LoopCloser& loops) {
  for (std::size_t k = 0; k < keys.size(); ++k) {
    site.key_links.push_back({keys[k].local_map, keys[k].weak_step, keys[k].match_information});
    if (k > 0)
      site.constraints.push_back(
          constraint_of(keys, motion_edge(keys, k), ConstraintKind::odometry));
    for (const graph::Edge& edge : match_edges(keys, k))
      site.constraints.push_back(constraint_of(keys, edge, ConstraintKind::match));
  }
  for (const graph::Edge& edge : refined.pairs)
    site.constraints.push_back(constraint_of(keys, edge, ConstraintKind::match));
  for (const Closure& closure : loops.closures())
    site.constraints.push_back(constraint_of(keys, closure));
}

}  // namespace

GraphSlam::GraphSlam(const GraphSlamOptions& options, Threads threads)
    : options_(options), threads_(threads), chain_(options.chain), loop_closer_(options.loops) {}

std::optional<Estimate> GraphSlam::add(Event event) {
  chain_.add(std::move(event));
  return take_scans();
}

std::optional<Estimate> GraphSlam::take_scans() {
  std::optional<Estimate> newest;
  while (const auto step = chain_.next()) {
    if (step->key && options_.close_loops) loop_closer_.update(chain_.keys(), false);
    newest = chain_.settle();
  }
  return newest;
}

Mapping GraphSlam::finish() {
  chain_.end();
  take_scans();
  KeyScans& keys = chain_.keys();
  require_keys(keys);
  if (options_.close_loops) loop_closer_.update(keys, true);
  chain_.mend_odometry();
  finish_site(chain_.site(), keys, loop_closer_, options_, threads_);
  Mapping mapping;
  mapping.posterior = true;
  for (const KeyScan& key : keys) mapping.belief_bytes += bytes(key);
  mapping.site = chain_.finish();
  return mapping;
}

void finish_site(Site& site, KeyScans& keys, const LoopCloser& loops,
                 const GraphSlamOptions& options, Threads threads) {
  const JointRefinement refined =
      refine_jointly(keys, revisits(keys, loops, options.revisits),
                     loops.closure_edges(kClosureWeight), options.refinement, threads);
  std::vector<UnseenMotion> unseen(keys.size());
  for (std::size_t k = 1; k < keys.size(); ++k)
    unseen[k] = unseen_motion(site.scans[keys[k - 1].scan], site.scans[keys[k].scan]);
  const std::vector<Mat3> covariances = key_covariances(keys, refined, unseen);
  Placing(site, keys, covariances, options).place_all(threads);
  record(site, keys, refined, loops);
}

void describe(OptionFields& f, GraphSlamOptions& o) {
  describe(f, o.chain);
  f.add("slam.close_loops", o.close_loops, {"", "false: places seen again are not recognised"});
  LoopClosingOptions& l = o.loops;
  f.add("loops.candidates", l.candidates, {"1", "places tried for a submap", 1, 100});
  f.add("loops.near", l.near, {"m", "places nearer than this should see the same walls", 0.5, 100});
  f.add("loops.agreement", l.agreement,
        {"1", "least share of comparable returns that agree", 0, 1});
  f.add("loops.overlap", l.overlap, {"1", "least share of returns that agree", 0, 1});
  f.add("loops.search_score", l.search_score,
        {"1", "least mean likelihood in a window search", 0, 1});
  f.add("loops.drift_translation", l.drift_translation,
        {"m/m", "front end's drift, sizes the windows", 0, 1});
  f.add("loops.drift_rotation", l.drift_rotation,
        {"rad/sqrt(m)", "front end's drift, sizes the windows", 0, 1});
  JointRefinementOptions& r = o.refinement;
  f.add("refinement.rounds", r.rounds, {"1", "how often pairs are found anew", 0, 100});
  RevisitOptions& v = o.revisits;
  f.add("revisits.count", v.count, {"1", "partners of a key scan", 0, 100});
  f.add("revisits.reach", v.reach, {"m", "between the robots of a pair", 0.1, 100});
  f.add("revisits.known_way", v.known_way,
        {"m", "places farther apart by way are not paired", 0, 1e6});
}

}  // namespace majak::slam
