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
  refined_ =
      refine_jointly(keys, revisits(keys, loop_closer_, options_.revisits),
                     loop_closer_.closure_edges(kClosureWeight), options_.refinement, threads_);
  const std::vector<PosedScan>& scans = chain_.site().scans;
  std::vector<UnseenMotion> unseen(keys.size());
  for (std::size_t k = 1; k < keys.size(); ++k)
    unseen[k] = unseen_motion(scans[keys[k - 1].scan], scans[keys[k].scan]);
  place_scans(key_covariances(keys, refined_, unseen));
  record_constraints();
  Mapping mapping;
  mapping.posterior = true;
  for (const KeyScan& key : keys) mapping.belief_bytes += bytes(key);
  mapping.site = chain_.finish();
  return mapping;
}

// Every scan, key or not, against the map that all key scans make together.
void GraphSlam::place_scans(const std::vector<Mat3>& covariances) {
  const std::size_t scans = chain_.site().scans.size();
  map::SurfelMapOptions map_options = options_.chain.front_end.map;
  map_options.max_count = 1000;
  map::SurfelMap map(map_options);
  for (const KeyScan& key : chain_.keys()) match::add_to(map, key.points, key.T_map_robot);

  match::AlignOptions align = options_.chain.front_end.align;
  align.gate = 0.15;
  align.final_gate = 0.08;
  align.tolerance = 1e-3;
  constexpr std::size_t kChunk = 64;
  parallel_for(threads_, (scans + kChunk - 1) / kChunk, [&](std::size_t chunk) {
    match::BeamDirections directions;
    const std::size_t end = std::min(scans, (chunk + 1) * kChunk);
    for (std::size_t i = chunk * kChunk; i < end; ++i)
      place_scan(i, covariances, map, align, directions);
  });
}

void GraphSlam::place_scan(std::size_t scan, const std::vector<Mat3>& covariances,
                           const map::SurfelMap& map, const match::AlignOptions& align,
                           match::BeamDirections& directions) {
  PosedScan& posed = chain_.site().scans[scan];
  const ScanChain::Hung hung = chain_.hang(scan);
  const KeyScan& nearer = chain_.keys()[hung.key];
  match::PosePrior prior;
  prior.T_map_robot = hung.T_map_robot;
  prior.information.diagonal() << 2500, 2500, 10000;
  const auto points =
      match::scan_points(posed.scan, options_.chain.front_end.points, false, directions);
  const match::Match match = match::align(points, map, prior, align);
  Estimate& estimate = posed.estimate;
  estimate.T_map_robot = match.T_map_robot;
  estimate.covariance = scan_covariance(covariances[hung.key], match,
                                        unseen_motion(chain_.site().scans[nearer.scan], posed));
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

void GraphSlam::record_constraints() {
  const KeyScans& keys = chain_.keys();
  std::vector<Constraint>& constraints = chain_.site().constraints;
  const auto chi2_of = [&](std::size_t from, std::size_t to, const Pose2& T_from_to,
                           const Mat3& information) {
    const Vec3 e =
        between(T_from_to, between(keys[from].T_map_robot, keys[to].T_map_robot)).vector();
    return e.dot(information * e);
  };
  const auto add = [&](const graph::Edge& edge, ConstraintKind kind) {
    Constraint c;
    c.kind = kind;
    const auto from = static_cast<std::size_t>(edge.from), to = static_cast<std::size_t>(edge.to);
    c.from = keys[from].scan, c.to = keys[to].scan;
    c.T_from_to = edge.T_from_to;
    c.information = edge.information;
    c.chi2 = chi2_of(from, to, edge.T_from_to, edge.information);
    constraints.push_back(c);
  };
  for (std::size_t k = 0; k < keys.size(); ++k) {
    if (k > 0) add(motion_edge(keys, k), ConstraintKind::odometry);
    for (const graph::Edge& edge : match_edges(keys, k)) add(edge, ConstraintKind::match);
  }
  for (const graph::Edge& edge : refined_.pairs) add(edge, ConstraintKind::match);
  for (const Closure& closure : loop_closer_.closures()) {
    Constraint c;
    c.kind = ConstraintKind::closure;
    c.from = keys[closure.from_key].scan, c.to = keys[closure.to_key].scan;
    c.T_from_to = closure.T_from_to;
    c.information = closure.information;
    c.score = closure.agreement;
    c.overlap = closure.overlap;
    c.chi2 = chi2_of(closure.from_key, closure.to_key, closure.T_from_to, closure.information);
    c.enabled = !closure.off && c.chi2 < kContradicted;
    constraints.push_back(c);
  }
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
