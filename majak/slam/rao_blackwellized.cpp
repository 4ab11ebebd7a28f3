// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/rao_blackwellized.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "majak/filter/resampling.hpp"
#include "majak/match/scan_points.hpp"
#include "majak/slam/chain.hpp"

namespace majak::slam {
namespace {

constexpr double kExplained = 0.15;  // m; returns as near as this are on the local map
constexpr double kMeet = 0.3;        // m; maps that meet themselves as nearly as this gain

// From the robot's axes to the map's.
Mat3 turned(const Mat3& covariance, double theta) {
  const Mat3 r = rotation3(theta);
  return r * covariance * r.transpose();
}

Vec3 difference(const Pose2& a, const Pose2& b) {
  return {a.x - b.x, a.y - b.y, angle_diff(a.theta, b.theta)};
}

Vec3 draw(const Mat3& covariance, RandomStream& random) {
  const double x = random.normal(), y = random.normal(), theta = random.normal();
  return covariance.llt().matrixL() * Vec3(x, y, theta);
}

// What adds up from key scan to key scan: the motion's error as far as the match leaves it (23.1),
// and the local map's own random walk. The match's own error is one in the local map and stays
// there.
Mat3 step_noise(const KeyScan& key) {
  const Mat3 c = (key.match_information + key.motion_information).inverse();
  Mat3 noise = c * key.motion_information * c;
  noise.diagonal() += kLocalMapDrift;
  return noise;
}

}  // namespace

RaoBlackwellized::RaoBlackwellized(const ScanChainOptions& chain,
                                   const RaoBlackwellizedOptions& options, Threads threads)
    : options_(options),
      threads_(threads),
      chain_(chain),
      particles_(static_cast<std::size_t>(options.particles),
                 Particle{{}, map::SharedSurfelMap(options.map)}),
      parents_(particles_.size()),
      local_(options.map) {
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
  const match::ScanPoints news = unexplained(key);
  const Mat3 kernel = this->kernel();
  Step step{parents_, {}, {}};
  for (const Particle& p : particles_)
    step.surfels.push_back(static_cast<std::uint32_t>(p.map.surfels().size()));
  parallel_for(threads_, particles_.size(), [&](std::size_t i) {
    if (steps_.empty())
      particles_[i].T_map_robot = key.T_map_robot;
    else
      move(i, kernel, news);
    match::add_to(particles_[i].map, key.points, particles_[i].T_map_robot);
  });
  for (const Particle& p : particles_) step.poses.push_back(p.T_map_robot);
  steps_.push_back(std::move(step));
  key.T_map_robot = particles_[best()].T_map_robot;
  resample();
}

// Returns that are not on the front end's local map: all others it has used already.
match::ScanPoints RaoBlackwellized::unexplained(const KeyScan& key) {
  const KeyScans& keys = chain_.keys();
  if (key.local_map != local_first_) {
    local_.clear();
    local_first_ = key.local_map;
    for (std::size_t k = local_first_; k + 1 < keys.size(); ++k)
      match::add_to(local_, keys[k].points, keys[k].T_front_robot);
  }
  match::ScanPoints news;
  news.laser = key.points.laser;
  for (std::size_t i = 0; i < key.points.size(); ++i) {
    const Vec2 at = key.T_front_robot * Vec2(key.points.x[i], key.points.y[i]);
    const std::uint32_t found =
        local_.nearest(static_cast<float>(at.x()), static_cast<float>(at.y()));
    if (found != map::SurfelMap::kNone) {
      const map::Surfel& s = local_.surfel(found);
      if (std::hypot(at.x() - s.x, at.y() - s.y) < kExplained) continue;
    }
    news.x.push_back(key.points.x[i]);
    news.y.push_back(key.points.y[i]);
  }
  match::add_to(local_, key.points, key.T_front_robot);
  return news;
}

// Each particle stands for what lies between it and the next ones, too (23.4).
Mat3 RaoBlackwellized::kernel() const {
  const std::vector<double> w = weights();
  const Pose2& origin = particles_.front().T_map_robot;
  Vec3 mean = Vec3::Zero();
  Mat3 squares = Mat3::Zero();
  for (std::size_t i = 0; i < w.size(); ++i) {
    const Vec3 off = difference(particles_[i].T_map_robot, origin);
    mean += w[i] * off;
    squares += w[i] * off * off.transpose();
  }
  return std::pow(static_cast<double>(w.size()), -2.0 / 7) * (squares - mean * mean.transpose());
}

// x ~ p(x | x', u): the front end's way, its noise and its bend. Then the scan is looked at.
void RaoBlackwellized::move(std::size_t i, const Mat3& kernel, const match::ScanPoints& news) {
  Particle& p = particles_[i];
  const std::size_t k = steps_.size();
  const KeyScan &key = chain_.keys()[k], &previous = chain_.keys()[k - 1];
  if (key.local_map != previous.local_map) p.old_surfels = surfels_before(key.local_map, i);
  RandomStream random(static_cast<std::uint64_t>(options_.seed), k, i);
  const Pose2 T = between(previous.T_front_robot, key.T_front_robot);
  const double way = T.translation().norm();
  const double kept = k == 1 ? 0 : std::exp(-way / options_.bend_way);
  p.bend = kept * p.bend + std::sqrt(1 - kept * kept) * options_.bend * random.normal();
  const Mat3 noise = step_noise(key);
  const Vec3 error = draw(noise, random);
  p.T_map_robot = p.T_map_robot * T * Pose2{error.x(), error.y(), error.z() + p.bend * way};
  const Mat3 covariance = kernel + turned(noise, p.T_map_robot.theta);
  localize(p, key.points, {p.T_map_robot, covariance.inverse()}, random);
  match::AlignOptions meet;
  meet.final_gate = kMeet;
  meet.cauchy = kMeet / 3;
  meet.sigma = kMeet / 6;
  const double gained =
      options_.likelihood_share *
      match::log_likelihood(news, map::OlderSurfels(p.map, p.old_surfels), p.T_map_robot, meet);
  p.log_weight += gained;
  p.log_weight_total += gained;
}

// In a known place x ~ p(x | x', u, z, m), the Gaussian about the best match on the particle's own
// map (23.5); the way to it is weighed. Where the match does not see, x was drawn already.
void RaoBlackwellized::localize(Particle& p, const match::ScanPoints& points,
                                const match::PosePrior& prior, RandomStream& random) const {
  const map::OlderSurfels old(p.map, p.old_surfels);
  if (match::share_on(points, old, p.T_map_robot, options_.align.gate) < options_.known) return;
  const match::Match match = match::align(points, old, prior, options_.align);
  if (match.score < options_.known) return;
  const Vec3 off = difference(match.T_map_robot, prior.T_map_robot);
  const Mat3 seen = options_.shared * match.information;
  const Mat3 c = (prior.information + seen).inverse();
  const Mat3 noise = c * seen * c + 1e-12 * Mat3::Identity();
  const Vec3 error = draw(noise, random);
  const Pose2& T = match.T_map_robot;
  p.T_map_robot = {T.x + error.x(), T.y + error.y(), wrap_angle(T.theta + error.z())};
  const double lost = 0.5 * off.dot(prior.information * off);
  p.log_weight -= lost;
  p.log_weight_total -= lost;
}

std::uint32_t RaoBlackwellized::surfels_before(std::size_t key, std::size_t i) const {
  if (key == steps_.size()) return static_cast<std::uint32_t>(particles_[i].map.surfels().size());
  i = parents_[i];
  for (std::size_t k = steps_.size() - 1; k > key; --k) i = steps_[k].parents[i];
  return steps_[key].surfels[i];
}

std::vector<double> RaoBlackwellized::weights() const {
  std::vector<double> log_weights, weights(particles_.size());
  for (const Particle& p : particles_) log_weights.push_back(p.log_weight);
  filter::normalise(log_weights, weights);
  return weights;
}

void RaoBlackwellized::resample() {
  const std::size_t n = particles_.size();
  const std::vector<double> w = weights();
  std::iota(parents_.begin(), parents_.end(), 0U);
  if (filter::effective_size(w) >= options_.resample_below * static_cast<double>(n)) return;
  count_bytes();
  RandomStream random(static_cast<std::uint64_t>(options_.seed), steps_.size(), n);
  filter::resample_systematic(w, random, parents_);
  std::vector<Particle> children;
  children.reserve(n);
  for (std::size_t i = 0; i < n; ++i) {
    Particle& parent = particles_[parents_[i]];
    const bool last = i + 1 == n || parents_[i + 1] != parents_[i];
    children.push_back(last ? std::move(parent) : parent);
  }
  for (Particle& p : children) p.log_weight = 0;
  particles_ = std::move(children);
  ++resamplings_;
}

void RaoBlackwellized::count_bytes() {
  double bytes = 0;
  for (const Particle& p : particles_) bytes += p.map.share_of_bytes();
  belief_bytes_ = std::max(belief_bytes_, bytes);
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
  std::size_t i = parents_[best()];
  for (std::size_t k = steps_.size(); k-- > 0; i = steps_[k].parents[i])
    chain_.keys()[k].T_map_robot = steps_[k].poses[i];
}

Mapping RaoBlackwellized::finish() {
  chain_.end();
  take_scans();
  require_keys(chain_.keys());
  count_bytes();
  place_keys();
  chain_.hang_all(threads_);
  Mapping mapping;
  mapping.site = chain_.finish();
  mapping.belief_bytes = static_cast<std::size_t>(belief_bytes_);
  return mapping;
}

void describe(OptionFields& f, RaoBlackwellizedOptions& o) {
  f.add("particles.count", o.particles, {"1", "particles, each with a map of its own", 1, 10000});
  f.add("particles.seed", o.seed, {"1", "of the random numbers", 0, 2147483647});
  f.add("particles.resample_below", o.resample_below,
        {"1", "share of the particles under which the effective size must fall", 0, 1});
  f.add("particles.bend", o.bend, {"rad/m", "by which the front end turns the way", 0, 1});
  f.add("particles.bend_way", o.bend_way, {"m", "for which it goes on doing so", 0.1, 1e6});
  f.add("particles.known", o.known,
        {"1", "share of returns on older map from which on a place is known", 0, 1});
  f.add("particles.shared", o.shared, {"1", "share of a match's information that counts", 0, 1});
  f.add("particles.likelihood_share", o.likelihood_share,
        {"1", "share of the returns' log-likelihood that counts", 0, 1});
}

}  // namespace majak::slam
