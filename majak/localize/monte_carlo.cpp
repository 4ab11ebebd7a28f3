// SPDX-License-Identifier: Apache-2.0
#include "majak/localize/monte_carlo.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "majak/filter/resampling.hpp"
#include "majak/match/beams.hpp"

namespace majak::localize {
namespace {

constexpr std::size_t kBlock = 256;  // particles that one thread works on at a time
constexpr std::size_t kLeastReturns = 10;
constexpr double kBin = 0.5;         // m
constexpr double kReach = 0.75;      // m, of a cluster about its mean
constexpr double kReachTurn = 0.35;  // rad
constexpr std::size_t kClusters = 5;
constexpr double kLeastCluster = 0.05;
constexpr double kWeak = 0.10;  // m, sigma of a direction from which on it is weak

constexpr double kLeap = 1.5, kLeapTurn = 0.6;  // m, rad, from where the cloud was expected
constexpr double kRest = 1e-3;    // m, rad: by less than that wheels that rest do not seem to move
constexpr double kAgreeing = 16;  // squared Mahalanobis distance of tracker and cloud
constexpr double kAside = 1.5;    // sigma, from the mean, where trackers begin, too
constexpr double kBetter = 0.02;  // share of returns by which another tracker must fit better
constexpr double kFound = 0.5;    // weight of a cluster that is likelier than all others
constexpr double kSlipped = 0.3, kAnywhere = 0.3;  // of new particles
constexpr double kSearching = 0.1;                 // share of new particles while there is none
// Proposals: added to what a fit says of itself, and what it may be at most.
constexpr double kProposalSigma = 0.10, kProposalTurn = 0.01;   // m, rad
constexpr double kProposalMost = 0.5, kProposalTurnMost = 0.2;  // m, rad

// What a stream of random numbers is for; streams are keyed (seed, 4 * update + purpose, particle).
enum Purpose : std::uint64_t { moving, resampling, drawing };

RandomStream stream(int seed, int update, Purpose purpose, std::size_t particle) {
  return RandomStream(static_cast<std::uint64_t>(seed),
                      4 * static_cast<std::uint64_t>(update) + purpose, particle);
}

/// cos, sin of a small angle, and what exp() needs of it: sin(t)/t, (1 - cos(t))/t.
struct SmallTurn {
  double cos, sin, a, b;
};
SmallTurn small_turn(double t) {
  const double t2 = t * t;
  if (t2 > 0.05) {
    const auto [a, b] = arc_factors(t);
    return {std::cos(t), std::sin(t), a, b};
  }
  const double a = 1 - t2 / 6 * (1 - t2 / 20 * (1 - t2 / 42)),
               b = t / 2 * (1 - t2 / 12 * (1 - t2 / 30));
  return {1 - t * b, t * a, a, b};
}

Mat3 root_of(const Mat3& covariance) { return covariance.llt().matrixL(); }

Mat3 diagonal(double translation, double rotation) {
  return Vec3(translation, translation, rotation).cwiseAbs2().asDiagonal();
}

bool agrees(const Estimate& tracked, const Estimate& cloud) {
  const Pose2 &a = tracked.T_map_robot, &b = cloud.T_map_robot;
  const Vec3 off(a.x - b.x, a.y - b.y, angle_diff(a.theta, b.theta));
  const Mat3 spread = tracked.covariance + cloud.covariance;
  return tracked.health != Health::lost && off.dot(spread.ldlt().solve(off)) < kAgreeing;
}

}  // namespace

MonteCarlo::MonteCarlo(PlacePtr place, const MonteCarloOptions& options, const Pose2& start,
                       Threads threads)
    : place_(std::move(place)),
      options_(options),
      start_(start),
      threads_(threads),
      global_(place_),
      floor_(place_->known.all(map::CellState::free)),
      bins_(kBin, static_cast<std::size_t>(options.particles)) {}

Estimate MonteCarlo::add(const FedScan& scan) {
  updated_ = due(scan);
  return refined(scan, updated_ ? update(scan) : estimate());
}

Estimate MonteCarlo::update(const FedScan& scan) {
  if (updates_ == 0) {
    begin(scan.scan);
  } else {
    move();
  }
  weigh(scan.scan);
  find_clusters();
  watch();
  const Estimate now = estimate();
  if (updates_ == 0 && counted_ == 0 && options_.start_sigma <= 0) return now;  // nothing seen yet
  const std::size_t fresh = fresh_wanted();
  if (fresh > 0 || filter::effective_size(weights_) < 0.5 * static_cast<double>(poses_.size()))
    resample(fresh);
  if (fresh > 0) draw_fresh(scan.scan, poses_.size() - fresh);
  ++updates_;
  return now;
}

// Has the robot moved enough, or is nothing known of how it moves?
bool MonteCarlo::due(const FedScan& scan) {
  time_ = scan.scan.time;
  const Mat3 carry = adjoint(scan.T_previous_robot.inverse());
  T_update_robot_ = T_update_robot_ * scan.T_previous_robot;
  moved_covariance_ = carry * moved_covariance_ * carry.transpose();
  const bool rests = scan.by_wheels && scan.T_previous_robot.translation().norm() < kRest &&
                     std::abs(scan.T_previous_robot.theta) < kRest;
  if (!rests) moved_covariance_ += scan.covariance;
  return updates_ == 0 || !scan.by_wheels ||
         T_update_robot_.translation().norm() >= options_.step ||
         std::abs(T_update_robot_.theta) >= options_.step_turn;
}

template <class Body>
void MonteCarlo::for_blocks(const Body& body) const {
  const std::size_t n = poses_.size();
  parallel_for(threads_, (n + kBlock - 1) / kBlock,
               [&](std::size_t block) { body(block * kBlock, std::min(n, (block + 1) * kBlock)); });
}

void MonteCarlo::resize(std::size_t n) {
  poses_.resize(n);
  log_weights_.assign(n, 0);
  weights_.assign(n, 1 / static_cast<double>(n));
  costs_.resize(n);
}

void MonteCarlo::begin(const Scan& scan) {
  T_update_robot_ = {};
  moved_covariance_.setZero();
  resize(static_cast<std::size_t>(options_.particles));
  if (options_.start_sigma <= 0) return draw_fresh(scan, 0);
  const Mat3 root = root_of(diagonal(options_.start_sigma, options_.start_turn));
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    RandomStream random = stream(options_.seed, updates_, drawing, i);
    poses_.set(i, draw_near(start_, root, random));
  }
}

// x' = x * m * exp(noise), for each particle a noise of its own.
void MonteCarlo::move() {
  const Mat3 root = root_of(moved_covariance_ + diagonal(options_.spread, options_.spread_turn));
  const Pose2 m = moved_ = std::exchange(T_update_robot_, {});
  const double cm = std::cos(m.theta), sm = std::sin(m.theta);
  moved_covariance_.setZero();
  for_blocks([&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      RandomStream random = stream(options_.seed, updates_, moving, i);
      const double z0 = normal_(random), z1 = normal_(random), z2 = normal_(random);
      const double along = root(0, 0) * z0, across = root(1, 0) * z0 + root(1, 1) * z1;
      const double t = root(2, 0) * z0 + root(2, 1) * z1 + root(2, 2) * z2;
      const auto [turn_cos, turn_sin, a, b] = small_turn(t);
      const double vx = a * along - b * across, vy = b * along + a * across;
      const double x = m.x + cm * vx - sm * vy, y = m.y + sm * vx + cm * vy;
      const double c = poses_.cos[i], s = poses_.sin[i];
      poses_.x[i] = static_cast<float>(poses_.x[i] + (c * x - s * y));
      poses_.y[i] = static_cast<float>(poses_.y[i] + (s * x + c * y));
      const double dc = cm * turn_cos - sm * turn_sin, ds = sm * turn_cos + cm * turn_sin;
      const double c1 = c * dc - s * ds, s1 = s * dc + c * ds;
      const double length = 1.5 - 0.5 * (c1 * c1 + s1 * s1);  // one Newton step to length 1
      poses_.cos[i] = static_cast<float>(c1 * length);
      poses_.sin[i] = static_cast<float>(s1 * length);
    }
  });
}

// log p += effective * mean log likelihood of a beam.
void MonteCarlo::weigh(const Scan& scan) {
  beams_ = match::beams(scan, {.most = options_.beams});
  counted_ = options_.beam_model ? beams_.size() : beams_.returns;
  if (beams_.returns < kLeastReturns) counted_ = beams_.returns = 0;
  const double unit =
      match::LikelihoodField::kUnit *
      std::min(1.0, options_.effective / std::max<double>(1, static_cast<double>(counted_)));
  for_blocks([&](std::size_t first, std::size_t last) {
    cost(first, last);
    for (std::size_t i = first; i < last; ++i) {
      const bool floor = place_->known.at(Vec2(poses_.x[i], poses_.y[i])) == map::CellState::free;
      log_weights_[i] -= unit * costs_[i] + (floor ? 0 : options_.off_floor);
    }
  });
  filter::normalise(log_weights_, weights_);
}

void MonteCarlo::cost(std::size_t first, std::size_t last) {
  if (!options_.beam_model)
    return place_->likelihood.costs(beams_, poses_, first, last, costs_.data());
  for (std::size_t i = first; i < last; ++i) {
    const Pose2 pose(poses_.x[i], poses_.y[i], std::atan2(poses_.sin[i], poses_.cos[i]));
    costs_[i] = counted_ > 0 ? match::cost(options_.model, beams_, place_->distances, pose) : 0;
  }
}

double MonteCarlo::see(const std::function<double(const Pose2&)>& likelihood) {
  const double before = filter::normalise(log_weights_, weights_);
  std::vector<double> seen = log_weights_;
  for (std::size_t i = 0; i < seen.size(); ++i)
    seen[i] +=
        std::log(likelihood({poses_.x[i], poses_.y[i], std::atan2(poses_.sin[i], poses_.cos[i])}));
  const double after = filter::normalise(seen, weights_);
  if (std::isinf(after)) return filter::normalise(log_weights_, weights_), 0;
  log_weights_ = std::move(seen);
  find_clusters();
  return std::exp(after - before);
}

// How well the scan fits where the particles are believed to be, now and in the mean of before.
void MonteCarlo::watch() {
  if (counted_ == 0) return;
  double cost = 0;
  for (std::size_t i = 0; i < weights_.size(); ++i) cost += weights_[i] * costs_[i];
  misfit_ = cost * match::LikelihoodField::kUnit / static_cast<double>(counted_);
  // Means whose first values count in full.
  const auto take = [&](double alpha, double& mean, double& mass) {
    mass += alpha * (1 - mass);
    mean += alpha / mass * (misfit_ - mean);
  };
  take(options_.alpha_fast, fast_, fast_mass_);
  if (found() && fits(options_.doubt)) take(options_.alpha_slow, slow_, slow_mass_);
}

// The heaviest bin, and the particles about the mean of those about it; then what is left.
void MonteCarlo::find_clusters() {
  const Pose2 expected = clusters_.empty() ? Pose2{} : clusters_.front().T_map_robot * moved_;
  clusters_.clear();
  left_ = weights_;
  for (double rest = 1; clusters_.size() < kClusters && rest > kLeastCluster;) {
    bins_.clear();
    double heaviest = 0;
    std::size_t seed = 0;
    for (std::size_t i = 0; i < left_.size(); ++i) {
      if (left_[i] <= 0) continue;
      const double bin =
          bins_.add(poses_.x[i], poses_.y[i], poses_.cos[i], poses_.sin[i], left_[i]);
      if (bin > heaviest) heaviest = bin, seed = i;
    }
    clusters_.push_back(take_cluster(seed));
    rest -= clusters_.back().probability;
  }
  std::stable_sort(
      clusters_.begin(), clusters_.end(),
      [](const Hypothesis& a, const Hypothesis& b) { return a.probability > b.probability; });
  const Pose2 off = between(expected, clusters_.front().T_map_robot);
  leapt_ = updates_ > 0 && (off.translation().norm() > kLeap || std::abs(off.theta) > kLeapTurn);
}

Hypothesis MonteCarlo::take_cluster(std::size_t seed) {
  struct Sums {
    double w = 0, x = 0, y = 0, c = 0, s = 0;
  };
  double x = poses_.x[seed], y = poses_.y[seed], c = poses_.cos[seed], s = poses_.sin[seed];
  const double nearest = std::cos(kReachTurn);
  const auto within = [&](std::size_t i) {
    const double dx = poses_.x[i] - x, dy = poses_.y[i] - y;
    return dx * dx + dy * dy < kReach * kReach && poses_.cos[i] * c + poses_.sin[i] * s > nearest;
  };
  for (int round = 0; round < 2; ++round) {
    Sums sum;
    for (std::size_t i = 0; i < left_.size(); ++i) {
      if (!within(i)) continue;
      const double w = left_[i];
      sum.w += w, sum.x += w * poses_.x[i], sum.y += w * poses_.y[i];
      sum.c += w * poses_.cos[i], sum.s += w * poses_.sin[i];
    }
    const double length = std::hypot(sum.c, sum.s);
    x = sum.x / sum.w, y = sum.y / sum.w, c = sum.c / length, s = sum.s / length;
  }
  Hypothesis cluster;
  Vec3 mean = Vec3::Zero();  // off (x, y, theta); not quite zero, for the reach has moved
  for (std::size_t i = 0; i < left_.size(); ++i) {
    if (!within(i) && i != seed) continue;
    const double w = std::exchange(left_[i], 0);
    const Vec3 off(poses_.x[i] - x, poses_.y[i] - y, poses_.sin[i] * c - poses_.cos[i] * s);
    cluster.probability += w;
    mean += w * off;
    cluster.covariance += w * off * off.transpose();
  }
  mean /= cluster.probability;
  cluster.covariance = cluster.covariance / cluster.probability - mean * mean.transpose();
  cluster.T_map_robot = from_vector(Vec3(x, y, std::atan2(s, c)) + mean);
  return cluster;
}

std::size_t MonteCarlo::bytes() const {
  return weights_.size() * (4 * sizeof(float) + sizeof(double));
}

// At the last update, carried on by the wheels since.
Estimate MonteCarlo::estimate() const {
  const Hypothesis& best = clusters_.front();
  Estimate estimate;
  estimate.time = time_;
  estimate.T_map_robot = best.T_map_robot * T_update_robot_;
  Mat3 swing = Mat3::Identity(), turn = Mat3::Identity();
  const Vec2 way = estimate.T_map_robot.translation() - best.T_map_robot.translation();
  swing(0, 2) = -way.y(), swing(1, 2) = way.x();
  turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(estimate.T_map_robot.theta).toRotationMatrix();
  estimate.covariance =
      swing * best.covariance * swing.transpose() + turn * moved_covariance_ * turn.transpose();
  if (least_known(estimate.covariance).sigma > kWeak) degrade(estimate);
  if (!found() || !fits(options_.doubt)) estimate.health = Health::degraded;
  if (best.probability < kFound || leapt_ || !fits(options_.lost)) estimate.health = Health::lost;
  return estimate;
}

// The cloud's mean errs by centimetres: it is of a few hundred samples of a belief that is kept
// wide. Within its spread the scans are matched as in tracking. That may have begun at the wrong
// wall end, so at each update one that begins at the cloud's mean may take over. The covariance
// stays the cloud's: wider than the error, but not too sure where a map of cells misleads matching.
Estimate MonteCarlo::refined(const FedScan& scan, Estimate cloud) {
  if (tracker_) tracked_ = tracker_->add(scan);
  if (cloud.health == Health::lost || (tracker_ && !agrees(tracked_, cloud))) tracker_.reset();
  if (cloud.health != Health::lost && (updated_ || !tracker_)) track_from(scan, cloud);
  if (tracker_) cloud.T_map_robot = tracked_.T_map_robot;
  return cloud;
}

// From the mean; where there is no tracker yet, also from either side of it, the farther way.
void MonteCarlo::track_from(const FedScan& scan, const Estimate& cloud) {
  const auto [longest, direction] = least_known(cloud.covariance);
  TrackingOptions within;
  within.start_sigma = longest;
  within.start_turn = std::sqrt(cloud.covariance(2, 2));
  FedScan here = scan;
  here.T_previous_robot = {};
  const bool alone = !tracker_;
  for (const double side : {0.0, kAside, -kAside}) {
    if (side != 0 && !alone) break;
    const Vec2 at = cloud.T_map_robot.translation() + side * longest * direction;
    Tracker other(place_, within, {at.x(), at.y(), cloud.T_map_robot.theta});
    const Estimate found = other.add(here);
    const double least = tracker_ ? tracker_->match().score + (alone ? 0 : kBetter) : 0;
    if (!agrees(found, cloud) || other.match().score <= least) continue;
    tracker_.emplace(std::move(other));
    tracked_ = found;
  }
}

// New particles where the fit falls off, or where several places are as good.
std::size_t MonteCarlo::fresh_wanted() const {
  double share = fits(options_.doubt) ? 0 : 1 - std::exp(slow_ + options_.doubt - fast_);
  if (clusters_.front().probability < kFound) share = std::max(share, kSearching);
  return static_cast<std::size_t>(share * options_.particles);
}

// As many as the belief asks for: Fox's bound on the bins that a full draw fills.
std::size_t MonteCarlo::wanted_size() {
  chosen_.resize(static_cast<std::size_t>(options_.particles));
  RandomStream random = stream(options_.seed, updates_, resampling, 0);
  filter::resample_systematic(weights_, random, chosen_);
  bins_.clear();
  for (std::size_t k = 0; k < chosen_.size(); ++k)
    if (const std::uint32_t i = chosen_[k]; k == 0 || i != chosen_[k - 1])
      bins_.add(poses_.x[i], poses_.y[i], poses_.cos[i], poses_.sin[i], 1);
  return std::clamp(filter::kld_size(bins_.count(), options_.kld_error, options_.kld_quantile),
                    static_cast<std::size_t>(std::min(options_.least, options_.particles)),
                    chosen_.size());
}

// The last `fresh` places are left to draw_fresh().
void MonteCarlo::resample(std::size_t fresh) {
  const std::size_t n = fresh > 0 ? static_cast<std::size_t>(options_.particles) : wanted_size();
  chosen_.resize(n - fresh);
  RandomStream random = stream(options_.seed, updates_, resampling, 1);
  filter::resample_systematic(weights_, random, chosen_);
  drawn_.resize(n);
  for (std::size_t k = 0; k < chosen_.size(); ++k) {
    const std::uint32_t i = chosen_[k];
    drawn_.x[k] = poses_.x[i], drawn_.y[k] = poses_.y[i];
    drawn_.cos[k] = poses_.cos[i], drawn_.sin[k] = poses_.sin[i];
  }
  std::swap(poses_, drawn_);
  resize(n);
}

// Anywhere, about places where the scan fits (each gets as many), and about the estimate, from
// which the wheels may just have slipped. Those that are elsewhere than the cloud begin lighter.
void MonteCarlo::draw_fresh(const Scan& scan, std::size_t first) {
  std::vector<FoundPlace> places;
  if (options_.proposals) places = global_.find(scan).places;
  const Mat3 least = diagonal(kProposalSigma, kProposalTurn),
             most = diagonal(kProposalMost, kProposalTurnMost).inverse();
  std::vector<Mat3> roots;
  for (const Hypothesis& h : places)
    roots.push_back(root_of(((h.covariance + least).inverse() + most).inverse()));
  const bool believed = !clusters_.empty() && clusters_.front().probability >= kFound;
  const Mat3 slip = root_of(diagonal(options_.slip, options_.slip_turn));
  for (std::size_t i = first; i < poses_.size(); ++i) {
    RandomStream random = stream(options_.seed, updates_, drawing, i);
    const double what = random.uniform();
    if (believed && what < kSlipped) {
      poses_.set(i, draw_near(clusters_.front().T_map_robot, slip, random));
      continue;
    }
    const bool anywhere = places.empty() || what > 1 - kAnywhere;
    const std::size_t k = anywhere ? 0 : i % places.size();
    poses_.set(
        i, anywhere ? draw_anywhere(random) : draw_near(places[k].T_map_robot, roots[k], random));
    if (believed) log_weights_[i] = -options_.carried;
  }
}

Pose2 MonteCarlo::draw_anywhere(RandomStream& random) const {
  const auto cell = static_cast<int>(floor_[random.below(floor_.size())]);
  const map::KnownMap& map = place_->known;
  const double x = cell % map.width + random.uniform(), y = cell / map.width + random.uniform();
  return {map.x0 + map.resolution * x, map.y0 + map.resolution * y, random.uniform(-kPi, kPi)};
}

Pose2 MonteCarlo::draw_near(const Pose2& mean, const Mat3& root, RandomStream& random) const {
  const double x = normal_(random), y = normal_(random), turn = normal_(random);
  return from_vector(mean.vector() + root * Vec3(x, y, turn));
}

}  // namespace majak::localize
