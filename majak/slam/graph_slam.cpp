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
constexpr std::size_t kPatience = 10;   // scans that may queue behind one that waits for odometry

}  // namespace

GraphSlam::GraphSlam(const GraphSlamOptions& options, Threads threads)
    : options_(options),
      threads_(threads),
      drive_(options.drive),
      odometry_(motion::with_wheelbase(options.odometry, options.drive)),
      front_end_(options.front_end),
      loop_closer_(options.loops) {}

std::optional<Estimate> GraphSlam::add(Event event) {
  drive_.apply(event);
  if (auto* scan = std::get_if<Scan>(&event)) {
    if (scan->laser != 0) return std::nullopt;  // the front laser maps
    odometry_.add(*scan);
    site_.scans.push_back({std::move(*scan), {}, {}, {}, false, 0});
    key_of_.push_back(0);
  } else if (const auto* odometry = std::get_if<Odometry>(&event)) {
    odometry_.add(*odometry);
  } else if (const auto* wheels = std::get_if<WheelMotion>(&event)) {
    odometry_.add(*wheels);
  } else if (const auto* truth = std::get_if<Truth>(&event)) {
    site_.truth.push_back(*truth);
  }
  const std::size_t before = processed_;
  while (processed_ < site_.scans.size() &&
         (!options_.use_odometry || odometry_.ready(processed_) ||
          processed_ + kPatience < site_.scans.size()))
    process(processed_++);
  if (processed_ == before) return std::nullopt;
  return site_.scans[processed_ - 1].estimate;
}

void GraphSlam::process(std::size_t index) {
  PosedScan& posed = site_.scans[index];
  std::optional<MotionPrior> motion;
  if (options_.use_odometry) {
    if (const auto predicted = odometry_.predict(index))
      motion = MotionPrior{predicted->T_previous_robot, predicted->sigma_translation,
                           predicted->sigma_rotation};
    posed.T_odom_robot = odometry_.pose(index);
  }
  FrontEndStep step = front_end_.add(posed.scan, motion);
  const bool weak = index > 0 && (step.broken || step.match.score < options_.front_end.weak_score);
  const Pose2 T_front_robot = posed.T_map_robot_front_end = step.T_map_robot;
  if (index > 0)
    odometry_.observe(index, between(site_.scans[index - 1].T_map_robot_front_end, T_front_robot),
                      !weak && !step.searched);
  // The newest key scan's correction carries over to what follows it.
  const auto in_map = [&](const Pose2& front) {
    return keys_.empty() ? front
                         : keys_.back().T_map_robot * between(keys_.back().T_front_robot, front);
  };

  if (step.key) {
    posed.key = true;
    KeyScan key = key_scan(std::move(step), index, posed.scan.T_robot_laser, weak);
    key.T_map_robot = in_map(T_front_robot);
    keys_.push_back(std::move(key));
    if (options_.close_loops) loop_closer_.update(keys_, false);
  }
  key_of_[index] = keys_.empty() ? 0 : keys_.size() - 1;
  posed.estimate.time = posed.scan.time;
  posed.estimate.T_map_robot = in_map(T_front_robot);
}

Site GraphSlam::finish() {
  while (processed_ < site_.scans.size()) process(processed_++);
  if (keys_.empty())
    throw Error("no laser scan with at least ten returns: there is nothing to map");
  if (options_.close_loops) loop_closer_.update(keys_, true);
  refined_ =
      refine_jointly(keys_, revisits(keys_, loop_closer_, options_.revisits),
                     loop_closer_.closure_edges(kClosureWeight), options_.refinement, threads_);
  std::vector<UnseenMotion> unseen(keys_.size());
  for (std::size_t k = 1; k < keys_.size(); ++k)
    unseen[k] = unseen_motion(site_.scans[keys_[k - 1].scan], site_.scans[keys_[k].scan]);
  place_scans(key_covariances(keys_, refined_, unseen));
  record_constraints();
  if (options_.use_odometry)  // now that its lag and direction are known
    for (std::size_t i = 0; i < site_.scans.size(); ++i)
      site_.scans[i].T_odom_robot = odometry_.pose(i);
  site_.odometry = odometry_.findings();
  OdometryFindings& found = site_.odometry;  // the model knows the place against the nominal one
  const Pose2 T_robot_laser =
      Pose2{found.laser_x_m.value, found.laser_y_m.value, found.laser_theta_rad.value} *
      site_.scans.front().scan.T_robot_laser;
  if (found.laser_x_m.used) found.laser_x_m.value = T_robot_laser.x;
  if (found.laser_y_m.used) found.laser_y_m.value = T_robot_laser.y;
  if (found.laser_theta_rad.used) found.laser_theta_rad.value = T_robot_laser.theta;
  site_.used_odometry = std::any_of(site_.scans.begin(), site_.scans.end(),
                                    [](const PosedScan& s) { return s.T_odom_robot.has_value(); });
  return std::move(site_);
}

// Every scan, key or not, against the map that all key scans make together.
void GraphSlam::place_scans(const std::vector<Mat3>& covariances) {
  map::SurfelMapOptions map_options = options_.front_end.map;
  map_options.max_count = 1000;
  map::SurfelMap map(map_options);
  for (const KeyScan& key : keys_) match::add_to(map, key.points, key.T_map_robot);

  match::AlignOptions align = options_.front_end.align;
  align.gate = 0.15;
  align.final_gate = 0.08;
  align.tolerance = 1e-3;
  constexpr std::size_t kChunk = 64;
  parallel_for(threads_, (site_.scans.size() + kChunk - 1) / kChunk, [&](std::size_t chunk) {
    match::BeamDirections directions;
    const std::size_t end = std::min(site_.scans.size(), (chunk + 1) * kChunk);
    for (std::size_t i = chunk * kChunk; i < end; ++i)
      place_scan(i, covariances, map, align, directions);
  });
}

// The front end's way from the key scan before and that to the next one disagree by what the graph
// has moved these; the scans between share it.
Pose2 GraphSlam::between_keys(std::size_t scan, double& passed) const {
  const auto seen_from = [&](const KeyScan& key) {
    return key.T_map_robot * between(key.T_front_robot, site_.scans[scan].T_map_robot_front_end);
  };
  const std::size_t k = key_of_[scan];
  passed = 0;
  const Pose2 T = seen_from(keys_[k]);
  if (k + 1 >= keys_.size() || keys_[k + 1].weak_step || scan < keys_[k].scan) return T;
  passed = static_cast<double>(scan - keys_[k].scan) /
           static_cast<double>(keys_[k + 1].scan - keys_[k].scan);
  return interpolate(T, seen_from(keys_[k + 1]), passed);
}

void GraphSlam::place_scan(std::size_t scan, const std::vector<Mat3>& covariances,
                           const map::SurfelMap& map, const match::AlignOptions& align,
                           match::BeamDirections& directions) {
  PosedScan& posed = site_.scans[scan];
  double passed = 0;
  match::PosePrior prior;
  prior.T_map_robot = between_keys(scan, passed);
  prior.information.diagonal() << 2500, 2500, 10000;
  const std::size_t nearer = key_of_[scan] + (passed > 0.5 ? 1 : 0);
  const auto points = match::scan_points(posed.scan, options_.front_end.points, false, directions);
  const match::Match match = match::align(points, map, prior, align);
  Estimate& estimate = posed.estimate;
  estimate.T_map_robot = match.T_map_robot;
  estimate.covariance = scan_covariance(covariances[nearer], match,
                                        unseen_motion(site_.scans[keys_[nearer].scan], posed));
  posed.match_score = static_cast<float>(match.score);
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes;
  axes.computeDirect(match.information.topLeftCorner<2, 2>());
  if (match.score < 0.4) {
    estimate.health = Health::lost;
  } else if (axes.eigenvalues()(0) < prior.information(0, 0)) {
    estimate.health = Health::degraded;
    estimate.weak_direction = axes.eigenvectors().col(0);
  }
}

void GraphSlam::record_constraints() {
  const auto chi2_of = [&](std::size_t from, std::size_t to, const Pose2& T_from_to,
                           const Mat3& information) {
    const Vec3 e =
        between(T_from_to, between(keys_[from].T_map_robot, keys_[to].T_map_robot)).vector();
    return e.dot(information * e);
  };
  const auto add = [&](const graph::Edge& edge, ConstraintKind kind) {
    Constraint c;
    c.kind = kind;
    const auto from = static_cast<std::size_t>(edge.from), to = static_cast<std::size_t>(edge.to);
    c.from = keys_[from].scan, c.to = keys_[to].scan;
    c.T_from_to = edge.T_from_to;
    c.information = edge.information;
    c.chi2 = chi2_of(from, to, edge.T_from_to, edge.information);
    site_.constraints.push_back(c);
  };
  for (std::size_t k = 0; k < keys_.size(); ++k) {
    if (k > 0) add(motion_edge(keys_, k), ConstraintKind::odometry);
    for (const graph::Edge& edge : match_edges(keys_, k)) add(edge, ConstraintKind::match);
  }
  for (const graph::Edge& edge : refined_.pairs) add(edge, ConstraintKind::match);
  for (const Closure& closure : loop_closer_.closures()) {
    Constraint c;
    c.kind = ConstraintKind::closure;
    c.from = keys_[closure.from_key].scan, c.to = keys_[closure.to_key].scan;
    c.T_from_to = closure.T_from_to;
    c.information = closure.information;
    c.score = closure.agreement;
    c.overlap = closure.overlap;
    c.chi2 = chi2_of(closure.from_key, closure.to_key, closure.T_from_to, closure.information);
    c.enabled = !closure.off && c.chi2 < kContradicted;
    site_.constraints.push_back(c);
  }
}

void describe(OptionFields& f, GraphSlamOptions& o) {
  f.add("slam.use_odometry", o.use_odometry, {"", "false: the laser alone"});
  f.add("slam.close_loops", o.close_loops, {"", "false: places seen again are not recognised"});
  FrontEndOptions& e = o.front_end;
  f.add("front_end.key_distance", e.key_distance, {"m", "a new key scan after this way", 0.01, 10});
  f.add("front_end.key_turn", e.key_turn, {"rad", "a new key scan after this turn", 0.01, 3});
  f.add("front_end.local_map_keys", e.local_map_keys, {"1", "key scans in a local map", 1, 1000});
  f.add("front_end.trusted_score", e.trusted_score,
        {"1", "share of matched returns below which the window is searched", 0, 1});
  f.add("front_end.search_translation", e.search_translation,
        {"m", "half width of that search", 0.1, 10});
  f.add("front_end.search_rotation", e.search_rotation,
        {"rad", "half width of that search", 0.05, 3.15});
  f.add("scan.max_range", e.points.max_range, {"m", "longer returns are not matched", 1, 1000});
  f.add("scan.min_range", e.points.min_range, {"m", "shorter returns are the robot itself", 0, 10});
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
  motion::describe(f, o.drive);
}

}  // namespace majak::slam
