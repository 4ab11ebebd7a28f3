// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/ekf_slam.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "majak/core/chi_square.hpp"
#include "majak/core/rigid_fit.hpp"
#include "majak/match/scan_points.hpp"

namespace majak::slam {
namespace {

using filter::LandmarkFilter;
using motion::WheelStep;

// Among the extra numbers: the axle's direction, the wheels' lag, the antenna, and how the
// satellites err now.
constexpr int kCrab = MotionInput::kCrab, kLag = MotionInput::kLag,
              kAntenna = MotionInput::kNumbers, kSlow = kAntenna + 2;
constexpr double kThrough = 0.7;  // m behind a landmark where a beam ends that went through it
constexpr double kForgotten = 1;  // s after which a guess that is not seen again is dropped
constexpr int kNew = -1, kDoubted = -2;  // choices that are no pairing
constexpr const char* kStuck =
    "scans while the steering was stuck: the same as never before, or though the landmarks turned";
constexpr const char* kSlipped = "scans in which the landmarks contradicted the wheels";
constexpr const char* kMoved = "things that did not stand still for long; not in the map";
constexpr const char* kRefused = "fixes that contradict all else; not used";
constexpr double kDrift = 0.1;  // of the way, until the heading is known
constexpr double kNever = 3;    // times as far as ever before
constexpr int kWitness = 10;    // sightings of a landmark that may contradict the wheels
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

// Of a position: the variance in the direction in which it is known least, and that.
std::pair<double, Vec2> longest(const Mat3& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(
      covariance.topLeftCorner<2, 2>().eval());
  return {std::max(0.0, axes.eigenvalues()(1)), axes.eigenvectors().col(1)};
}

void degrade(Estimate& e) {
  e.health = Health::degraded;
  e.weak_direction = longest(e.covariance).second;
}

// Into a map whose frame is known that well.
void move(Estimate& e, const Pose2& T_new_old, const Mat3& covariance) {
  e.T_map_robot = T_new_old * e.T_map_robot;
  Mat3 turn = Mat3::Identity(), by_motion = Mat3::Identity();
  turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(T_new_old.theta).toRotationMatrix();
  const Vec2 way = e.T_map_robot.translation() - T_new_old.translation();
  by_motion.topRightCorner<2, 1>() = Vec2(-way.y(), way.x());
  e.covariance =
      turn * e.covariance * turn.transpose() + by_motion * covariance * by_motion.transpose();
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
  estimates_.push_back(estimate(scan.time));
  return as_known_now(estimates_.back());
}

// ---- What the scan shows ---------------------------------------------------------------------

// In the robot's frame at the scan's stamp: meanwhile it drove on.
std::vector<EkfSlam::Seen> EkfSlam::look(const Scan& scan) const {
  std::vector<Seen> seen;
  for (const beacon::LandmarkSighting& s : beacon::find_trunks(scan, options_.trunks)) {
    const double late = 0.5 * (match::beam_time(scan, s.beam, options_.mirror_turn) +
                               match::beam_time(scan, s.beam + 1, options_.mirror_turn));
    const Pose2 T_robot_laser = exp(late * motion_.twist()) * scan.T_robot_laser;
    const Vec2 q = T_robot_laser * s.p_laser();
    const double across = s.range * s.bearing_sigma;
    const Eigen::Matrix2d turn =
        Eigen::Rotation2Dd(T_robot_laser.theta + s.bearing).toRotationMatrix();
    const double bark = options_.trunks.range_sigma;
    Eigen::Matrix2d noise =
        turn * Vec2(bark * bark, across * across).asDiagonal() * turn.transpose();
    noise.diagonal().array() += options_.point_sigma * options_.point_sigma;
    seen.push_back(
        {q, s.depth * turn.col(0), noise, s.diameter, s.diameter_sigma * s.diameter_sigma});
  }
  return seen;
}

// The bark is what was seen; how far behind it the centre is, the diameter says.
EkfSlam::Centre EkfSlam::centre(const Seen& seen, double diameter, double variance) {
  return {seen.q_robot + (diameter - seen.diameter) * seen.by_diameter,
          seen.noise + variance * seen.by_diameter * seen.by_diameter.transpose()};
}

// Whose diameter is known from many sightings, most of all from near ones: a single one from far
// off tells little of it, and errs always to the same side.
EkfSlam::Centre EkfSlam::centre(const Seen& seen, int id) const {
  Known known = known_[static_cast<std::size_t>(id)];
  known.measure(seen);
  return centre(seen, known.diameter, known.diameter_variance);
}

void EkfSlam::Known::measure(const Seen& seen) {
  const double share = diameter_variance / (diameter_variance + seen.diameter_variance);
  diameter += share * (seen.diameter - diameter);
  diameter_variance *= 1 - share;
}

void EkfSlam::remember(const Seen& seen, int id) {
  Known& known = known_[static_cast<std::size_t>(id)];
  known.measure(seen);
  ++known.sightings;
  known.missed = 0;
  known.last = clock_;
  sightings_.push_back({estimates_.size(), id, seen});
}

// q = R' (l - t), the landmark in the robot's frame.
Pairing EkfSlam::pair(const Seen& seen, int id, const Eigen::MatrixXd& covariance) const {
  const Pose2& at = filter_.T_map_robot();
  const Eigen::Matrix2d back = Eigen::Rotation2Dd(at.theta).toRotationMatrix().transpose();
  const Vec2 q = back * (filter_.landmark(id) - at.translation());
  Pairing p;
  p.landmark = id;
  p.column = filter_.column(id);
  const Centre seen_at = centre(seen, id);
  p.innovation = seen_at.q_robot - q;
  p.by_state << -back, Vec2(q.y(), -q.x()), back;
  p.spread = shared_spread(p, p, covariance) + seen_at.noise;
  p.nis = p.innovation.dot(p.spread.inverse() * p.innovation);
  return p;
}

std::vector<Pairing> EkfSlam::candidates(const Seen& seen,
                                         const Eigen::MatrixXd& covariance) const {
  constexpr double kReach = 15;  // m, farther off nothing is looked at
  const double gate = chi_square_quantile(options_.association.gate, 2);
  const double diameter_variance = options_.diameter_sigma * options_.diameter_sigma;
  const Vec2 p_map = filter_.T_map_robot() * seen.q_robot;
  std::vector<Pairing> found;
  for (const int id : filter_.near()) {
    if ((filter_.landmark(id) - p_map).squaredNorm() > kReach * kReach) continue;
    const double wider = seen.diameter - known_[static_cast<std::size_t>(id)].diameter;
    if (wider * wider > 9 * (seen.diameter_variance + diameter_variance)) continue;
    const Pairing p = pair(seen, id, covariance);
    if (p.nis < gate) found.push_back(p);
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Pairing& a, const Pairing& b) { return a.nis < b.nis; });
  return found;
}

const Pairing* EkfSlam::Matching::pairing(std::size_t sighting) const {
  const int c = choice[sighting];
  return c < 0 ? nullptr : &allowed[sighting][static_cast<std::size_t>(c)];
}

EkfSlam::Matching EkfSlam::match(const std::vector<Seen>& seen,
                                 const Eigen::MatrixXd& covariance) const {
  Matching matching;
  for (const Seen& s : seen) matching.allowed.push_back(candidates(s, covariance));
  matching.choice = associate_jointly(matching.allowed, covariance, options_.association);
  for (std::size_t s = 0; s < seen.size(); ++s)
    if (const Pairing* p = matching.pairing(s)) matching.followed += followed(p->landmark);
  return matching;
}

bool EkfSlam::followed(int id) const {
  const Known& known = known_[static_cast<std::size_t>(id)];
  return !estimates_.empty() && known.last == estimates_.back().time && known.sightings > kWitness;
}

// ---- Wheels that err more than they ever say -------------------------------------------------

// A sensor that is stuck tells nothing until it moves again.
bool EkfSlam::mistrusted(Time time) {
  const bool same = motion_.steering_held() > options_.stuck;
  stuck_ = same && (stuck_ || motion_.steering_held() > kNever * motion_.steering_held_before());
  return stuck_ || time < mistrusted_until_;
}

// Of a step. The way, too: it bends within the step.
Mat3 EkfSlam::told_nothing(double seconds) const {
  return options_.mistrusted_noise * options_.mistrusted_noise * seconds * Mat3::Identity();
}

// Most landmarks of the scan before are seen no more, and would be if the robot had moved
// otherwise: they are believed, all together, and the wheels are not.
void EkfSlam::match_without_wheels(const std::vector<Seen>& seen, Matching& matching) {
  const auto& near = filter_.near();
  const auto before =
      static_cast<int>(std::count_if(near.begin(), near.end(), [&](int i) { return followed(i); }));
  if (before < 2 || 2 * matching.followed >= before || mistrusted(clock_)) return;
  filter::RelativeInput<LandmarkFilter::kExtra> more;
  more.at = filter_.extra();
  more.noise = told_nothing(to_seconds(clock_ - estimates_.back().time));
  Eigen::MatrixXd covariance = filter_.covariance();
  covariance.topLeftCorner<3, 3>() += more.noise;
  Matching without = match(seen, covariance);
  if (without.followed < matching.followed + 2 || 2 * without.followed < before) return;
  matching = std::move(without);
  filter_.predict(more);
  steps_.back().noise += more.noise;
  mistrusted_until_ = clock_ + from_seconds(options_.mistrust);
  stuck_ = motion_.steering_held() > options_.stuck;
}

// Landmarks that were not seen for long come back by several at once, or again and again: a single
// bush that happens to stand where a trunk was foretold must not turn the map.
void EkfSlam::doubt(Time time, Matching& matching) {
  std::vector<std::size_t> returning;
  for (std::size_t s = 0; s < matching.choice.size(); ++s) {
    const Pairing* pairing = matching.pairing(s);
    if (!pairing) continue;
    Known& known = known_[static_cast<std::size_t>(pairing->landmark)];
    if (to_seconds(time - known.last) < options_.recent) continue;
    known.returns = to_seconds(time - known.returned) < 1 ? known.returns + 1 : 1;
    known.returned = time;
    if (known.returns < options_.witnesses) returning.push_back(s);
  }
  if (static_cast<int>(returning.size()) >= options_.witnesses) return;
  for (const std::size_t s : returning) matching.choice[s] = kDoubted;
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

// ---- Satellites ------------------------------------------------------------------------------

// z = t + R a + b: the antenna's place on the robot, and what the satellites err by now.
void EkfSlam::see(const GpsFix& fix) {
  predict(fix.time);
  ++fixes_seen_;
  const localize::FixVerdict verdict = pieces_.add(fix, motion_.way(), motion_.turned());
  if (!verdict.trusted) return report_.count("fixes that jump, or come alone; not used");
  if (!oriented_) return find_heading(fix, verdict.piece);
  if (verdict.piece != piece_) err_anew(verdict.piece);
  const Pose2& at = filter_.T_map_robot();
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(at.theta).toRotationMatrix();
  const Vec2 antenna = filter_.extra().segment<2>(kAntenna);
  const double fast = options_.gps_fast_sigma * options_.gps_fast_sigma;
  Eigen::MatrixXd by_state = Eigen::MatrixXd::Zero(2, filter_.covariance().cols());
  by_state.leftCols<2>().setIdentity();
  by_state.col(2) = turn * Vec2(-antenna.y(), antenna.x());
  by_state.middleCols<2>(3 + kAntenna) = turn;
  by_state.middleCols<2>(3 + kSlow).setIdentity();
  const Vec2 slow = filter_.extra().segment<2>(kSlow);
  const Vec2 residual = Vec2(fix.east, fix.north) - (at * antenna + slow);
  // Where both heading and antenna are hardly known, their product is no small number: the second
  // order of the turned antenna counts as noise.
  const Eigen::MatrixXd& known = filter_.covariance();
  const double bent = known(2, 2) * (known.block<2, 2>(3 + kAntenna, 3 + kAntenna).trace() +
                                     0.5 * known(2, 2) * antenna.squaredNorm());
  const Eigen::Matrix2d noise = (fast + bent) * Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d s = by_state * filter_.covariance() * by_state.transpose() + noise;
  const double nis = residual.dot(s.inverse() * residual);
  // Beyond the gate it counts as measured that much worse: it may be right, and the filter too
  // sure.
  const double share = std::min(1.0, options_.gps_gate / nis);
  innovations_.push_back({fix.time, "gps", nis, 2, share == 1});
  if (refused(nis, fix.time)) return report_.count(kRefused);
  if (share < 1) report_.count("fixes beyond the gate; believed less");
  keep(fix, verdict.piece);
  filter_.correct(residual, by_state, noise + s * (1 / share - 1));
}

void EkfSlam::err_anew(std::size_t piece) {
  piece_ = piece;
  filter::RelativeInput<LandmarkFilter::kExtra> anew;
  anew.at = filter_.extra();
  anew.keep.tail<2>().setZero();
  anew.extra_noise.tail<2>().setConstant(options_.gps_sigma * options_.gps_sigma);
  filter_.predict(anew);
}

// A receiver that is far off errs for some time, then the filter does.
bool EkfSlam::refused(double nis, Time time) {
  const bool far = nis > options_.gps_refused;
  if (!far) contradicted_since_.reset();
  if (far && !contradicted_since_) contradicted_since_ = time;
  return far && to_seconds(time - *contradicted_since_) < options_.gps_patience;
}

// For the graph, that may believe it more.
void EkfSlam::keep(const GpsFix& fix, std::size_t piece) {
  if (estimates_.empty()) return;
  const Pose2 T_scan_robot = since_scan_.apply({{}, filter_.extra()}).T_map_robot;
  fixes_.push_back({estimates_.size() - 1, T_scan_robot, {fix.east, fix.north}, piece});
}

// Until the way tells the heading, the map is as the robot began it.
void EkfSlam::find_heading(const GpsFix& fix, std::size_t piece) {
  keep(fix, piece);
  const Vec2 antenna = filter_.extra().segment<2>(kAntenna);
  before_.push_back({filter_.T_map_robot() * antenna, {fix.east, fix.north}, piece});
  std::vector<Vec2> driven, fixed;
  double widest = 0;
  for (const EarlyFix& f : before_) {
    driven.push_back(f.driven), fixed.push_back(f.fixed);
    widest = std::max(widest, (f.driven - driven.front()).norm());
  }
  if (widest < options_.find_heading) return;
  const double place = std::hypot(options_.gps_sigma, options_.antenna_sigma);
  // The antenna swings by what the way bends, half a radian. More would be safe in a linear world:
  // here a wide heading that is then corrected is taken for knowledge of it.
  const double turn = 0.5 * place / widest;
  const Pose2 T_new_old = rigid_fit(driven, fixed);
  double worst = 0;
  for (const EarlyFix& f : before_)
    worst = std::max(worst, (T_new_old * f.driven - f.fixed).norm());
  if (worst > 3 * place + kDrift * widest) return drop_early_fixes();
  const Mat3 covariance = Vec3(place, place, turn).cwiseAbs2().asDiagonal();
  filter_.move_map(T_new_old, covariance);
  for (Estimate& e : estimates_) {
    move(e, T_new_old, covariance);
    doubt_if_vague(e);
  }
  for (Known& known : known_) {  // the filter no longer has those that are gone
    Estimate as_pose{.T_map_robot = {known.p_map.x(), known.p_map.y(), 0}};
    as_pose.covariance.topLeftCorner<2, 2>() = known.covariance;
    move(as_pose, T_new_old, covariance);
    known.p_map = as_pose.T_map_robot.translation();
    known.covariance = as_pose.covariance.topLeftCorner<2, 2>();
  }
  looked_from_ = filter_.T_map_robot().translation();
  filter_.look_around(looked_from_, options_.near);
  oriented_ = true;
}

// The way and the fixes have not one shape: those of the longest piece stay.
void EkfSlam::drop_early_fixes() {
  const auto of_piece = [&](std::size_t piece) {
    return std::count_if(before_.begin(), before_.end(),
                         [&](const EarlyFix& f) { return f.piece == piece; });
  };
  std::size_t most = before_.front().piece;
  for (const EarlyFix& f : before_)
    if (of_piece(f.piece) > of_piece(most)) most = f.piece;
  const auto dropped = std::erase_if(before_, [&](const EarlyFix& f) { return f.piece != most; });
  std::erase_if(fixes_, [&](const FixObservation& f) { return f.piece != most; });
  if (dropped == 0) before_.clear(), fixes_.clear();  // nor has it by itself
  for (std::size_t i = 0; i < dropped; ++i) report_.count(kRefused);
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
  const double sigma = std::sqrt(longest(e.covariance).first);
  if (e.health == Health::ok && sigma > options_.sure) degrade(e);
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
    m.diameter = known.diameter;
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
  tell("drives to the left of ahead", "rad", kCrab);
  tell("wheels behind the laser", "s", kLag);
  if (oriented_) {
    tell("antenna ahead", "m", kAntenna);
    tell("antenna to the left", "m", kAntenna + 1);
  }
  map.localization.report = report_;
  return map;
}

localize::Localizer ekf_slam(const EkfSlamOptions& options, const Pose2& start) {
  const auto method = std::make_shared<EkfSlam>(options, start);
  return {[method](const Event& event) { return method->add(event); },
          [method] { return method->finish().localization; }};
}

void describe(OptionFields& f, EkfSlamOptions& o) {
  describe(f, o.trunks);
  describe(f, o.association);
  f.add("ekf_slam.way_noise", o.wheels.way_noise, {"m/sqrt(m)", "wheels, along the way", 0, 10});
  f.add("ekf_slam.side_noise", o.wheels.side_noise, {"m/sqrt(m)", "wheels, across the way", 0, 10});
  f.add("ekf_slam.turn_noise", o.wheels.turn_noise,
        {"rad/sqrt(m)", "wheels, heading by way", 0, 10});
  f.add("ekf_slam.spin_noise", o.wheels.spin_noise,
        {"rad/sqrt(rad)", "wheels, heading by turn", 0, 10});
  f.add("ekf_slam.wheelbase", o.wheelbase, {"m", "of a car", 0.01, 100});
  f.add("ekf_slam.idle_noise", o.idle_noise,
        {"m/sqrt(s)", "until the wheels tell something; rad, too", 0, 100});
  f.add("ekf_slam.scale_sigma", o.scale_sigma, {"1", "how wrong the way may be counted", 0, 1});
  f.add("ekf_slam.turn_scale_sigma", o.turn_scale_sigma,
        {"1", "how wrong turns or steering may be counted", 0, 1});
  f.add("ekf_slam.turn_offset_sigma", o.turn_offset_sigma,
        {"rad/m", "how much straight ahead may turn", 0, 1});
  f.add("ekf_slam.steering_curve_sigma", o.steering_curve_sigma,
        {"1/rad^2", "of the cube of the angle in what a car steers", 0, 10});
  f.add("ekf_slam.steering_square_sigma", o.steering_square_sigma,
        {"1/rad", "of its square", 0, 10});
  f.add("ekf_slam.crab_sigma", o.crab_sigma,
        {"rad", "between the laser's and the axle's direction", 0, 1});
  f.add("ekf_slam.crab_wander", o.crab_wander,
        {"rad/sqrt(m)", "how that changes with the ground", 0, 1});
  f.add("ekf_slam.lag_sigma", o.lag_sigma, {"s", "of the wheels behind the laser", 0, 1});
  f.add("ekf_slam.mirror_turn", o.mirror_turn, {"s", "of the laser's mirror, 0: none", 0, 1});
  f.add("ekf_slam.point_sigma", o.point_sigma,
        {"m", "by which a landmark is not the same from scan to scan", 0, 10});
  f.add("ekf_slam.alike_sigma", o.alike_sigma,
        {"m", "by which all its sightings err alike that are made on ...", 0, 10});
  f.add("ekf_slam.alike_way", o.alike_way, {"m", "... so much way", 0, 1000});
  f.add("ekf_slam.diameter_sigma", o.diameter_sigma,
        {"m", "by which its diameter is not", 0.001, 10});
  f.add("ekf_slam.apart", o.apart,
        {"1", "probability with which a new landmark is none of the others", 0.5, 0.999999});
  f.add("ekf_slam.least_apart", o.least_apart, {"m", "nor nearer than this to any", 0, 100});
  f.add("ekf_slam.recent", o.recent,
        {"s", "after which a landmark seen again is doubted at first", 0, 1e6});
  f.add("ekf_slam.witnesses", o.witnesses,
        {"1", "of these in a scan, or scans in a row, that are enough", 1, 1000});
  f.add("ekf_slam.confirmed", o.confirmed,
        {"1", "sightings before it is more than a guess", 1, 1000});
  f.add("ekf_slam.stands", o.stands, {"s", "for which it stands in one place until then", 0, 1e6});
  f.add("ekf_slam.guess_gate", o.guess_gate, {"m", "between these", 0.01, 10});
  f.add("ekf_slam.gone", o.gone, {"1", "scans that look through it before it is given up", 1, 1e6});
  f.add("ekf_slam.near", o.near, {"m", "what is kept up to date", 10, 1e6});
  f.add("ekf_slam.look_around", o.look_around, {"m", "driven between two looks around", 0, 1e6});
  f.add("ekf_slam.blind", o.blind,
        {"m", "driven without a landmark before the pose is called degraded", 0, 1e6});
  f.add("ekf_slam.sure", o.sure, {"m", "sigma of a position that is not", 0, 1e6});
  f.add("ekf_slam.misfits", o.misfits,
        {"1", "scans without those landmarks that there should be, before it is lost", 1, 1e6});
  f.add("ekf_slam.mistrusted_noise", o.mistrusted_noise,
        {"m/sqrt(s)", "of wheels that the landmarks contradict; rad, too", 0, 100});
  f.add("ekf_slam.mistrust", o.mistrust, {"s", "for which they are taken to err", 0, 1e6});
  f.add("ekf_slam.stuck", o.stuck, {"m", "with the same steering before it may be stuck", 0, 1e6});
  f.add("ekf_slam.use_gps", o.use_gps, {"", "satellite fixes correct the path, too"});
  f.add("ekf_slam.gps_sigma", o.gps_sigma, {"m", "of what errs alike in a piece", 0.001, 1000});
  f.add("ekf_slam.gps_fast_sigma", o.gps_fast_sigma, {"m", "from fix to fix", 0.001, 1000});
  f.add("ekf_slam.gps_memory", o.gps_memory, {"s", "of what errs alike", 0.1, 1e6});
  f.add("ekf_slam.antenna_sigma", o.antenna_sigma, {"m", "how far off the robot's point", 0, 100});
  f.add("ekf_slam.gps_gate", o.gps_gate, {"1", "NIS beyond which a fix is believed less", 1, 1e9});
  f.add("ekf_slam.gps_refused", o.gps_refused,
        {"1", "NIS beyond which it is not believed at all ...", 1, 1e9});
  f.add("ekf_slam.gps_patience", o.gps_patience, {"s", "... unless all are for so long", 0, 1e9});
  f.add("ekf_slam.find_heading", o.find_heading,
        {"m", "driven before fixes tell the heading", 0.1, 1e4});
}

}  // namespace majak::slam
