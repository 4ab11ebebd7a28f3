// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/ekf_slam.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "majak/core/chi_square.hpp"

namespace majak::slam {
namespace {

using filter::LandmarkFilter;
using motion::WheelStep;

constexpr double kThrough = 0.7;  // m behind a landmark where a beam ends that went through it
constexpr double kForgotten = 1;  // s after which a guess that is not seen again is dropped
constexpr const char* kStuck =
    "scans while the steering was stuck: the same as never before, or though the landmarks turned";
constexpr const char* kSlipped = "scans in which the landmarks contradicted the wheels";
constexpr const char* kFrameless = "scans before satellites told where the map lies";
constexpr const char* kMoved = "things that did not stand still for long; not in the map";
constexpr double kInView = 20;  // m, within which a landmark must be seen

LandmarkFilter beginning(const EkfSlamOptions& o, const Pose2& start) {
  LandmarkFilter::Body covariance = LandmarkFilter::Body::Zero();
  LandmarkFilter::Extra sigma;
  sigma << o.scale_sigma, o.turn_scale_sigma, o.turn_offset_sigma, o.steering_curve_sigma,
      o.steering_square_sigma, o.crab_sigma, o.lag_sigma, o.antenna_sigma, o.antenna_sigma,
      o.gps_sigma, o.gps_sigma;
  covariance.diagonal().tail<LandmarkFilter::kExtra>() = sigma.cwiseAbs2();
  return {start, MotionInput::counted_right().at, covariance};
}

}  // namespace

EkfSlam::EkfSlam(const EkfSlamOptions& options, const Pose2& start)
    : options_(options),
      filter_(beginning(options, start)),
      motion_(options.wheels, options.wheelbase, options.idle_noise, options.crab_wander),
      pieces_(options.pieces),
      since_scan_(MotionInput::counted_right()) {}

std::optional<Estimate> EkfSlam::add(const Event& event) {
  if (const auto* wheels = std::get_if<WheelMotion>(&event)) motion_.add(*wheels);
  if (const auto* odometry = std::get_if<Odometry>(&event)) motion_.add(*odometry);
  if (const auto* fix = std::get_if<GpsFix>(&event); fix && options_.use_gps) see(*fix);
  const auto* scan = std::get_if<Scan>(&event);
  if (!scan || scan->laser != 0) return std::nullopt;
  if (scan->T_odom_robot) motion_.add(Odometry{scan->time, *scan->T_odom_robot, {}, {}});
  return see(*scan);
}

// The textbook's two lines: the robot has moved, and grown less sure of where it is. All landmarks
// that it saw before stay where they are, but what is known of robot and landmarks together moves.
void EkfSlam::predict(Time time) {
  MotionInput::Motion motion = motion_.take(time);
  const double seconds = begun_ ? std::max(0.0, to_seconds(time - clock_)) : 0;
  const double keep = std::exp(-seconds / options_.gps_memory);
  motion.keep.tail<2>().setConstant(keep);
  motion.extra_noise.tail<2>().setConstant(options_.gps_sigma * options_.gps_sigma *
                                           (1 - keep * keep));
  if (mistrusted(time)) motion.noise += told_nothing(seconds);
  filter_.predict(motion);
  since_scan_.then(motion);
  clock_ = begun_ ? std::max(clock_, time) : time;
  begun_ = true;
}

Estimate EkfSlam::see(const Scan& scan) {
  predict(scan.time);
  steps_.push_back(std::exchange(since_scan_, MotionInput::counted_right()));
  const Vec2 here = filter_.T_map_robot().translation();
  if ((here - looked_from_).norm() > options_.look_around || known_.empty()) {
    filter_.look_around(here, options_.near);
    looked_from_ = here;
  }
  const std::vector<Seen> seen = look(scan);
  Matching matching = match(seen, filter_.covariance());
  match_without_wheels(seen, matching);
  if (mistrusted(clock_)) report_.count(stuck_ ? kStuck : kSlipped);
  doubt(scan.time, matching);
  correct(seen, matching);
  initialise(seen, matching.choice);
  forget(scan);
  frameless_ += !oriented_;
  estimates_.push_back(estimate(scan.time));
  return as_known_now(estimates_.back());
}

// ---- Correction ------------------------------------------------------------------------------

void EkfSlam::correct(const std::vector<Seen>& seen, const Matching& matching) {
  const auto& choice = matching.choice;
  const auto n = 2 * static_cast<Eigen::Index>(
                         std::count_if(choice.begin(), choice.end(), [](int c) { return c >= 0; }));
  if (n == 0) return;
  held_at_ = motion_.way();
  Eigen::VectorXd residual(n);
  Eigen::MatrixXd by_state = Eigen::MatrixXd::Zero(n, filter_.covariance().cols());
  Eigen::MatrixXd noise = Eigen::MatrixXd::Zero(n, n);
  Eigen::Index row = 0;
  for (std::size_t s = 0; s < seen.size(); ++s) {
    if (choice[s] < 0) continue;
    const Pairing& p = *matching.pairing(s);
    residual.segment<2>(row) = p.innovation;
    by_state.block<2, 3>(row, 0) = p.by_state.leftCols<3>();
    by_state.block<2, 2>(row, p.column) = p.by_state.rightCols<2>();
    noise.block<2, 2>(row, row) = centre(seen[s], p.landmark).noise;
    noise.block<2, 2>(row, row).diagonal().array() += alike();
    remember(seen[s], p.landmark);
    row += 2;
  }
  const double nis = filter_.correct(residual, by_state, noise);
  innovations_.push_back({clock_, "landmarks", nis, static_cast<int>(n), true});
}

// What sightings from nearly the same side have in common counts once a way, however many scans are
// taken on it.
double EkfSlam::alike() const {
  constexpr double kLeast = 0.02;  // m, of a way
  const double way = std::max(kLeast, steps_.back().T_from_to.translation().norm());
  return options_.alike_sigma * options_.alike_sigma * options_.alike_way / way;
}

// A sighting that is certainly none of those known is a new landmark; what is neither is left out.
void EkfSlam::initialise(const std::vector<Seen>& seen, const std::vector<int>& choice) {
  const double gate = chi_square_quantile(options_.apart, 2);
  std::vector<std::size_t> fresh;
  for (std::size_t s = 0; s < seen.size(); ++s) {
    if (choice[s] != kNew) continue;
    const Vec2 p_map = filter_.T_map_robot() * seen[s].q_robot;
    const auto& near = filter_.near();
    const bool apart = std::all_of(near.begin(), near.end(), [&](int id) {
      const double off = (filter_.landmark(id) - p_map).norm();
      return off > options_.least_apart &&
             (off > 20 || pair(seen[s], id, filter_.covariance()).nis > gate);
    });
    if (apart) fresh.push_back(s);
  }
  drop_guesses();
  const bool first = known_.empty();  // where the map begins
  for (const std::size_t s : fresh) {
    if (!first && !confirmed(seen[s])) continue;
    const double diameter = seen[s].diameter, variance = seen[s].diameter_variance;
    const Centre at = centre(seen[s], diameter, variance);
    const int id = filter_.add(
        at.q_robot, at.noise + std::pow(options_.alike_sigma, 2) * Eigen::Matrix2d::Identity());
    known_.push_back({clock_, 0, 0, 1, 0, diameter, variance});
    sightings_.push_back({estimates_.size(), id, seen[s]});
  }
}

// Only what stands still for some sightings becomes a landmark: branches, hedges and people do not
// touch the map.
bool EkfSlam::confirmed(const Seen& seen) {
  const Vec2 p_map = filter_.T_map_robot() * seen.q_robot;
  const auto same = [&](const Guess& g) { return (g.p_map - p_map).norm() < options_.guess_gate; };
  const auto guess = std::find_if(guesses_.begin(), guesses_.end(), same);
  if (guess == guesses_.end()) {
    guesses_.push_back({p_map, clock_, clock_, 1});
    return false;
  }
  ++guess->sightings;
  guess->last = clock_;
  const bool stands = to_seconds(clock_ - guess->first) >= options_.stands;
  if (guess->sightings < options_.confirmed || !stands) return false;
  guesses_.erase(guess);
  return true;
}

void EkfSlam::drop_guesses() {
  const auto dropped = [&](const Guess& g) { return to_seconds(clock_ - g.last) > kForgotten; };
  for (const Guess& g : guesses_)
    if (dropped(g) && g.sightings >= options_.confirmed) report_.count(kMoved);
  std::erase_if(guesses_, dropped);
}

// Does a beam go through where it should stand?
bool EkfSlam::looked_through(const Scan& scan, int id) const {
  const Pose2 T_map_laser = filter_.T_map_robot() * scan.T_robot_laser;
  const Vec2 q = T_map_laser.inverse() * filter_.landmark(id);
  const double range = q.norm(),
               beam = (std::atan2(q.y(), q.x()) - scan.start_angle) / scan.angle_step;
  if (range > kInView || !(beam > 0 && beam < static_cast<double>(scan.ranges.size()) - 1))
    return false;
  const auto least = static_cast<std::size_t>(beam);
  return scan.ranges[least] > range + kThrough && scan.ranges[least + 1] > range + kThrough;
}

Eigen::Matrix2d EkfSlam::covariance_of(int id) const {
  const int column = filter_.column(id);
  return filter_.covariance().block<2, 2>(column, column);
}

// Landmarks that are no longer there. Where several are not, and no other is, the robot is not.
void EkfSlam::forget(const Scan& scan) {
  const std::vector<int> near = filter_.near();
  const bool held = held_at_ == motion_.way();
  int missing = 0;
  for (const int id : near) {
    Known& known = known_[static_cast<std::size_t>(id)];
    const bool missed = looked_through(scan, id);
    missing += missed;
    known.missed += missed;
    if (known.missed < options_.gone) continue;
    report_.count("landmarks that were there no more when looked at again");
    known.gone = true;
    known.p_map = filter_.landmark(id);
    known.covariance = covariance_of(id);
    filter_.remove(id);
  }
  misfits_ = held ? 0 : misfits_ + (missing >= 2);
}

// ---- Results ---------------------------------------------------------------------------------

Estimate EkfSlam::estimate(Time time) {
  Estimate e;
  e.time = time;
  e.T_map_robot = filter_.T_map_robot();
  e.covariance = filter_.covariance().topLeftCorner<3, 3>();
  const bool blind = motion_.way() - held_at_ > options_.blind;
  if (blind || contradicted_since_ || mistrusted(time)) degrade(e);
  if (misfits_ >= options_.misfits) e.health = Health::lost;
  doubt_if_vague(e);
  return e;
}

// The frame may still be found, and the poses before with it.
Estimate EkfSlam::as_known_now(Estimate e) const {
  if (fixes_seen_ > 0 && !oriented_) e.health = Health::lost;
  return e;
}

void EkfSlam::doubt_if_vague(Estimate& e) const {
  if (e.health == Health::ok && least_known(e.covariance).sigma > options_.sure) degrade(e);
}

LandmarkMap EkfSlam::finish() {
  filter_.settle();
  LandmarkMap map;
  std::vector<int> number(known_.size(), -1);
  for (std::size_t i = 0; i < known_.size(); ++i) {
    const Known& known = known_[i];
    if (known.sightings < options_.confirmed) continue;
    MappedLandmark m;
    m.p_map = known.gone ? known.p_map : filter_.landmark(static_cast<int>(i));
    m.covariance = known.gone ? known.covariance : covariance_of(static_cast<int>(i));
    m.diameter = std::max(0.0, known.diameter);
    m.sightings = known.sightings;
    m.gone = known.gone;
    number[i] = static_cast<int>(map.landmarks.size());
    map.landmarks.push_back(m);
  }
  for (const Sighting& s : sightings_) {
    const Known& known = known_[static_cast<std::size_t>(s.landmark)];
    const int id = number[static_cast<std::size_t>(s.landmark)];
    if (id < 0) continue;
    const Centre at = centre(s.seen, known.diameter, known.diameter_variance);
    map.observations.push_back({s.scan, id, at.q_robot, at.noise});
  }
  for (const Estimate& e : estimates_) map.localization.estimates.push_back(as_known_now(e));
  map.steps = steps_;
  map.fixes = fixes_;
  map.numbers = filter_.extra();
  map.localization.innovations = innovations_;
  const auto tell = [&](const char* name, const char* unit, int k) {
    map.localization.learnt.push_back(
        {name, unit, filter_.extra()(k), std::sqrt(filter_.covariance()(3 + k, 3 + k))});
  };
  tell("scale of the way", "1", WheelStep::kScale);
  tell("scale of turns", "1", WheelStep::kTurnScale);
  tell("turn per way", "rad/m", WheelStep::kTurnOffset);
  tell("cube of the steering", "1/rad^2", WheelStep::kCurve);
  tell("square of the steering", "1/rad", WheelStep::kSquare);
  tell("drives to the left of ahead", "rad", MotionInput::kCrab);
  tell("wheels behind the laser", "s", MotionInput::kLag);
  if (oriented_) {
    tell("antenna ahead", "m", kAntenna);
    tell("antenna to the left", "m", kAntenna + 1);
  }
  map.localization.report = report_;
  if (fixes_seen_ > 0 && frameless_ > 0) map.localization.report.add(kFrameless, {frameless_, 0});
  return map;
}

localize::Localizer ekf_slam(const EkfSlamOptions& options, const Pose2& start) {
  const auto method = std::make_shared<EkfSlam>(options, start);
  return {[method](const Event& event) { return method->add(event); },
          [method] { return method->finish().localization; }};
}

}  // namespace majak::slam
