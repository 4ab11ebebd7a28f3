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
  const KeyScans& keys = chain_.keys();
  const bool first = keys.size() == 1;
  const Pose2 T_previous_robot =
      first ? key.T_map_robot : between(keys[keys.size() - 2].T_front_robot, key.T_front_robot);
  parallel_for(threads_, particles_.size(), [&](std::size_t i) {
    if (first)
      particles_[i].T_map_robot = key.T_map_robot;
    else
      move(key, T_previous_robot, i);
    match::add_to(particles_[i].map, key.points, particles_[i].T_map_robot);
  });
  Step step{{}, parents_};
  for (const Particle& p : particles_) step.poses.push_back(p.T_map_robot);
  steps_.push_back(std::move(step));
  key.T_map_robot = particles_[best()].T_map_robot;
  resample();
}

// x ~ p(x | x', u, z, m), w *= p(z | x', u, m): the Gaussian about the best match on the particle's
// own map, and its mass.
void RaoBlackwellized::move(const KeyScan& key, const Pose2& T_previous_robot, std::size_t i) {
  Particle& p = particles_[i];
  match::PosePrior prior{p.T_map_robot * T_previous_robot, Mat3::Zero()};
  prior.information = turned(key.motion_information, prior.T_map_robot.theta);
  const match::Match match = match::align(key.points, p.map, prior, options_.align);
  const bool trusted = match.score >= options_.trusted_score;
  const Pose2& mean = trusted ? match.T_map_robot : prior.T_map_robot;
  Mat3 information = prior.information;
  if (trusted) information += options_.shared * match.information;
  const Vec3 off(mean.x - prior.T_map_robot.x, mean.y - prior.T_map_robot.y,
                 angle_diff(mean.theta, prior.T_map_robot.theta));
  const double log_mass =
      options_.likelihood_share * match::log_likelihood(key.points, p.map, mean, options_.align) -
      0.5 * off.dot(prior.information * off) +
      0.5 * std::log(prior.information.determinant() / information.determinant());
  p.log_weight += log_mass;
  p.log_weight_total += log_mass;

  Mat3 covariance = information.inverse();
  const Vec3 drift(options_.drift_way, options_.drift_way, options_.drift_turn);
  covariance.diagonal() += drift.cwiseAbs2();
  RandomStream random(static_cast<std::uint64_t>(options_.seed), steps_.size(), i);
  const Vec3 normal(random.normal(), random.normal(), random.normal());
  p.T_map_robot = moved(mean, covariance.llt().matrixL() * normal);
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
  f.add("particles.trusted_score", o.trusted_score,
        {"1", "share of returns on the map from which on a match is believed", 0, 1});
  f.add("particles.drift_way", o.drift_way, {"m", "a map's random walk for a key scan", 0, 1});
  f.add("particles.drift_turn", o.drift_turn, {"rad", "a map's random walk for a key scan", 0, 1});
}

}  // namespace majak::slam
