// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/hybrid.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "majak/core/random.hpp"
#include "majak/filter/resampling.hpp"
#include "majak/slam/chain.hpp"

namespace majak::slam {
namespace {

constexpr double kHeldTogether = 100;  // neighbours on the same old ground: their errors agree
constexpr double kHeldReach = 0.03;    // m, by which tracking may move the robot, however sure
constexpr double kOneScale = 20;       // m of way over which the wheels' scale errs alike
constexpr std::uint64_t kStreams = std::uint64_t{1} << 40;  // of random numbers, for each purpose
constexpr std::size_t kLocalPoints = 400;
constexpr std::size_t kCalm = 4;      // every fourth particle errs less, so that there are always
constexpr double kCalmShare = 0.3;    // some near the most likely pose, however wide the others are
constexpr int kVotes = 4;             // at least, of draws that match as well as the best
constexpr double kTie = 0.04;         // of their scores
const Vec3 kTried(0.1, 0.1, 0.02);    // m, m, rad: about each particle, lest a set that has grown
                                      // too narrow sees nothing
constexpr int kDraws = 24;            // particles that are matched
constexpr double kIndependent = 30;   // returns of a look that tell on their own
constexpr double kAgreedTurn = 0.03;  // rad
constexpr double kOnMap = 0.1, kNearMap = 0.15;  // m
constexpr double kLookMemory = 0.1;              // weight of the newest look in the running mean
constexpr double kQuietReach = 6;                // m about a place that is not tried

Vec3 normal3(RandomStream& random) {
  const double x = random.normal(), y = random.normal(), theta = random.normal();
  return {x, y, theta};
}

/// Of a match: information in the axes of its own pose, never quite nothing.
Mat3 own_information(const match::Match& match) {
  const Mat3 r = rotation3(match.T_map_robot.theta);
  const Mat3 own = kSharedErrors * r.transpose() * match.information * r;
  return 0.5 * (own + own.transpose()) + 1e-3 * Mat3::Identity();
}

bool same_place(const Pose2& a, const Pose2& b, double reach) {
  const Pose2 off = between(a, b);
  return std::hypot(off.x, off.y) < reach && std::abs(off.theta) < kAgreedTurn;
}

/// Share of the points that lie within `gate` m of a surface that was seen from the same side: a
/// wall's other face is not the wall.
double share_facing(const match::ScanPoints& points, const map::SurfelMap& map,
                    const Pose2& T_map_robot, double gate) {
  const double c = std::cos(T_map_robot.theta), s = std::sin(T_map_robot.theta);
  int on = 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double x = c * points.x[k] - s * points.y[k] + T_map_robot.x;
    const double y = s * points.x[k] + c * points.y[k] + T_map_robot.y;
    const auto i = map.nearest(static_cast<float>(x), static_cast<float>(y));
    if (i == map::SurfelMap::kNone) continue;
    const map::Surfel& surfel = map.surfel(i);
    const double nx = c * points.nx[k] - s * points.ny[k], ny = s * points.nx[k] + c * points.ny[k];
    on += std::hypot(x - surfel.x, y - surfel.y) < gate && nx * surfel.nx + ny * surfel.ny >= 0;
  }
  return points.size() > 0 ? static_cast<double>(on) / static_cast<double>(points.size()) : 0;
}

/// Does the beam from `laser` to `end` (map frame) pass through a surface well before its end?
bool passes_through(const map::SurfelMap& map, const Vec2& laser, const Vec2& end) {
  constexpr double kStep = 0.1, kBefore = 0.3, kTurned = 0.03, kNearEdge = 0.05, kSquare = 0.5;
  const double range = (end - laser).norm();
  const Vec2 d = (end - laser) / std::max(range, 1e-6);
  for (double r = 0.3; r < range - kBefore - kTurned * range; r += kStep) {
    const Vec2 p = laser + r * d;
    const auto i = map.nearest(static_cast<float>(p.x()), static_cast<float>(p.y()));
    if (i == map::SurfelMap::kNone) continue;
    const map::Surfel& s = map.surfel(i);
    const Vec2 normal(s.nx, s.ny), off = Vec2(s.x, s.y) - p;
    const double square = normal.dot(d);
    if (std::abs(square) < kSquare) continue;  // grazing: no telling
    const double ahead = normal.dot(off) / square;
    if (std::abs(ahead) < kStep / 2 && (ahead * d - off).norm() < kNearEdge) return true;
  }
  return false;
}

}  // namespace

Hybrid::Hybrid(const ScanChainOptions& chain, const HybridOptions& options, Threads threads)
    : options_(options), threads_(threads), chain_(chain), map_(options.map) {}

std::optional<Estimate> Hybrid::add(Event event) {
  touched_ = 0;
  chain_.add(std::move(event));
  return take_scans();
}

std::optional<Estimate> Hybrid::take_scans() {
  constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();
  std::optional<Estimate> newest;
  while (const auto step = chain_.next()) {
    if (step->key) take_key();
    work(options_.latency_keys > 0 ? static_cast<std::size_t>(options_.latency_keys) : kAll);
    newest = chain_.settle();
  }
  return newest;
}

void Hybrid::take_key() {
  const std::size_t k = chain_.keys().size() - 1;
  held_.push_back(0), anchors_.push_back(k);
  if (k == 0) return begin();
  spread(k);
  if (options_.forced && options_.forced->at == k) {
    work(std::numeric_limits<std::size_t>::max());
    return close(options_.forced->onto,
                 {chain_.keys()[options_.forced->onto].T_map_robot, 1e4 * Mat3::Identity()});
  }
  if (move_) return;
  draw_old();
  const double sigma = widest();
  if (sigma < options_.narrow && hold(k, map_, kHeldReach + 3 * sigma)) {
    const KeyScan& key = chain_.keys()[k];
    narrow(key.T_map_robot, key.match_information.inverse());
    if (widest() < options_.narrow) stand_on(visit_at(key.T_map_robot));
  }
  judge();
  if (driven() - looked_ >= options_.look_every) look();
}

void Hybrid::begin() {
  way_ = {0}, steps_ = {Mat3::Zero()}, spreads_ = {1e-9 * Mat3::Identity()};
  const auto n = static_cast<std::size_t>(options_.particles);
  particles_.assign(n, chain_.keys()[0].T_map_robot);
  for (std::size_t i = 0; i < n; ++i)
    scales_.push_back(options_.drift.scale_sigma *
                      RandomStream(static_cast<std::uint64_t>(options_.seed), 0, i).normal());
}

// Where the robot may be: each particle errs on its own, and all the way in one scale (MATH 24.1).
void Hybrid::spread(std::size_t k) {
  const KeyScan& key = chain_.keys()[k];
  const Pose2 step = between(chain_.keys()[k - 1].T_front_robot, key.T_front_robot);
  const double way = step.translation().norm();
  const Drift drift = drift_to(key, options_.drift);
  const Vec3 by_wheels = drift.by_motion * Vec3(step.x, step.y, 0);
  const Mat3 root = drift.covariance.llt().matrixL();
  for (std::size_t i = 0; i < particles_.size(); ++i) {
    RandomStream random(static_cast<std::uint64_t>(options_.seed), k, i);
    const Vec3 error = root * normal3(random) + scales_[i] * by_wheels;
    particles_[i] = particles_[i] * step * exp(i % kCalm == 0 ? Vec3(kCalmShare * error) : error);
  }
  Mat3 off = ground_doubt() + 1e-9 * Mat3::Identity();
  for (const Pose2& p : particles_) {
    const Vec3 d = log(between(key.T_map_robot, p));
    off += d * d.transpose() / static_cast<double>(particles_.size());
  }
  spreads_.resize(k), spreads_.push_back(off);
  if (k < way_.size()) return;  // once more, after a correction was taken back
  const double alike = std::pow(options_.drift.scale_sigma, 2) * kOneScale / std::max(way, 0.05);
  way_.push_back(way_.back() + way + 0.2 * std::abs(step.theta));
  steps_.push_back(drift.covariance + alike * by_wheels * by_wheels.transpose());
}

double Hybrid::widest() const {
  Vec2 mean = Vec2::Zero();
  for (const Pose2& p : particles_) mean += p.translation();
  mean /= static_cast<double>(particles_.size());
  Mat3 covariance = Mat3::Zero();
  for (const Pose2& p : particles_) {
    const Vec2 d = p.translation() - mean;
    covariance.topLeftCorner<2, 2>() += d * d.transpose();
  }
  return least_known(covariance / static_cast<double>(particles_.size())).sigma;
}

/// What the ground adds to the particles' spread, in the axes of the newest key scan.
Mat3 Hybrid::ground_doubt() const {
  const Mat3 a =
      adjoint(between(chain_.keys().back().T_map_robot, chain_.keys()[doubt_.on].T_map_robot));
  return a * doubt_.covariance * a.transpose();
}

/// The newest key scan is as good as fixed to an old one.
void Hybrid::stand_on(std::size_t visit) {
  anchors_.back() = visit;
  doubt_ = {spreads_[visit], visit};
}

void Hybrid::draw_old() {
  const KeyScans& keys = chain_.keys();
  for (; way_[drawn_] + options_.old_way <= driven(); ++drawn_)
    match::add_to(map_, keys[drawn_].points, keys[drawn_].T_map_robot);
}

// Incremental maximum likelihood on old ground; false where there is none, or where it would move
// the robot farther than it can be off.
bool Hybrid::hold(std::size_t k, const map::SurfelMap& map, double reach) {
  KeyScan& key = chain_.keys()[k];
  const double gate = options_.align.gate;
  if (share_facing(key.points, map, key.T_map_robot, gate) < options_.old_share) return false;
  match::PosePrior prior{key.T_map_robot, Mat3::Zero()};
  const Vec3 sigma(options_.way_sigma, options_.way_sigma, options_.turn_sigma);
  prior.information.diagonal() = sigma.cwiseAbs2().cwiseInverse();
  const match::Match match = match::align(key.points, map, prior, options_.align);
  if (share_facing(key.points, map, match.T_map_robot, kNearMap) < options_.old_share) return false;
  if (!same_place(key.T_map_robot, match.T_map_robot, reach)) return false;
  key.T_map_robot = match.T_map_robot;
  held_[k] = 1;
  if (k > 0 && held_[k - 1])
    steps_[k] = (steps_[k].inverse() + kHeldTogether * own_information(match)).inverse();
  return true;
}

// The particles after a sighting that the robot is at this pose (Evensen 1994; MATH 24.2): what it
// does not tell stays as spread as it was.
void Hybrid::narrow(const Pose2& T_map_robot, const Mat3& covariance) {
  std::vector<Vec3> off;
  Vec3 mean = Vec3::Zero();
  for (const Pose2& p : particles_) off.push_back(log(between(T_map_robot, p)));
  for (const Vec3& d : off) mean += d / static_cast<double>(off.size());
  Mat3 spread = Mat3::Zero();
  for (const Vec3& d : off)
    spread += (d - mean) * (d - mean).transpose() / static_cast<double>(off.size());
  const Mat3 gain = spread * (spread + covariance).inverse();
  const Mat3 root = covariance.llt().matrixL();
  for (std::size_t i = 0; i < off.size(); ++i) {
    RandomStream random(static_cast<std::uint64_t>(options_.seed), kStreams + way_.size(), i);
    particles_[i] = T_map_robot * exp(off[i] + gain * (root * normal3(random) - off[i]));
  }
}

void Hybrid::begin_anew(const Place& place) {
  const Mat3 root = Mat3(place.information.inverse()).llt().matrixL();
  for (std::size_t i = 0; i < particles_.size(); ++i) {
    RandomStream random(static_cast<std::uint64_t>(options_.seed), kStreams + way_.size(), i);
    particles_[i] = place.T_map_robot * exp(root * normal3(random));
  }
}

Hybrid::Fit Hybrid::fit_of(const match::ScanPoints& points, const Pose2& T_map_robot) const {
  const Vec2 laser = T_map_robot * points.laser;
  Fit fit{share_facing(points, map_, T_map_robot, kOnMap), 0};
  int all = 0, through = 0;
  for (std::size_t i = 0; i < points.size(); i += 2, ++all)
    through += passes_through(map_, laser, T_map_robot * Vec2(points.x[i], points.y[i]));
  fit.through = all > 0 ? static_cast<double>(through) / all : 0;
  return fit;
}

/// Of a few of the newest scans, were the newest taken there.
Hybrid::Fit Hybrid::newest_fit(const Pose2& T_map_robot) const {
  const KeyScans& keys = chain_.keys();
  const KeyScan& newest = keys.back();
  Fit sum;
  double n = 0;
  for (std::size_t back = 0; back < 24 && back < keys.size(); back += 8, ++n) {
    const KeyScan& key = keys[keys.size() - 1 - back];
    const Fit fit =
        fit_of(key.points, T_map_robot * between(newest.T_front_robot, key.T_front_robot));
    sum.on += fit.on, sum.through += fit.through;
  }
  return {sum.on / n, sum.through / n};
}

/// The newest key scans together, in the robot's frame, evenly thinned.
match::ScanPoints Hybrid::local_map() const {
  const KeyScans& keys = chain_.keys();
  map::SurfelMap map(options_.map);
  for (std::size_t i = 0, k = keys.size() - 1;
       i < static_cast<std::size_t>(options_.local_map_keys); ++i, --k) {
    match::add_to(map, keys[k].points, between(keys.back().T_front_robot, keys[k].T_front_robot));
    if (k == 0 || keys[k].weak_step) break;
  }
  match::ScanPoints points;
  const std::vector<map::Surfel>& all = map.surfels();
  for (std::size_t i = 0; i < all.size(); i += all.size() / kLocalPoints + 1) {
    points.x.push_back(all[i].x), points.y.push_back(all[i].y);
    points.nx.push_back(all[i].nx), points.ny.push_back(all[i].ny);
  }
  return points;
}

void Hybrid::look() {
  looked_ = driven();
  const Fit fit = newest_fit(chain_.keys().back().T_map_robot);
  agreement_ += kLookMemory * (fit.agreement() - agreement_);
  if (held_.back() && widest() < options_.narrow) return;
  const auto place = place_agreed_on();
  if (!place || is_quiet(place->T_map_robot) || !told_before(place->T_map_robot)) return;
  if (widest() < options_.narrow &&
      same_place(place->T_map_robot, chain_.keys().back().T_map_robot, options_.narrow))
    return;  // nothing new
  close(visit_at(place->T_map_robot), *place);
}

/// The particles; every other one with the doubt of the ground below it.
std::vector<Pose2> Hybrid::tries() const {
  const Mat3 root = Mat3(ground_doubt() + 1e-9 * Mat3::Identity()).llt().matrixL();
  std::vector<Pose2> tried;
  for (std::size_t i = 0; i < particles_.size(); ++i) {
    RandomStream random(static_cast<std::uint64_t>(options_.seed), 2 * kStreams + way_.size(), i);
    const Vec3 more = root * normal3(random), jitter = kTried.cwiseProduct(normal3(random));
    tried.push_back(particles_[i] * exp(i % 2 == 0 ? jitter : Vec3(more + jitter)));
  }
  return tried;
}

/// Particles drawn by how the local map lies on the old ground from there, each moved to where it
/// lies best; empty where the ground is not old.
std::vector<match::Match> Hybrid::matches_of_particles(const match::ScanPoints& points) const {
  std::vector<double> log_weights;
  double best = 0;
  const std::vector<Pose2> tried = tries();
  for (const Pose2& p : tried) {
    const double share = share_facing(points, map_, p, kNearMap);
    best = std::max(best, share);
    log_weights.push_back(kIndependent * share);
  }
  if (best < options_.old_share) return {};
  std::vector<double> weights(log_weights.size());
  filter::normalise(log_weights, weights);
  RandomStream random(static_cast<std::uint64_t>(options_.seed), 3 * kStreams + way_.size(), 0);
  std::vector<std::uint32_t> drawn(kDraws);
  filter::resample_systematic(weights, random, drawn);
  match::AlignOptions align = options_.align;
  align.gate = 0.4;
  align.max_iterations = 20;
  std::vector<match::Match> matches;
  for (const std::uint32_t i : drawn)
    matches.push_back(match::align(points, map_, {tried[i], Mat3::Zero()}, align));
  return matches;
}

std::optional<Hybrid::Place> Hybrid::place_agreed_on() const {
  const match::ScanPoints points = local_map();
  const auto matches = matches_of_particles(points);
  if (matches.empty()) return std::nullopt;
  const auto best =
      std::max_element(matches.begin(), matches.end(),
                       [](const auto& a, const auto& b) { return a.score < b.score; });
  if (share_facing(points, map_, best->T_map_robot, kNearMap) < options_.old_share ||
      !match::holds_all_round(best->information))
    return std::nullopt;
  int votes = 0, against = 0;
  for (const match::Match& m : matches)
    if (m.score > best->score - kTie) {
      ++votes;
      against += !same_place(best->T_map_robot, m.T_map_robot, options_.agreed);
    }
  if (votes < kVotes || against > 0) return std::nullopt;
  if (newest_fit(best->T_map_robot).through > options_.through_share) return std::nullopt;
  return Place{best->T_map_robot, own_information(*best)};
}

// One look may err: those that follow must tell the same.
bool Hybrid::told_before(const Pose2& T_map_robot) {
  const Pose2& believed = chain_.keys().back().T_map_robot;
  const bool again = rumour_ && same_place(*rumour_ * believed, T_map_robot, options_.agreed);
  told_ = again ? told_ + 1 : 1;
  rumour_ = T_map_robot * believed.inverse();
  return told_ >= options_.witnesses;
}

bool Hybrid::is_quiet(const Pose2& T_map_robot) const {
  return quiet_ && driven() < quiet_->second &&
         (T_map_robot.translation() - quiet_->first).norm() < kQuietReach;
}

Mapping Hybrid::finish() {
  chain_.end();
  take_scans();
  require_keys(chain_.keys());
  work(std::numeric_limits<std::size_t>::max());
  chain_.hang_all(threads_);
  Mapping mapping;
  mapping.corrections = std::move(corrections_);
  mapping.belief_bytes =
      std::max(most_bytes_, map_.bytes()) + particles_.size() * (sizeof(Pose2) + sizeof(double));
  mapping.site = chain_.finish();
  for (const LoopCorrection& c : mapping.corrections)
    mapping.site.report.count(c.undone ? "loops corrected and taken back" : "loops corrected");
  if (mapping.corrections.empty())
    mapping.site.report.count("no loop found: hybrid is incremental maximum likelihood here");
  return mapping;
}

void describe(OptionFields& f, HybridOptions& o) {
  f.add("hybrid.seed", o.seed, {"1", "of the particles"});
  f.add("hybrid.particles", o.particles, {"1", "samples of where the robot may be", 16, 1e6});
  f.add("hybrid.old_way", o.old_way, {"m", "ground is old when it was seen so long ago", 2, 1000});
  f.add("hybrid.local_map_keys", o.local_map_keys,
        {"1", "newest key scans that are held against old ground together", 1, 1000});
  f.add("hybrid.look_every", o.look_every, {"m", "between looks whether ground is old", 0, 100});
  f.add("hybrid.narrow", o.narrow,
        {"m", "spread below which the robot is tracked on old ground", 0.01, 10});
  f.add("hybrid.old_share", o.old_share,
        {"1", "share of returns on the map that makes ground old", 0, 1});
  f.add("hybrid.through_share", o.through_share,
        {"1", "at most, of beams that pass through a wall of the map", 0, 1});
  f.add("hybrid.agreed", o.agreed, {"m", "particles agree when so near", 0.01, 10});
  f.add("hybrid.witnesses", o.witnesses, {"1", "looks that must tell the same", 1, 100});
  f.add("hybrid.probation", o.probation,
        {"m", "of way in which a correction can be taken back", 0, 1e6});
  f.add("hybrid.fall", o.fall, {"1", "of the fit, by which it must fall for that", 0, 1});
  f.add("hybrid.quiet", o.quiet, {"m", "of way for which such a place is not tried", 0, 1e6});
  f.add("hybrid.keep_loops", o.keep_loops,
        {"", "false: a loop within a loop bends like everything else on the way"});
  f.add("hybrid.latency_keys", o.latency_keys,
        {"1", "key scans that may be moved or drawn anew per scan, 0: all", 0, 1e9});
  f.add("hybrid.way_sigma", o.way_sigma, {"m", "of the step between key scans", 1e-4, 10});
  f.add("hybrid.turn_sigma", o.turn_sigma, {"rad", "of that step", 1e-5, 3.15});
  f.add("hybrid.match_share", o.drift.match_share,
        {"1", "share of a match's covariance that adds up", 1e-3, 1});
  f.add("hybrid.scale_sigma", o.drift.scale_sigma,
        {"1", "of the way that only the wheels count", 0, 1});
}

}  // namespace majak::slam
