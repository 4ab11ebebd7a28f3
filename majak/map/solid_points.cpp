// SPDX-License-Identifier: Apache-2.0
#include "majak/map/solid_points.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "majak/core/beam_delay.hpp"
#include "majak/core/error.hpp"

namespace majak::map {
namespace {

using Cell = std::array<std::int32_t, 3>;

constexpr std::int32_t kHalf = 1 << 20;  // cells to either side that a key can tell apart
constexpr int kFewest = 5;               // neighbours that tell of a surface
constexpr double kFlat = 0.15;           // of a flat patch: thickness over width, squared

bool within(const Cell& cell) {
  return std::all_of(cell.begin(), cell.end(), [](auto c) { return c >= -kHalf && c < kHalf; });
}

std::uint64_t key_of(const Cell& cell) {
  const auto part = [](std::int32_t c) { return static_cast<std::uint64_t>(c + kHalf); };
  return (part(cell[2]) << 42) | (part(cell[1]) << 21) | part(cell[0]);
}

std::uint64_t edge_of(std::uint32_t a, std::uint32_t b) {
  return (static_cast<std::uint64_t>(std::min(a, b)) << 32) | std::max(a, b);
}

/// The floor at z = 0 lies in the middle of its cubes.
Cell cell_of(const Vec3& p, double voxel) {
  const auto cell = [voxel](double v) {
    return static_cast<std::int32_t>(std::clamp(std::floor(v / voxel), -2e9, 2e9));
  };
  return {cell(p.x()), cell(p.y()), cell(p.z() + voxel / 2)};
}

void check(const SolidPointsOptions& o) {
  if (!(o.voxel >= 0.001 && o.voxel <= 100) || !(o.max_range > o.min_range) || !(o.max_edge > 0) ||
      !(o.max_gap > 0) || !(o.mirror_turn >= 0))
    throw Error("points: an option is out of its range");
}

/// Normal of the points around point `i`; zero where they are not flat. The other face of a thin
/// wall does not count.
Vec3 normal_at(const SolidCloud& cloud, std::size_t i) {
  Vec3 sum = Vec3::Zero();
  Mat3 squares = Mat3::Zero();
  int n = 0;
  const SolidPoint& here = cloud.points[i];
  for (int k = 0; k < 27; ++k) {
    const Cell cell{here.cell[0] + k % 3 - 1, here.cell[1] + k / 3 % 3 - 1,
                    here.cell[2] + k / 9 - 1};
    const std::int64_t found = cloud.find(cell);
    if (found < 0) continue;
    const SolidPoint& there = cloud.points[static_cast<std::size_t>(found)];
    if (there.towards.dot(here.towards) < 0) continue;
    const Vec3 off = there.mean - here.mean;
    sum += off, squares += off * off.transpose(), ++n;
  }
  if (n < kFewest) return Vec3::Zero();
  const Eigen::SelfAdjointEigenSolver<Mat3> axes(squares - sum * sum.transpose() / n);
  if (!(axes.eigenvalues()[0] < kFlat * axes.eigenvalues()[1])) return Vec3::Zero();
  const Vec3 normal = axes.eigenvectors().col(0);
  return normal.dot(here.towards) < 0 ? Vec3(-normal) : normal;
}

}  // namespace

std::int64_t SolidCloud::find(const Cell& cell) const {
  if (!within(cell)) return -1;
  const std::uint64_t key = key_of(cell);
  const auto found = std::lower_bound(
      points.begin(), points.end(), key,
      [](const SolidPoint& point, std::uint64_t k) { return key_of(point.cell) < k; });
  return found != points.end() && found->cell == cell ? found - points.begin() : -1;
}

SolidPoints::SolidPoints(const Site& site, const LaserMounting& mounting,
                         const SolidPointsOptions& options, TiltTrack tilt)
    : mounting_(mounting),
      options_(options),
      trajectory_(site, from_seconds(options.max_gap)),
      tilt_(std::move(tilt)) {
  check(options);
}

void SolidPoints::add(const Scan& scan) {
  if (scan.laser != mounting_.laser) return;
  std::vector<Seen> seen(scan.ranges.size());
  for (std::size_t i = 0; i < seen.size(); ++i) seen[i] = see(scan, i);
  if (scan.time - last_time_ > from_seconds(options_.max_gap) || last_.size() != seen.size())
    last_.clear();
  join(seen);
  last_ = std::move(seen);
  last_time_ = scan.time;
}

SolidPoints::Seen SolidPoints::see(const Scan& scan, std::size_t beam) {
  const double range = static_cast<double>(scan.ranges[beam]);
  if (!std::isfinite(range) || range < options_.min_range || range > options_.max_range) return {};
  const double delay = beam_delay(scan.angle_step, beam, options_.mirror_turn);
  const Time fired = scan.time + from_seconds(delay);
  const auto T_map_robot = trajectory_.at(fired);
  if (!T_map_robot) {
    report_.count("beams at times at which the site says no pose; left out");
    return {};
  }
  const Pose3 T_map_laser = in_space(*T_map_robot) * mounting_.T_robot_laser(tilt_.at(fired));
  const double angle = scan.angle(beam);
  const Vec3 p = T_map_laser * Vec3(range * std::cos(angle), range * std::sin(angle), 0);
  const bool strong = beam < scan.intensities.size();
  has_intensity_ |= strong;
  return {put(p, T_map_laser.translation, strong ? scan.intensities[beam] : 0), p};
}

std::uint32_t SolidPoints::put(const Vec3& p, const Vec3& laser, float intensity) {
  const Cell cell = cell_of(p, options_.voxel);
  if (!within(cell)) {
    report_.count("points too far from the map's origin; left out");
    return kNone;
  }
  const auto [at, fresh] =
      index_.try_emplace(key_of(cell), static_cast<std::uint32_t>(voxels_.size()));
  if (fresh) voxels_.emplace_back().cell = cell;
  Voxel& voxel = voxels_[at->second];
  voxel.sum += p;
  voxel.sum_zz += p.z() * p.z();
  voxel.towards += (laser - p).normalized();
  voxel.intensity += static_cast<double>(intensity);
  ++voxel.count;
  ++beams_;
  return at->second;
}

/// Two triangles between two beams of this scan and the same of the one before.
void SolidPoints::join(const std::vector<Seen>& seen) {
  if (last_.empty()) return;
  for (std::size_t i = 0; i + 1 < seen.size(); ++i) {
    triangle(last_[i], seen[i], seen[i + 1]);
    triangle(last_[i], seen[i + 1], last_[i + 1]);
  }
}

void SolidPoints::triangle(const Seen& a, const Seen& b, const Seen& c) {
  if (a.voxel == kNone || b.voxel == kNone || c.voxel == kNone) return;
  if (a.voxel == b.voxel || b.voxel == c.voxel || c.voxel == a.voxel) return;
  const double limit = options_.max_edge * options_.max_edge;
  if ((a.at - b.at).squaredNorm() > limit || (b.at - c.at).squaredNorm() > limit ||
      (c.at - a.at).squaredNorm() > limit)
    return;
  std::uint8_t* counts[] = {&edges_[edge_of(a.voxel, b.voxel)], &edges_[edge_of(b.voxel, c.voxel)],
                            &edges_[edge_of(c.voxel, a.voxel)]};
  if (std::any_of(std::begin(counts), std::end(counts), [](const auto* n) { return *n >= 2; }))
    return;
  for (std::uint8_t* n : counts) ++*n;
  triangles_.push_back({a.voxel, b.voxel, c.voxel});
}

SolidCloud SolidPoints::cloud() const {
  SolidCloud cloud{options_.voxel, {}, {}, has_intensity_};
  std::vector<std::uint32_t> order(voxels_.size()), rank(voxels_.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [this](std::uint32_t a, std::uint32_t b) {
    return key_of(voxels_[a].cell) < key_of(voxels_[b].cell);
  });
  cloud.points.reserve(order.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) {
    const Voxel& v = voxels_[order[i]];
    const Vec3 mean = v.sum / v.count;
    rank[order[i]] = i;
    cloud.points.push_back({mean, Vec3::Zero(), v.towards.normalized(),
                            std::max(0.0, v.sum_zz / v.count - mean.z() * mean.z()), v.count,
                            static_cast<float>(v.intensity / v.count), v.cell});
  }
  for (std::size_t i = 0; i < order.size(); ++i) cloud.points[i].normal = normal_at(cloud, i);
  for (auto [a, b, c] : triangles_) {
    const auto& p = cloud.points;
    a = rank[a], b = rank[b], c = rank[c];
    const Vec3 normal = (p[b].mean - p[a].mean).cross(p[c].mean - p[a].mean);
    if (normal.dot(p[a].towards) < 0) std::swap(b, c);
    cloud.triangles.push_back({a, b, c});
  }
  return cloud;
}

}  // namespace majak::map
