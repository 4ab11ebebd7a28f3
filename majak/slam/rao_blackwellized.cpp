// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/rao_blackwellized.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "majak/core/random.hpp"
#include "majak/filter/resampling.hpp"
#include "majak/match/scan_points.hpp"

namespace majak::slam {
namespace {

// From the robot's axes to the map's.
Mat3 turned(const Mat3& information, double theta) {
  const double c = std::cos(theta), s = std::sin(theta);
  Mat3 r;
  r << c, -s, 0, s, c, 0, 0, 0, 1;
  return r * information * r.transpose();
}

Pose2 moved(const Pose2& T, const Vec3& by) {
  return {T.x + by.x(), T.y + by.y(), wrap_angle(T.theta + by.z())};
}

}  // namespace

RaoBlackwellized::RaoBlackwellized(const ScanChainOptions& chain,
                                   const RaoBlackwellizedOptions& options, Threads threads)
    : options_(options),
      threads_(threads),
      chain_(chain),
      particles_(static_cast<std::size_t>(options.particles),
                 Particle{{}, map::SharedSurfelMap(options.map), 0, 0}),
      parents_(particles_.size()) {
  std::iota(parents_.begin(), parents_.end(), 0U);
}

std::optional<Estimate> RaoBlackwellized::add(Event event) {
  chain_.add(std::move(event));
  return take_scans();
}

std::optional<Estimate> RaoBlackwellized::take_scans() {
  std::optional<Estimate> newest;
  while (const auto step = chain_.next()) {
    if (step->key) update(chain_.keys().back());
    newest = chain_.settle();
  }
  return newest;
}

void RaoBlackwellized::update(KeyScan& key) {
  const bool first = steps_.empty();
  const Mat3 kernel = spread();
  Step step{{}, parents_, {}};
  for (const Particle& p : particles_)
    step.surfels.push_back(static_cast<std::uint32_t>(p.map.surfels().size()));
  parallel_for(threads_, particles_.size(), [&](std::size_t i) {
    if (first)
      particles_[i].T_map_robot = key.T_map_robot;
    else
      move(i, kernel);
    match::add_to(particles_[i].map, key.points, particles_[i].T_map_robot);
  });
  for (const Particle& p : particles_) step.poses.push_back(p.T_map_robot);
  steps_.push_back(std::move(step));
  key.T_map_robot = particles_[best()].T_map_robot;
  resample();
}

// x ~ p(x | x', u): the front end's way, its noise, and its bend.
void RaoBlackwellized::move(std::size_t i, const Mat3& kernel) {
  Particle& p = particles_[i];
  const std::size_t k = steps_.size();
  const KeyScan &key = chain_.keys()[k], &previous = chain_.keys()[k - 1];
  if (key.local_map != previous.local_map) p.old_surfels = surfels_before(key.local_map, i);
  RandomStream random(static_cast<std::uint64_t>(options_.seed), k, i);
  const Pose2 T = between(previous.T_front_robot, key.T_front_robot);
  const double way = T.translation().norm(), kept = std::exp(-way / options_.bend_way);
  if (k == 1) p.bend = options_.bend * random.normal();
  p.bend = kept * p.bend + std::sqrt(1 - kept * kept) * options_.bend * random.normal();
  const Mat3 noise = (key.match_information + key.motion_information).inverse();
  const Vec3 normal(random.normal(), random.normal(), random.normal());
  const Vec3 error = noise.llt().matrixL() * normal;
  const Pose2 T_error{error.x(), error.y(), error.z() + p.bend * way};
  p.T_map_robot = p.T_map_robot * T * T_error;
  match::PosePrior prior{p.T_map_robot, (kernel + turned(noise, p.T_map_robot.theta)).inverse()};
  look(p, key, prior, random);
}

// x ~ p(x | x', u, z, m), w *= p(z | x', u, m): the Gaussian about the best match on the particle's
// own map, and its mass.
void RaoBlackwellized::look(Particle& p, const KeyScan& key, const match::PosePrior& prior,
                            RandomStream& random) {
  const map::OlderSurfels old(p.map, p.old_surfels);
  if (match::share_on(key.points, old, p.T_map_robot, options_.align.gate) >= options_.known) {
    const match::Match match = match::align(key.points, old, prior, options_.align);
    if (match.score >= options_.known) {
      const Mat3 information = prior.information + options_.shared * match.information;
      const Vec3 off(match.T_map_robot.x - prior.T_map_robot.x,
                     match.T_map_robot.y - prior.T_map_robot.y,
                     angle_diff(match.T_map_robot.theta, prior.T_map_robot.theta));
      const Vec3 normal(random.normal(), random.normal(), random.normal());
      p.T_map_robot =
          moved(match.T_map_robot, Mat3(information.inverse()).llt().matrixL() * normal);
      p.log_weight -= 0.5 * off.dot(prior.information * off);
      p.log_weight_total -= 0.5 * off.dot(prior.information * off);
    }
  }
  const double ll = options_.likelihood_share *
                    match::log_likelihood(key.points, p.map, p.T_map_robot, options_.align);
  p.log_weight += ll;
  p.log_weight_total += ll;
}

std::uint32_t RaoBlackwellized::surfels_before(std::size_t key, std::size_t i) const {
  if (key >= steps_.size()) return static_cast<std::uint32_t>(particles_[i].map.surfels().size());
  i = parents_[i];
  for (std::size_t k = steps_.size() - 1; k > key; --k) i = steps_[k].parents[i];
  return steps_[key].surfels[i];
}

Mat3 RaoBlackwellized::spread() const {
  const double n = static_cast<double>(particles_.size());
  std::vector<double> log_weights, weights(particles_.size());
  for (const Particle& p : particles_) log_weights.push_back(p.log_weight);
  filter::normalise(log_weights, weights);
  Vec3 mean = Vec3::Zero();
  const Pose2& origin = particles_.front().T_map_robot;
  const auto off = [&](const Particle& p) {
    return Vec3(p.T_map_robot.x - origin.x, p.T_map_robot.y - origin.y,
                angle_diff(p.T_map_robot.theta, origin.theta));
  };
  for (std::size_t i = 0; i < particles_.size(); ++i) mean += weights[i] * off(particles_[i]);
  Mat3 c = Mat3::Zero();
  for (std::size_t i = 0; i < particles_.size(); ++i) {
    const Vec3 d = off(particles_[i]) - mean;
    c += weights[i] * d * d.transpose();
  }
  return std::pow(n, -2.0 / 7) * c;
}

void RaoBlackwellized::resample() {
  const std::size_t n = particles_.size();
  std::vector<double> log_weights(n), weights(n);
  for (std::size_t i = 0; i < n; ++i) log_weights[i] = particles_[i].log_weight;
  filter::normalise(log_weights, weights);
  std::iota(parents_.begin(), parents_.end(), 0U);
  if (filter::effective_size(weights) >= options_.resample_below * static_cast<double>(n)) return;
  double bytes = 0;
  for (const Particle& p : particles_) bytes += p.map.share_of_bytes();
  belief_bytes_ = std::max(belief_bytes_, bytes);
  RandomStream random(static_cast<std::uint64_t>(options_.seed), steps_.size(), n);
  filter::resample_systematic(weights, random, parents_);
  std::vector<Particle> children;
  children.reserve(n);
  for (const std::uint32_t parent : parents_) children.push_back(particles_[parent]);
  particles_ = std::move(children);
  for (Particle& p : particles_) p.log_weight = 0;
  if (getenv("PFV")) {
    std::vector<std::uint32_t> u(parents_);
    u.erase(std::unique(u.begin(), u.end()), u.end());
    const Mat3 c = spread();
    fprintf(stderr, "PF key %zu neff %.1f survivors %zu spread %.3f %.3f %.4f\n", steps_.size(),
            filter::effective_size(weights), u.size(), std::sqrt(c(0, 0)), std::sqrt(c(1, 1)),
            std::sqrt(c(2, 2)));
  }
  ++resamplings_;
}

std::size_t RaoBlackwellized::best() const {
  const auto by_weight = [](const Particle& a, const Particle& b) {
    return a.log_weight_total < b.log_weight_total;
  };
  return static_cast<std::size_t>(
      std::max_element(particles_.begin(), particles_.end(), by_weight) - particles_.begin());
}

// Back along the ancestors of the particle that explains all scans best.
void RaoBlackwellized::place_keys() {
  std::size_t i = best();
  i = parents_[i];
  for (std::size_t k = steps_.size(); k-- > 0; i = steps_[k].parents[i])
    chain_.keys()[k].T_map_robot = steps_[k].poses[i];
}

Mapping RaoBlackwellized::finish() {
  chain_.end();
  take_scans();
  require_keys(chain_.keys());
  place_keys();
  chain_.hang_all(threads_);
  Mapping mapping;
  mapping.site = chain_.finish();
  double bytes = 0;
  for (const Particle& p : particles_) bytes += p.map.share_of_bytes();
  mapping.belief_bytes = static_cast<std::size_t>(std::max(belief_bytes_, bytes));
  return mapping;
}

void describe(OptionFields& f, RaoBlackwellizedOptions& o) {
  f.add("particles.count", o.particles, {"1", "particles, each with a map of its own", 1, 10000});
  f.add("particles.seed", o.seed, {"1", "of the random numbers", 0, 2e9});
  f.add("particles.resample_below", o.resample_below,
        {"1", "share of the particles under which the effective size must fall", 0, 1});
  f.add("particles.shared", o.shared, {"1", "share of a match's information that counts", 0, 1});
  f.add("particles.likelihood_share", o.likelihood_share,
        {"1", "share of the returns' log-likelihood that counts", 0, 1});
  f.add("particles.known", o.known,
        {"1", "share of returns on older map from which on a place is known", 0, 1});
  f.add("particles.bend", o.bend, {"rad/m", "by which the front end turns the way", 0, 1});
  f.add("particles.bend_way", o.bend_way, {"m", "for which it goes on doing so", 0.1, 1e6});
}

}  // namespace majak::slam
