// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/lu_milios.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "majak/core/error.hpp"
#include "majak/graph/block_cholesky.hpp"
#include "majak/map/surfel_map.hpp"
#include "majak/slam/chain.hpp"

namespace majak::slam {
namespace {

constexpr std::size_t kNext = 3;              // later scans that overlap in any case ...
constexpr double kNextScore = 0.6;            // ... and the share that must match
constexpr float kSameSide = 0.7F;             // cosine between normals
const Vec3 kPairFloor(4e-6, 4e-6, 1e-6);      // m^2, rad^2: what a match does not know of itself
const Vec3 kMatchPrior(100.0, 100.0, 400.0);  // 1/m^2, 1/rad^2: present poses, doubted

// H_a of the paper's equation: X_a = H_a dV_a makes a relation a difference.
Mat3 lever(const Pose2& a) {
  Mat3 h = Mat3::Identity();
  h(0, 2) = a.y, h(1, 2) = -a.x;
  return h;
}
Mat3 inverse_lever(const Pose2& a) { return lever({-a.x, -a.y, 0}); }

// A relation between a = to and b = from, about the present poses: X_a - X_b = difference, with
// that information.
struct LinearRelation {
  Vec3 difference;
  Mat3 information;
};
LinearRelation linearize(const graph::Edge& relation, const Pose2& from, const Pose2& to) {
  const Vec3 error = graph::residual(from, to, relation.T_from_to);
  const double angle = from.theta + relation.T_from_to.theta;
  const Mat3 to_error = rotation3(-angle) * inverse_lever(to);
  return {-(lever(to) * (rotation3(angle) * error)),
          to_error.transpose() * relation.information * to_error};
}

// G X = B, the first pose fixed: the unknowns are those of the poses 1, 2, ...
class System {
 public:
  System(std::span<const graph::Edge> relations, std::size_t poses)
      : relations_(relations), b_(3 * poses) {
    std::vector<graph::BlockCholesky::Pair> pairs;
    for (const graph::Edge& r : relations) pairs.push_back({unknown(r.from), unknown(r.to)});
    slots_ = g_.analyze(static_cast<int>(poses) - 1, pairs);
  }

  void assemble(std::span<const Pose2> poses) {
    g_.set_zero();
    std::fill(b_.begin(), b_.end(), 0.0);
    for (std::size_t k = 0; k < relations_.size(); ++k) {
      const graph::Edge& r = relations_[k];
      const LinearRelation linear = linearize(r, poses[static_cast<std::size_t>(r.from)],
                                              poses[static_cast<std::size_t>(r.to)]);
      const Vec3 b = linear.information * linear.difference;
      Eigen::Map<Mat3>(g_.diagonal(unknown(r.from))) += linear.information;
      Eigen::Map<Mat3>(g_.diagonal(unknown(r.to))) += linear.information;
      Eigen::Map<Mat3>(g_.block(slots_[k])) -= linear.information;
      of(unknown(r.to)) += b;
      of(unknown(r.from)) -= b;
    }
    if (!g_.factor()) throw Error("scan alignment: the relations leave a pose open");
  }

  /// Moves the poses by X; by how much at most.
  double solve(std::vector<Pose2>& poses) {
    g_.solve(std::span(b_).first(b_.size() - 3));
    double most = 0;
    for (std::size_t i = 1; i < poses.size(); ++i) {
      const Vec3 step = inverse_lever(poses[i]) * of(unknown(static_cast<int>(i)));
      poses[i] = from_vector(poses[i].vector() + step);
      most = std::max(most, step.cwiseAbs().maxCoeff());
    }
    return most;
  }

  std::vector<Mat3> covariances(std::span<const Pose2> poses) const {
    std::vector<Mat3> result(poses.size(), Mat3::Zero());
    const std::vector<Mat3> of_x = g_.inverse_diagonal();
    for (std::size_t i = 1; i < poses.size(); ++i) {
      const Mat3 to_pose = inverse_lever(poses[i]);
      result[i] = to_pose * of_x[i - 1] * to_pose.transpose();
    }
    return result;
  }

 private:
  int unknown(int pose) const { return pose > 0 ? pose - 1 : static_cast<int>(b_.size() / 3) - 1; }
  Eigen::Map<Vec3> of(int unknown) {
    return Eigen::Map<Vec3>(&b_[3 * static_cast<std::size_t>(unknown)]);
  }

  std::span<const graph::Edge> relations_;
  std::vector<double> b_;  // three a pose; the last three are the fixed pose's and are not read
  graph::BlockCholesky g_;
  std::vector<graph::BlockCholesky::Slot> slots_;
};

}  // namespace

ConsistentPoses consistent_poses(std::span<const graph::Edge> relations, std::vector<Pose2> guess,
                                 const ConsistentPosesOptions& options) {
  graph::check({guess, {relations.begin(), relations.end()}, 0});
  ConsistentPoses result{std::move(guess), {}, 0, false};
  if (result.poses.size() < 2) return {result.poses, {result.poses.size(), Mat3::Zero()}, 0, true};
  System system(relations, result.poses.size());
  while (!result.converged && result.rounds < options.max_rounds) {
    system.assemble(result.poses);
    result.converged = system.solve(result.poses) < options.tolerance;
    ++result.rounds;
  }
  system.assemble(result.poses);
  result.covariances = system.covariances(result.poses);
  return result;
}

LuMilios::LuMilios(const ScanChainOptions& chain, const LuMiliosOptions& options, Threads threads)
    : options_(options), threads_(threads), chain_(chain) {}

std::optional<Estimate> LuMilios::add(Event event) {
  chain_.add(std::move(event));
  while (chain_.next()) chain_.settle();
  return std::nullopt;
}

namespace {

// Of a match's pose, in the axes of the matched scan: without the directions that only the noise of
// the normals holds, and widened by what it does not know of itself.
Mat3 pair_information(const match::Match& match) {
  const Mat3 s = match::without_normal_noise(match.information);
  const Mat3 r = rotation3(match.T_map_robot.theta);
  const Mat3 information =
      kSharedErrors * r.transpose() * (s * match.information * s) * r + 1e-3 * Mat3::Identity();
  const Mat3 widened =
      (Mat3::Identity() + information * kPairFloor.asDiagonal()).inverse() * information;
  return 0.5 * (widened + widened.transpose());
}

// At most `count` of them, spread evenly, and the first.
std::vector<std::size_t> thinned(const std::vector<std::size_t>& all, std::size_t count) {
  if (all.size() <= count) return all;
  std::vector<std::size_t> some;
  for (std::size_t k = 0; k < count; ++k) some.push_back(all[k * all.size() / count]);
  return some;
}

// Share of the returns that lie on a surface of the other scan, seen from the same side: a wall's
// other side is near, too.
double overlap(const match::ScanPoints& points, const map::SurfelMap& scan, const Pose2& T) {
  const auto c = static_cast<float>(std::cos(T.theta)), s = static_cast<float>(std::sin(T.theta));
  const auto px = static_cast<float>(T.x), py = static_cast<float>(T.y);
  std::size_t shared = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float x = c * points.x[i] - s * points.y[i] + px,
                y = s * points.x[i] + c * points.y[i] + py;
    const std::uint32_t found = scan.nearest(x, y);
    if (found == map::SurfelMap::kNone) continue;
    const map::Surfel& f = scan.surfel(found);
    const float nx = c * points.nx[i] - s * points.ny[i], ny = s * points.nx[i] + c * points.ny[i];
    shared += nx * f.nx + ny * f.ny > kSameSide;
  }
  return points.size() > 0 ? static_cast<double>(shared) / static_cast<double>(points.size()) : 0;
}

// The later key scans that overlap key scan j by the present poses.
std::vector<std::size_t> overlapping(const KeyScans& keys, std::size_t j,
                                     const map::SurfelMap& scan, const LuMiliosOptions& o) {
  std::vector<std::size_t> found;
  for (std::size_t i = j + 1 + kNext; i < keys.size(); ++i) {
    const Pose2 T = between(keys[j].T_map_robot, keys[i].T_map_robot);
    if (T.translation().squaredNorm() < o.reach * o.reach &&
        overlap(keys[i].points, scan, T) >= o.overlap)
      found.push_back(i);
  }
  return found;
}

std::vector<graph::Edge> matched_from(const KeyScans& keys, std::size_t j, map::SurfelMap& scan,
                                      const LuMiliosOptions& o) {
  scan.clear();
  match::add_to(scan, keys[j].points, {});
  std::vector<std::size_t> partners;
  for (std::size_t i = j + 1; i < std::min(keys.size(), j + 1 + kNext); ++i) partners.push_back(i);
  const auto chosen = thinned(overlapping(keys, j, scan, o), static_cast<std::size_t>(o.partners));
  partners.insert(partners.end(), chosen.begin(), chosen.end());
  std::vector<graph::Edge> edges;
  for (const std::size_t i : partners) {
    match::PosePrior prior{between(keys[j].T_map_robot, keys[i].T_map_robot),
                           kMatchPrior.asDiagonal()};
    const match::Match match = match::align(keys[i].points, scan, prior, o.align);
    if (match.score >= (i < j + 1 + kNext ? kNextScore : o.trusted_score))
      edges.push_back({static_cast<int>(j), static_cast<int>(i), match.T_map_robot,
                       pair_information(match), false});
  }
  return edges;
}

// The front end's step to key scan k, which includes the wheels'.
graph::Edge front_end_edge(const KeyScans& keys, std::size_t k) {
  return {static_cast<int>(k) - 1, static_cast<int>(k),
          between(keys[k - 1].T_front_robot, keys[k].T_front_robot),
          chain_information(keys, k - 1, k), false};
}

// The odometry of each step as a weak link, where the two scans do not match the front end's, and
// all pairs of scans that overlap, matched.
std::vector<graph::Edge> relations_of(const KeyScans& keys, const LuMiliosOptions& options,
                                      Threads threads) {
  std::vector<std::vector<graph::Edge>> matched(keys.size());
  constexpr std::size_t kChunk = 32;
  parallel_for(threads, (keys.size() + kChunk - 1) / kChunk, [&](std::size_t chunk) {
    map::SurfelMap scan;
    for (std::size_t j = chunk * kChunk; j < std::min(keys.size(), (chunk + 1) * kChunk); ++j)
      matched[j] = matched_from(keys, j, scan, options);
  });
  std::vector<graph::Edge> relations;
  for (std::size_t k = 1; k < keys.size(); ++k) {
    const auto& next = matched[k - 1];
    const bool held = !next.empty() && next.front().to == static_cast<int>(k);
    relations.push_back(held ? motion_edge(keys, k) : front_end_edge(keys, k));
  }
  for (const auto& edges : matched) relations.insert(relations.end(), edges.begin(), edges.end());
  return relations;
}

// Puts the key scans there; by how much that moved them, root mean square (m and rad).
double move(KeyScans& keys, const std::vector<Pose2>& poses) {
  double sum = 0;
  for (std::size_t k = 0; k < keys.size(); ++k) {
    sum += between(keys[k].T_map_robot, poses[k]).vector().squaredNorm();
    keys[k].T_map_robot = poses[k];
  }
  return std::sqrt(sum / static_cast<double>(keys.size()));
}

}  // namespace

PairAlignment align_pairs(KeyScans& keys, const LuMiliosOptions& options, Threads threads) {
  PairAlignment result;
  double moved = options.still;
  for (int round = 0; round < options.rounds && moved >= options.still; ++round) {
    result.relations = relations_of(keys, options, threads);
    std::vector<Pose2> guess;
    for (const KeyScan& key : keys) guess.push_back(key.T_map_robot);
    ConsistentPoses consistent = consistent_poses(result.relations, std::move(guess));
    moved = move(keys, consistent.poses);
    result.covariances = std::move(consistent.covariances);
  }
  return result;
}

Mapping LuMilios::finish() {
  chain_.end();
  while (chain_.next()) chain_.settle();
  KeyScans& keys = chain_.keys();
  require_keys(keys);
  const PairAlignment aligned = align_pairs(keys, options_, threads_);
  place_scans(aligned.covariances);
  record_constraints(aligned.relations);
  Mapping mapping;
  mapping.posterior = true;
  mapping.belief_bytes = aligned.relations.size() * sizeof(graph::Edge);
  for (const KeyScan& key : keys) mapping.belief_bytes += bytes(key);
  mapping.site = chain_.finish();
  return mapping;
}

void LuMilios::record_constraints(const std::vector<graph::Edge>& relations) {
  const KeyScans& keys = chain_.keys();
  for (std::size_t r = 0; r < relations.size(); ++r) {
    const graph::Edge& relation = relations[r];
    const KeyScan &from = keys[static_cast<std::size_t>(relation.from)],
                  &to = keys[static_cast<std::size_t>(relation.to)];
    const Vec3 e = graph::residual(from.T_map_robot, to.T_map_robot, relation.T_from_to);
    Constraint c;
    c.kind = r + 1 < keys.size() ? ConstraintKind::odometry : ConstraintKind::match;
    c.from = from.scan, c.to = to.scan;
    c.T_from_to = relation.T_from_to;
    c.information = relation.information;
    c.chi2 = e.dot(relation.information * e);
    chain_.site().constraints.push_back(c);
  }
}

// A scan between key scans is as sure as the nearer of them, carried along, and as its own match.
void LuMilios::place_scans(const std::vector<Mat3>& key_covariances) {
  chain_.hang_all(threads_);
  std::vector<PosedScan>& scans = chain_.site().scans;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const std::size_t k = chain_.hang(i).key;
    const KeyScan& key = chain_.keys()[k];
    Estimate& estimate = scans[i].estimate;
    const Mat3 carried =
        inverse_lever(estimate.T_map_robot) * lever(key.T_map_robot);  // H_i^-1 H_k
    estimate.covariance = carried * key_covariances[k] * carried.transpose();
    if (i == key.scan) continue;
    const Mat3 r = rotation3(estimate.T_map_robot.theta);
    estimate.covariance += r * key.match_information.inverse() * r.transpose();
  }
}

void describe(OptionFields& f, LuMiliosOptions& o) {
  f.add("lu_milios.rounds", o.rounds, {"1", "how often pairs are matched anew", 1, 1000});
  f.add("lu_milios.still", o.still, {"m, rad", "poses that move less stand still", 1e-6, 1});
  f.add("lu_milios.reach", o.reach, {"m", "between the robots of a pair", 0.1, 100});
  f.add("lu_milios.overlap", o.overlap, {"1", "share of returns on the other scan", 0, 1});
  f.add("lu_milios.partners", o.partners,
        {"1", "later scans that one is matched to, spread evenly", 0, 1000});
  f.add("lu_milios.trusted_score", o.trusted_score,
        {"1", "share of returns on the other scan for a match to be believed", 0, 1});
}

}  // namespace majak::slam
