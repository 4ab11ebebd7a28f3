// SPDX-License-Identifier: Apache-2.0
#include "majak/map/planes.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"

namespace majak::map {
namespace {

using Block = std::array<std::int32_t, 3>;

constexpr double kNoNormal = 2;      // chi2 of a normal that is not known: what it is on average
constexpr double kNothing = 40;      // chi2 from which on a share is nothing
constexpr double kBlockSupport = 3;  // points; a block with less support is not of a plane
constexpr double kAtRest = 1e-5;     // m and rad; a plane that moves less has converged
constexpr int kGrowthRounds = 100;   // of a proposal, at most: blocks from its seed
constexpr int kStructureRounds = 4;  // of births, deaths and fusions
constexpr double kMergeAngle = 10;   // degrees; planes farther apart are not tried as one

/// Weighted moments of points about a place.
struct Moments {
  double weight = 0;
  Vec3 sum = Vec3::Zero(), normal = Vec3::Zero();
  Mat3 squares = Mat3::Zero();

  void add(const SolidPoint& p, const Vec3& about, double w) {
    const Vec3 off = p.mean - about;
    weight += w, sum += w * off, normal += w * p.normal, squares += w * off * off.transpose();
  }
  Moments& operator+=(const Moments& o) {
    weight += o.weight, sum += o.sum, normal += o.normal, squares += o.squares;
    return *this;
  }
};

/// The plane of least squares (22.4). `old`: about its centre the moments are; facing as it does.
void fit(Plane& plane, const Moments& m) {
  if (!(m.weight > kBlockSupport)) return;
  const Vec3 mean = m.sum / m.weight;
  const Eigen::SelfAdjointEigenSolver<Mat3> axes(m.squares / m.weight - mean * mean.transpose());
  const Vec3 normal = axes.eigenvectors().col(0);
  const Vec3 facing = m.normal.squaredNorm() > 0 ? m.normal : plane.normal;
  plane.normal = normal.dot(facing) < 0 ? Vec3(-normal) : normal;
  plane.centre += mean;
  plane.offset = plane.normal.dot(plane.centre);
  plane.support = m.weight;
  plane.rms = std::sqrt(std::max(0.0, axes.eigenvalues()[0]));
}

double moved(const Plane& a, const Plane& b) {
  return std::max((a.normal - b.normal).norm(), std::abs(a.normal.dot(b.centre) - a.offset));
}

void check(const PlaneOptions& o) {
  const bool good = o.sigma > 0 && o.normal_sigma > 0 && o.gate >= 1 && o.gate <= 10 &&
                    o.min_area >= 0 && o.block >= 0.01 && o.min_count >= 1 && o.max_rounds >= 1;
  if (!good) throw Error("planes: an option is out of its range");
}

/// Points sorted into blocks of space.
class BlockedPoints {
 public:
  BlockedPoints(const SolidCloud& cloud, const PlaneOptions& options) : cloud_(cloud) {
    for (std::uint32_t i = 0; i < cloud.points.size(); ++i)
      if (cloud.points[i].count >= options.min_count)
        blocks_[block_of(cloud.points[i].mean, options.block)].push_back(i);
    for (const auto& [block, points] : blocks_) order_.push_back(block);
  }
  const std::vector<Block>& all() const { return order_; }
  const std::vector<std::uint32_t>& in(const Block& block) const {
    static const std::vector<std::uint32_t> none;
    const auto found = blocks_.find(block);
    return found == blocks_.end() ? none : found->second;
  }
  const SolidPoint& point(std::uint32_t i) const { return cloud_.points[i]; }

 private:
  const SolidCloud& cloud_;
  std::map<Block, std::vector<std::uint32_t>> blocks_;
  std::vector<Block> order_;
};

template <class Visit>
void for_each_neighbour(const Block& block, const Visit& visit) {
  for (int k = 0; k < 27; ++k)
    if (k != 13) visit(Block{block[0] + k % 3 - 1, block[1] + k / 3 % 3 - 1, block[2] + k / 9 - 1});
}

class PlaneFinder {
 public:
  PlaneFinder(const SolidCloud& cloud, const PlaneOptions& options, Threads threads)
      : cloud_(cloud),
        options_(options),
        threads_(threads),
        space_(cloud, options),
        outside_(std::exp(-options.gate * options.gate / 2)),
        penalty_(options.gate * options.gate / 2 * options.min_area / (cloud.voxel * cloud.voxel)),
        explained_(cloud.points.size()),
        best_(cloud.points.size()),
        tried_(cloud.points.size()) {}

  PlaneMap run() {
    for (int round = 0; round < kStructureRounds; ++round) {
      const bool born = propose();
      maximize();
      const bool died = remove_the_poor(), merged = merge();
      if (!born && !died && !merged) break;
      if (died || merged) maximize();
    }
    remove_the_poor();
    return result();
  }

 private:
  double share(const Plane& plane, std::uint32_t i) const {
    return explains(plane, space_.point(i), options_);
  }

  /// The blocks that hang together with the best one and hold points of the plane: those it has
  /// and their neighbours are asked. `unexplained`: points that others explain count less.
  void regrow(Plane& plane, bool unexplained) const {
    std::map<Block, double> support;
    for (const Block& block : plane.blocks) {
      support[block];
      for_each_neighbour(block, [&](const Block& b) { support[b]; });
    }
    for (auto& [block, sum] : support)
      for (const std::uint32_t i : space_.in(block))
        sum += share(plane, i) * (unexplained ? left_over(i) : 1);
    std::erase_if(support, [](const auto& entry) { return entry.second < kBlockSupport; });
    plane.blocks = best_component(std::move(support));
  }

  static std::vector<Block> best_component(std::map<Block, double> support) {
    std::vector<Block> best;
    double most = 0;
    while (!support.empty()) {
      std::vector<Block> part{support.begin()->first};
      double sum = support.begin()->second;
      support.erase(support.begin());
      for (std::size_t at = 0; at < part.size(); ++at)
        for_each_neighbour(Block(part[at]), [&](const Block& b) {
          const auto found = support.find(b);
          if (found == support.end()) return;
          sum += found->second;
          part.push_back(b);
          support.erase(found);
        });
      if (sum > most) most = sum, best = std::move(part);
    }
    std::sort(best.begin(), best.end());
    return best;
  }

  template <class Visit>
  void for_each_point(const Plane& plane, const Visit& visit) const {
    for (const Block& block : plane.blocks)
      for (const std::uint32_t i : space_.in(block))
        if (const double e = share(plane, i); e > 0) visit(i, e);
  }

  /// The share of a point that no plane explains.
  double left_over(std::uint32_t i) const { return outside_ / (outside_ + explained_[i]); }

  /// How much better a point is explained with `e` than with `other`, both the best there is
  /// (22.5).
  double better(double e, double other) const {
    return e > other ? std::log((outside_ + e) / (outside_ + other)) : 0;
  }

  /// Which planes may hold points of a block.
  void index_planes() {
    planes_in_.clear();
    for (std::size_t j = 0; j < planes_.size(); ++j)
      for (const Block& block : planes_[j].blocks) planes_in_[block].push_back(j);
  }
  /// The best share of a point, planes j and k aside.
  double best_without(std::uint32_t i, std::size_t j, std::size_t k) const {
    double best = 0;
    const auto here = planes_in_.find(block_of(space_.point(i).mean, options_.block));
    if (here == planes_in_.end()) return 0;
    for (const std::size_t n : here->second)
      if (n != j && n != k) best = std::max(best, share(planes_[n], i));
    return best;
  }

  void explain_anew() {
    std::fill(explained_.begin(), explained_.end(), 0.0);
    std::fill(best_.begin(), best_.end(), 0.0);
    for (const Plane& plane : planes_) add_explained(plane);
    index_planes();
  }
  void add_explained(const Plane& plane) {
    for_each_point(plane, [&](std::uint32_t i, double e) {
      explained_[i] += e;
      best_[i] = std::max(best_[i], e);
    });
  }

  /// From one point outwards, a ring of blocks at a time, fitted to what no plane explains yet.
  Plane grown_from(std::uint32_t seed) const {
    const SolidPoint& p = space_.point(seed);
    Plane plane{p.normal, p.normal.dot(p.mean), p.mean, 0, 0, {block_of(p.mean, options_.block)}};
    for (int round = 0; round < kGrowthRounds; ++round) {
      const Plane before = plane;
      Moments m;
      for_each_point(plane, [&](std::uint32_t i, double e) {
        m.add(space_.point(i), before.centre, e * left_over(i));
      });
      fit(plane, m);
      regrow(plane, true);
      if (plane.blocks == before.blocks && moved(before, plane) < kAtRest) break;
    }
    return plane;
  }

  /// Points that no plane explains propose planes, in an order of the seed's.
  bool propose() {
    explain_anew();
    std::vector<std::uint32_t> order(cloud_.points.size());
    std::iota(order.begin(), order.end(), 0u);
    RandomStream random(static_cast<std::uint64_t>(options_.seed));
    for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
    const std::size_t before = planes_.size();
    for (const std::uint32_t i : order) {
      const SolidPoint& p = cloud_.points[i];
      if (tried_[i] || p.count < options_.min_count || p.normal.isZero() ||
          explained_[i] > outside_)
        continue;
      tried_[i] = 1;
      Plane plane = grown_from(i);
      double gain = 0;
      for_each_point(plane, [&](std::uint32_t k, double e) {
        tried_[k] |= e > 0.5;
        gain += better(e, best_[k]);
      });
      if (gain <= penalty_) continue;
      add_explained(plane);
      planes_.push_back(std::move(plane));
    }
    return planes_.size() > before;
  }

  /// Expectation (22.3) and maximization (22.4) until no plane moves.
  void maximize() {
    for (int round = 0; round < options_.max_rounds; ++round, ++rounds_) {
      explain_anew();
      const std::vector<Plane> before = planes_;
      parallel_for(threads_, planes_.size(), [&](std::size_t j) {
        Moments m;
        for_each_point(before[j], [&](std::uint32_t i, double e) {
          m.add(space_.point(i), before[j].centre, e / (outside_ + explained_[i]));
        });
        fit(planes_[j], m);
        regrow(planes_[j], false);
      });
      std::erase_if(planes_, [](const Plane& plane) { return plane.blocks.empty(); });
      if (at_rest(before)) break;
    }
    explain_anew();
  }

  bool at_rest(const std::vector<Plane>& before) const {
    if (before.size() != planes_.size()) return false;
    for (std::size_t j = 0; j < planes_.size(); ++j)
      if (before[j].blocks != planes_[j].blocks || moved(before[j], planes_[j]) >= kAtRest)
        return false;
    return true;
  }

  /// Planes without which the rest explains nearly as much, the least supported first.
  bool remove_the_poor() {
    std::stable_sort(planes_.begin(), planes_.end(),
                     [](const Plane& a, const Plane& b) { return a.support > b.support; });
    index_planes();
    const std::size_t before = planes_.size();
    for (std::size_t j = planes_.size(); j-- > 0;) {
      double gain = 0;
      for_each_point(planes_[j],
                     [&](std::uint32_t i, double e) { gain += better(e, best_without(i, j, j)); });
      if (gain > penalty_) continue;
      planes_.erase(planes_.begin() + static_cast<std::ptrdiff_t>(j));
      index_planes();
    }
    explain_anew();
    return planes_.size() < before;
  }

  bool might_be_one(const Plane& a, const Plane& b) const {
    const double apart = std::max(std::abs(a.normal.dot(b.centre) - a.offset),
                                  std::abs(b.normal.dot(a.centre) - b.offset));
    if (a.normal.dot(b.normal) < std::cos(radians(kMergeAngle)) ||
        apart > 4 * options_.gate * options_.sigma)
      return false;
    return std::any_of(a.blocks.begin(), a.blocks.end(), [&](const Block& block) {
      bool touches = std::binary_search(b.blocks.begin(), b.blocks.end(), block);
      for_each_neighbour(block, [&](const Block& n) {
        touches |= std::binary_search(b.blocks.begin(), b.blocks.end(), n);
      });
      return touches;
    });
  }

  Plane united(const Plane& a, const Plane& b) const {
    Plane one = a.support >= b.support ? a : b;
    const Vec3 about = one.centre;
    Moments m;
    for (const Plane* plane : {&a, &b})
      for_each_point(*plane, [&](std::uint32_t i, double e) {
        m.add(space_.point(i), about, e / (outside_ + explained_[i]));
      });
    fit(one, m);
    one.blocks.clear();
    std::set_union(a.blocks.begin(), a.blocks.end(), b.blocks.begin(), b.blocks.end(),
                   std::back_inserter(one.blocks));
    return one;
  }

  /// Neighbours that one plane explains nearly as well as two.
  bool merge() {
    bool any = false;
    for (std::size_t j = 0; j < planes_.size(); ++j)
      for (std::size_t k = j + 1; k < planes_.size();) {
        if (!might_be_one(planes_[j], planes_[k]) || !merge_if_better(j, k)) {
          ++k;
          continue;
        }
        any = true;
        k = j + 1;
      }
    return any;
  }

  bool merge_if_better(std::size_t j, std::size_t k) {
    const Plane one = united(planes_[j], planes_[k]);
    double lost = 0;
    std::map<std::uint32_t, double> now;  // of their points: the best share of the two
    for (const std::size_t n : {j, k})
      for_each_point(planes_[n], [&](std::uint32_t i, double e) { now[i] = std::max(now[i], e); });
    for (const auto& [i, e] : now) {
      const double rest = best_without(i, j, k);
      lost += better(e, rest) - better(share(one, i), rest);
    }
    if (lost >= penalty_) return false;
    planes_[j] = one;
    planes_.erase(planes_.begin() + static_cast<std::ptrdiff_t>(k));
    explain_anew();
    return true;
  }

  PlaneMap result() {
    explain_anew();
    PlaneMap out{planes_, std::vector<std::int32_t>(cloud_.points.size(), -1), rounds_,
                 -penalty_ * static_cast<double>(planes_.size())};
    std::vector<double> most(cloud_.points.size(), outside_);
    for (std::size_t j = 0; j < planes_.size(); ++j)
      for_each_point(planes_[j], [&](std::uint32_t i, double e) {
        if (e > most[i]) most[i] = e, out.plane_of[i] = static_cast<std::int32_t>(j);
      });
    for (const double e : best_) out.log_likelihood += better(e, 0);
    return out;
  }

  const SolidCloud& cloud_;
  const PlaneOptions options_;
  const Threads threads_;
  const BlockedPoints space_;
  const double outside_;             // share of a point that is of no plane
  const double penalty_;             // log-likelihood that a plane must add
  std::vector<double> explained_;    // sum of all planes' shares of a point
  std::vector<double> best_;         // the largest of them
  std::vector<std::uint8_t> tried_;  // proposes no more
  std::vector<Plane> planes_;
  std::map<Block, std::vector<std::size_t>> planes_in_;
  int rounds_ = 0;
};

}  // namespace

Block block_of(const Vec3& p, double block) {
  const auto part = [block](double v) { return static_cast<std::int32_t>(std::floor(v / block)); };
  return {part(p.x()), part(p.y()), part(p.z())};
}

double explains(const Plane& plane, const SolidPoint& point, const PlaneOptions& o) {
  const double off = (plane.normal.dot(point.mean) - plane.offset) / o.sigma;
  double chi2 = off * off;
  if (chi2 > kNothing || plane.normal.dot(point.towards) < 0) return 0;
  const double turned = 2 - 2 * plane.normal.dot(point.normal);  // square of the chord
  chi2 += point.normal.isZero() ? kNoNormal : turned / (o.normal_sigma * o.normal_sigma);
  return chi2 > kNothing ? 0 : std::exp(-chi2 / 2);
}

PlaneMap find_planes(const SolidCloud& cloud, const PlaneOptions& options, Threads threads) {
  check(options);
  return PlaneFinder(cloud, options, threads).run();
}

}  // namespace majak::map
