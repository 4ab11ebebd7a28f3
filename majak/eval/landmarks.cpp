// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/landmarks.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "majak/core/rigid_fit.hpp"

namespace majak::eval {
namespace {

std::vector<Vec2> places(std::span<const PlacedLandmark> landmarks, const Pose2& T_to_from = {}) {
  std::vector<Vec2> p;
  for (const PlacedLandmark& l : landmarks) p.push_back(T_to_from * l.p);
  return p;
}

std::size_t nearest(const std::vector<Vec2>& among, const Vec2& p) {
  return static_cast<std::size_t>(std::min_element(among.begin(), among.end(),
                                                   [&](const Vec2& a, const Vec2& b) {
                                                     return (a - p).squaredNorm() <
                                                            (b - p).squaredNorm();
                                                   }) -
                                  among.begin());
}

std::vector<LandmarkMatch::Pair> pairs_of(const std::vector<Vec2>& mapped,
                                          const std::vector<Vec2>& truth, double reach) {
  std::vector<LandmarkMatch::Pair> pairs;
  if (truth.empty()) return pairs;
  for (std::size_t i = 0; i < mapped.size(); ++i) {
    const std::size_t t = nearest(truth, mapped[i]);
    const Vec2 error = mapped[i] - truth[t];
    if (error.norm() <= reach && nearest(mapped, truth[t]) == i) pairs.push_back({i, t, error, {}});
  }
  return pairs;
}

std::optional<double> nees_of(const Vec2& error, const PlacedLandmark& mapped,
                              const PlacedLandmark& truth, const Pose2& T_truth_map) {
  if (!mapped.covariance) return std::nullopt;
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(T_truth_map.theta).toRotationMatrix();
  Eigen::Matrix2d covariance = turn * *mapped.covariance * turn.transpose();
  if (truth.covariance) covariance += *truth.covariance;
  const Eigen::LLT<Eigen::Matrix2d> root(covariance);
  if (root.info() != Eigen::Success) return std::nullopt;
  return error.dot(root.solve(error));
}

}  // namespace

LandmarkMatch match_landmarks(std::span<const PlacedLandmark> mapped,
                              std::span<const PlacedLandmark> truth,
                              const LandmarkMatchOptions& options) {
  LandmarkMatch match;
  const std::vector<Vec2> from = places(mapped), to = places(truth);
  match.pairs = pairs_of(from, to, options.reach);
  if (options.align && match.pairs.size() > 1) {
    std::vector<Vec2> a, b;
    for (const LandmarkMatch::Pair& p : match.pairs)
      a.push_back(from[p.mapped]), b.push_back(to[p.truth]);
    match.T_truth_map = rigid_fit(a, b);
    match.pairs = pairs_of(places(mapped, match.T_truth_map), to, options.reach);
  }
  std::vector<bool> found(truth.size()), right(mapped.size());
  std::vector<double> errors, nees;
  for (LandmarkMatch::Pair& p : match.pairs) {
    found[p.truth] = right[p.mapped] = true;
    errors.push_back(p.error.norm());
    p.nees = nees_of(p.error, mapped[p.mapped], truth[p.truth], match.T_truth_map);
    if (p.nees) nees.push_back(*p.nees);
  }
  for (std::size_t i = 0; i < found.size(); ++i)
    if (!found[i]) match.missed.push_back(i);
  for (std::size_t i = 0; i < right.size(); ++i)
    if (!right[i]) match.mistaken.push_back(i);
  match.error = error_stats(errors);
  match.nees = summarize_nees(nees, 2);
  return match;
}

SightingError sighting_error(const Vec2& q_robot, const Pose2& T_map_robot,
                             const Pose2& T_map_truth, const Vec2& p_true,
                             const Pose2& T_robot_laser) {
  const Pose2 turned{T_map_truth.x, T_map_truth.y, T_map_robot.theta};
  const Vec2 beam = p_true - (T_map_truth * T_robot_laser).translation();
  const Vec2 along = beam.normalized(), left(-along.y(), along.x());
  const Vec2 error = turned * q_robot - p_true;
  const Vec2 swung = turned * (T_map_truth.inverse() * p_true) - p_true;
  return {beam.norm(), {along.dot(error), left.dot(error)}, left.dot(swung)};
}

std::vector<RangeBin> errors_over_range(std::span<const SightingError> sightings, double width,
                                        std::size_t least) {
  std::map<int, RangeBin> squares;
  for (const SightingError& s : sightings) {
    RangeBin& sum = squares[static_cast<int>(s.range / width)];
    ++sum.count;
    sum.along += s.error.x() * s.error.x();
    sum.across += s.error.y() * s.error.y();
    sum.by_heading += s.by_heading * s.by_heading;
    sum.by_laser += s.by_laser() * s.by_laser();
  }
  std::vector<RangeBin> bins;
  for (const auto& [bin, sum] : squares) {
    if (sum.count < least) continue;
    const auto root = [n = static_cast<double>(sum.count)](double s) { return std::sqrt(s / n); };
    bins.push_back({(bin + 0.5) * width, sum.count, root(sum.along), root(sum.across),
                    root(sum.by_heading), root(sum.by_laser)});
  }
  return bins;
}

SplitHalf split_half(std::span<const LandmarkSeen> seen, const SplitHalfOptions& options) {
  struct Sum {
    Vec2 p = Vec2::Zero();
    int count = 0;
  };
  SplitHalf result;
  if (seen.empty()) return result;
  const Time begin = std::min_element(seen.begin(), seen.end(), [](const auto& a, const auto& b) {
                       return a.time < b.time;
                     })->time;
  std::map<int, std::array<Sum, 2>> halves;
  for (const LandmarkSeen& s : seen) {
    const double block = std::floor(to_seconds(s.time - begin) / options.block);
    Sum& sum = halves[s.landmark][static_cast<std::size_t>(std::fmod(block, 2))];
    sum.p += s.T_map_robot * s.q_robot;
    ++sum.count;
  }
  std::vector<double> distances;
  for (const auto& [landmark, half] : halves) {
    if (std::min(half[0].count, half[1].count) < options.least) continue;
    result.landmarks.push_back({landmark, half[0].p / half[0].count, half[1].p / half[1].count});
    distances.push_back(result.landmarks.back().distance());
  }
  result.error = error_stats(distances);
  return result;
}

}  // namespace majak::eval
