// SPDX-License-Identifier: Apache-2.0
#include "majak/localize/kalman.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace majak::localize {
namespace {

constexpr double kBeginPosition = 30;  // m, before the first fix has been heard
constexpr double kFirstHeading = 0.5;  // rad, of a heading taken from the first fixes
constexpr double kStudent = 4;         // degrees of freedom of the fixes' fast error
constexpr double kConverged = 0.005;   // m that the last round of smoothing moves
constexpr std::size_t kMostStages = 40;
constexpr double kNoGate = 1e9;
constexpr int kRoundsPerStage = 30;
constexpr double kTurnApart = 0.4;  // rad between stretches that are tried
constexpr double kBendSigmas = 2.5, kMostTries = 20;
constexpr double kMostTurn = 0.5;      // rad, by which a round may turn the path
constexpr double kSettled = 0.3;       // m, before fixes are weighed by how well they fit
constexpr std::size_t kPatience = 20;  // measurements that may wait for odometry

// Right Jacobian of exp for a short twist, to first order: exp(u + d) = exp(u) exp(J d).
Mat3 short_jacobian(const Vec3& u) {
  Mat3 ad;
  ad << 0, -u.z(), u.y(), u.z(), 0, -u.x(), 0, 0, 0;
  return Mat3::Identity() - 0.5 * ad;
}

// The rotation and shift that bring the points `from` nearest to `to` (Umeyama 1991, in the plane).
Pose2 align(const std::vector<Vec2>& from, const std::vector<Vec2>& to) {
  Vec2 a = Vec2::Zero(), b = Vec2::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) a += from[i], b += to[i];
  a /= static_cast<double>(from.size()), b /= static_cast<double>(from.size());
  double cosine = 0, sine = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Vec2 p = from[i] - a, q = to[i] - b;
    cosine += p.dot(q), sine += p.x() * q.y() - p.y() * q.x();
  }
  const Pose2 turn{0, 0, std::atan2(sine, cosine)};
  const Vec2 shift = b - turn * a;
  return {shift.x(), shift.y(), turn.theta};
}

}  // namespace

Kalman::Kalman(const KalmanOptions& options) : options_(options), pieces_(options.pieces) {
  pending_.at(kScale) = pending_.at(kTurnScale) = 1;
}

// ---- Relative information: the wheels --------------------------------------------------------

// One step of the wheels. twist_by_wheels: its derivatives by scale, turn scale, turn offset and
// the steering's curve.
void Kalman::roll(const Vec3& twist, const WheelDerivative& twist_by_wheels, double seconds) {
  const KalmanOptions& o = options_;
  const double way = twist.head<2>().norm(), turn = std::abs(twist.z());
  Motion step;
  step.at = pending_.at;
  step.T_from_to = exp(twist);
  step.by_extra.leftCols<4>() = short_jacobian(twist) * twist_by_wheels;
  step.noise.diagonal() << o.way_noise * o.way_noise * way, o.side_noise * o.side_noise * way,
      o.turn_noise * o.turn_noise * way + o.spin_noise * o.spin_noise * turn;
  pending_.then(step);
  way_ += way;
  drift(seconds);
}

// What time alone does to the extra numbers.
void Kalman::drift(double seconds) {
  if (seconds <= 0) return;
  Motion idle;
  idle.at = pending_.at;
  const double keep = std::exp(-seconds / options_.gps_memory);
  const double slow = options_.gps_sigma;
  idle.keep.tail<2>().setConstant(keep);
  idle.extra_noise.tail<2>().setConstant(slow * slow * (1 - keep * keep));
  if (!wheels_ && !odometry_)
    idle.noise.diagonal().setConstant(options_.idle_noise * options_.idle_noise * seconds);
  pending_.then(idle);
}

// Speed and steering hold until the next record.
void Kalman::drive(const WheelMotion& next) {
  if (wheels_) {
    const double seconds = std::max(0.0, to_seconds(next.time - clock_));
    const double d = wheels_->speed * seconds, t = std::tan(wheels_->steering);
    const double turn = d * t / options_.wheelbase;
    const double turn_by_steering = d * (1 + t * t) / options_.wheelbase;
    WheelDerivative by_wheels = WheelDerivative::Zero();
    by_wheels(0, kScale) = d;
    by_wheels(2, kScale) = turn;
    by_wheels(2, kTurnScale) = turn_by_steering * wheels_->steering;
    by_wheels(2, kTurnOffset) = d;
    by_wheels(2, kCurve) = d * std::pow(wheels_->steering, 3) / options_.wheelbase;
    roll({d, 0, turn}, by_wheels, seconds);
  }
  clock_ = begun_ ? std::max(clock_, next.time) : next.time;
  begun_ = true;
  wheels_ = next;
}

// The odometry's own poses: what is measured between two of them waits for the second.
std::optional<Estimate> Kalman::drive(Time time, const Pose2& T_odom_robot) {
  std::optional<Estimate> newest;
  if (odometry_ && time > odometry_->time) {
    const Vec3 all = log(between(odometry_->T_odom_robot, T_odom_robot));
    const double whole = to_seconds(time - odometry_->time);
    const auto go = [&](Time until) {
      const double part = to_seconds(until - clock_) / whole;
      const Vec3 u = part * all;
      WheelDerivative by_wheels = WheelDerivative::Zero();
      by_wheels.block<2, 1>(0, kScale) = u.head<2>();
      by_wheels(2, kTurnScale) = u.z();
      by_wheels(2, kTurnOffset) = u.x();
      roll(u, by_wheels, part * whole);
      clock_ = until;
    };
    while (!waiting_.empty() && waiting_.front().time <= time) {
      const Waiting w = waiting_.front();
      waiting_.pop_front();
      if (w.time > clock_) go(w.time);
      newest = at_once(w.time, w.fix, w.wanted);
    }
    if (time > clock_) go(time);
  } else if (!odometry_) {
    clock_ = time;
    begun_ = true;
  }
  if (!odometry_ || time > odometry_->time) odometry_ = Odometry{time, T_odom_robot, {}, {}};
  return newest;
}

// ---- Events ----------------------------------------------------------------------------------

std::optional<Estimate> Kalman::add(const Event& event) {
  if (const auto* wheels = std::get_if<WheelMotion>(&event)) {
    drive(*wheels);
    return scans_ ? std::nullopt : at_once(wheels->time, kNone, true);
  }
  if (const auto* odometry = std::get_if<Odometry>(&event)) {
    auto newest = drive(odometry->time, odometry->T_odom_robot);
    return scans_ ? newest : at_once(odometry->time, kNone, true);
  }
  Waiting w{time_of(event), kNone, true};
  if (const auto* scan = std::get_if<Scan>(&event)) {
    if (scan->laser != 0) return std::nullopt;
    scans_ = true;
    if (scan->T_odom_robot && !wheels_) drive(scan->time, *scan->T_odom_robot);
  } else if (const auto* fix = std::get_if<GpsFix>(&event)) {
    w.fix = fixes_.size();
    w.wanted = false;
    fixes_.push_back(*fix);
    weights_.push_back(1);
  } else {
    return std::nullopt;
  }
  if (!odometry_ || w.time <= clock_) return at_once(w.time, w.fix, w.wanted);
  waiting_.push_back(w);
  return waiting_.size() > kPatience ? take_waiting(w.time) : std::nullopt;
}

// The odometry has fallen silent.
std::optional<Estimate> Kalman::take_waiting(Time until) {
  std::optional<Estimate> newest;
  while (!waiting_.empty() && waiting_.front().time <= until) {
    const Waiting w = waiting_.front();
    waiting_.pop_front();
    newest = at_once(w.time, w.fix, w.wanted);
  }
  return newest;
}

std::optional<Estimate> Kalman::at_once(Time time, std::size_t fix, bool wanted) {
  if (wheels_ && time > clock_) drive(WheelMotion{time, wheels_->speed, wheels_->steering});
  if (!wheels_ && !odometry_) {
    if (begun_) drift(to_seconds(time - clock_));
    clock_ = begun_ ? std::max(clock_, time) : time;
    begun_ = true;
  }
  if (!nodes_.empty() && time < nodes_.back().time) {
    report_.count("measurements older than those before them; taken as measured then");
    time = nodes_.back().time;
  }
  if (fix != kNone) verdicts_.push_back(pieces_.add(fixes_[fix], way_));
  Node node;
  node.time = time;
  node.motion = pending_;
  node.fix = fix;
  node.wanted = wanted;
  nodes_.push_back(node);
  const Eigen::Matrix<double, kExtra, 1> at = pending_.at;
  pending_ = {};
  pending_.at = at;
  const std::size_t before = piece_;
  if (!oriented_ && fix != kNone && verdicts_[fix].trusted &&
      find_heading(nodes_.size(), options_.find_heading))
    settle();
  else
    filter_node(nodes_.size() - 1, false, options_.gate, piece_,
                oriented_ ? &innovations_ : nullptr);
  if (oriented_ && piece_ != before && settled_ < nodes_.size() - nodes_.size() / kMostStages)
    settle();
  return estimate(nodes_.back(), nodes_.back().filtered);
}

// ---- Where it begins -------------------------------------------------------------------------

Kalman::Belief Kalman::beginning() const {
  const KalmanOptions& o = options_;
  Belief b;
  b.nominal.T_map_robot = T_map_begin_;
  b.nominal.extra(kScale) = b.nominal.extra(kTurnScale) = 1;
  auto variance = b.covariance.diagonal();
  if (!fixes_.empty()) {
    variance.head<2>().setConstant(kBeginPosition * kBeginPosition);
    variance(2) = oriented_ ? kFirstHeading * kFirstHeading : kPi * kPi;
  }
  variance(3 + kScale) = o.scale_sigma * o.scale_sigma;
  variance(3 + kTurnScale) = o.turn_scale_sigma * o.turn_scale_sigma;
  const double offset = wheels_ ? o.steering_sigma / o.wheelbase : o.turn_offset_sigma;
  variance(3 + kTurnOffset) = offset * offset;
  variance(3 + kCurve) = o.steering_curve_sigma * o.steering_curve_sigma;
  variance.segment<2>(3 + kAntenna).setConstant(o.antenna_sigma * o.antenna_sigma);
  variance.segment<2>(3 + kSlow).setConstant(o.gps_sigma * o.gps_sigma / slow_weight(0));
  return b;
}

// Turns the path of the wheels until it lies on the fixes.
bool Kalman::find_heading(std::size_t until, double least_way) {
  std::vector<Vec2> driven, fixed;
  State state = beginning().nominal;
  state.T_map_robot = {};
  for (std::size_t k = 0; k < until; ++k) {
    if (k > 0) state = nodes_[k].motion.apply(state);
    const std::size_t i = nodes_[k].fix;
    if (i == kNone || !verdicts_[i].trusted) continue;
    driven.push_back(state.T_map_robot.translation());
    fixed.push_back({fixes_[i].east, fixes_[i].north});
  }
  if (driven.empty()) return false;
  double widest = 0;
  for (const Vec2& p : driven) widest = std::max(widest, (p - driven.front()).norm());
  if (widest < least_way) return false;
  T_map_begin_ = align(driven, fixed);
  oriented_ = true;
  return true;
}

// ---- Absolute information: the satellites ----------------------------------------------------

// z = t + R a + b: the antenna's place, and the slow error of the satellites.
filter::AbsoluteInput<Kalman::kExtra, 2> Kalman::see(const GpsFix& fix, double weight,
                                                     const State& at) const {
  const double c = std::cos(at.T_map_robot.theta), s = std::sin(at.T_map_robot.theta);
  Eigen::Matrix2d turn;
  turn << c, -s, s, c;
  const Vec2 antenna = at.extra.segment<2>(kAntenna), slow = at.extra.segment<2>(kSlow);
  filter::AbsoluteInput<kExtra, 2> z;
  z.residual = Vec2(fix.east, fix.north) - (at.T_map_robot * antenna + slow);
  z.H.setZero();
  z.H.leftCols<2>() = turn;
  z.H.col(2) = turn * Vec2(-antenna.y(), antenna.x());
  z.H.middleCols<2>(3 + kAntenna) = turn;
  z.H.middleCols<2>(3 + kSlow).setIdentity();
  const double sigma = fix.sigma > 0 ? fix.sigma : options_.gps_sigma;
  const double fast = options_.gps_fast_share * sigma;
  z.noise = Eigen::Matrix2d::Identity() * (fast * fast / weight);
  return z;
}

Kalman::Motion Kalman::motion_to(const Node& node) const {
  Motion motion = node.motion;
  if (!node.new_piece) return motion;
  const double sigma = fixes_[node.fix].sigma > 0 ? fixes_[node.fix].sigma : options_.gps_sigma;
  motion.keep.tail<2>().setZero();
  motion.extra_noise.tail<2>().setConstant(sigma * sigma / slow_weight(verdicts_[node.fix].piece));
  return motion;
}

// ---- Filter and smoother ---------------------------------------------------------------------

// `linear`: the equations are made linear at the smoothed state of the round before.
void Kalman::filter_node(std::size_t k, bool linear, double gate, std::size_t& piece,
                         std::vector<Innovation>* innovations) {
  Node& node = nodes_[k];
  const bool trusted = node.fix != kNone && verdicts_[node.fix].trusted;
  const std::size_t own_piece = trusted ? verdicts_[node.fix].piece : piece;
  node.new_piece = piece != kNone && own_piece != piece;
  piece = own_piece;
  const State before = node.smoothed.nominal;
  if (k == 0) {
    node.predicted = beginning();
    if (linear) {
      node.predicted.mean = node.predicted.nominal.minus(before);
      node.predicted.nominal = before;
    }
  } else {
    node.predicted = nodes_[k - 1].filtered;
    node.predicted.predict(motion_to(node), linear ? &before : nullptr);
  }
  node.filtered = node.predicted;
  if (trusted) {
    const auto z = see(fixes_[node.fix], weights_[node.fix], node.filtered.nominal);
    const auto done = node.filtered.correct(z, gate);
    cost_ += done.nis + done.log_det;
    if (innovations) innovations->push_back({node.time, "gps", done.nis, 2, done.share == 1});
  }
  if (!linear) node.filtered.settle();
}

// One round of Gauss and Newton over all nodes: filter forth, smoother back, about the nominal
// path; then the path moves, by no more than the equations can be trusted. Returns how far it would
// have.
double Kalman::round() {
  std::size_t piece = kNone;
  cost_ = 0;
  for (std::size_t k = 0; k < nodes_.size(); ++k) filter_node(k, true, kNoGate, piece, nullptr);
  double moved = 0, turned = 0;
  for (std::size_t k = nodes_.size(); k-- > 0;) {
    Node& node = nodes_[k];
    node.smoothed = node.filtered;
    if (k + 1 < nodes_.size())
      node.smoothed = filter::smooth(node.filtered, nodes_[k + 1].predicted,
                                     motion_to(nodes_[k + 1]), nodes_[k + 1].smoothed);
    moved = std::max(moved, node.smoothed.mean.head<2>().norm());
    turned = std::max(turned, std::abs(node.smoothed.mean(2)));
  }
  const double share = std::min(1.0, kMostTurn / std::max(turned, 1e-12));
  for (Node& node : nodes_) {
    node.smoothed.mean *= share;
    node.smoothed.settle();
  }
  return moved;
}

// Where the path is not smoothed yet, the nominal one is that of the wheels, `bend` added to what
// straight ahead turns.
void Kalman::extend(std::size_t from, double bend) {
  for (std::size_t k = from; k < nodes_.size(); ++k) {
    State& nominal = nodes_[k].smoothed.nominal;
    nominal =
        k == 0 ? beginning().nominal : motion_to(nodes_[k]).apply(nodes_[k - 1].smoothed.nominal);
    if (k != from) continue;
    nominal.extra(kTurnOffset) += bend;
  }
}

// Rounds until the path stands still; minus twice the log likelihood of the fixes there.
double Kalman::converge() {
  for (int k = 0; k < kRoundsPerStage && round() > kSettled; ++k) continue;
  return cost_;
}

// Student's t: a fix far from where the others put it counts less, and so does a piece whose slow
// error is large (iteratively reweighted least squares).
void Kalman::weigh() {
  std::size_t piece = kNone;
  for (const Node& node : nodes_) {
    if (node.fix == kNone || !verdicts_[node.fix].trusted) continue;
    const auto z = see(fixes_[node.fix], 1, node.smoothed.nominal);
    const double squared = z.residual.squaredNorm() / z.noise(0, 0);
    weights_[node.fix] = (kStudent + 2) / (kStudent + squared);
    if (verdicts_[node.fix].piece == piece) continue;
    piece = verdicts_[node.fix].piece;
    const double sigma = fixes_[node.fix].sigma > 0 ? fixes_[node.fix].sigma : options_.gps_sigma;
    const double slow = node.smoothed.nominal.extra.segment<2>(kSlow).squaredNorm();
    slow_weights_.resize(std::max(slow_weights_.size(), piece + 1), 1);
    slow_weights_[piece] = (kStudent + 2) / (kStudent + slow / (sigma * sigma));
  }
}

double Kalman::slow_weight(std::size_t piece) const {
  return piece < slow_weights_.size() ? slow_weights_[piece] : 1;
}

// After an outage the path hangs on the first fix from a lever of its whole length. All that was is
// made linear anew before the next stretch is hung on. Where the wheels' own bend could have wound
// that stretch up, several bends are tried, and the one that the fixes like best is kept.
void Kalman::settle() {
  const std::size_t from = settled_;
  const double way = way_ - settled_way_;
  const double bend_sigma =
      std::sqrt(nodes_.back().predicted.covariance(3 + kTurnOffset, 3 + kTurnOffset));
  const double step = kTurnApart / std::max(way, 1e-3);
  const int tries = static_cast<int>(std::min(kBendSigmas * bend_sigma / step, kMostTries));
  std::vector<State> before, best;
  for (const Node& node : nodes_) before.push_back(node.smoothed.nominal);
  double best_cost = std::numeric_limits<double>::infinity();
  for (int k = -tries; k <= tries; ++k) {
    for (std::size_t i = 0; i < from; ++i) nodes_[i].smoothed.nominal = before[i];
    extend(from, k * step);
    const double cost = converge();
    if (!(cost < best_cost)) continue;
    best_cost = cost;
    best.clear();
    for (const Node& node : nodes_) best.push_back(node.smoothed.nominal);
  }
  if (tries > 0) {
    for (std::size_t i = 0; i < nodes_.size(); ++i) nodes_[i].smoothed.nominal = best[i];
    round();
  }
  settled_ = nodes_.size();
  settled_way_ = way_;
  weigh();
  nodes_.back().filtered = nodes_.back().smoothed;
}

Localization Kalman::finish() {
  while (!waiting_.empty()) take_waiting(waiting_.back().time);
  verdicts_ = pieces_.verdicts();
  if (!oriented_ && !fixes_.empty()) find_heading(nodes_.size(), options_.find_heading / 8);
  extend(settled_, 0);
  for (int k = 0; k < options_.rounds && round() > kConverged; ++k) weigh();
  Localization result;
  for (const Node& node : nodes_)
    if (node.wanted) result.estimates.push_back(estimate(node, node.smoothed));
  result.innovations = innovations_;
  result.report = report_;
  if (!nodes_.empty()) result.learnt = learnt(nodes_.back().smoothed);
  return result;
}

std::vector<LearntValue> Kalman::learnt(const Belief& belief) const {
  const auto value = [&](const char* name, const char* unit, int k) {
    return LearntValue{name, unit, belief.nominal.extra(k),
                       std::sqrt(belief.covariance(3 + k, 3 + k))};
  };
  std::vector<LearntValue> values;
  if (wheels_ || odometry_) {
    values.push_back(value("scale of the way", "1", kScale));
    values.push_back(value(wheels_ ? "scale of the steering" : "scale of turns", "1", kTurnScale));
    values.push_back(value("turn per way", "rad/m", kTurnOffset));
    if (wheels_) values.push_back(value("cube of the steering", "1/rad^2", kCurve));
  }
  if (!fixes_.empty()) {
    values.push_back(value("antenna ahead", "m", kAntenna));
    values.push_back(value("antenna to the left", "m", kAntenna + 1));
  }
  return values;
}

Estimate Kalman::estimate(const Node& node, const Belief& belief) const {
  Estimate e;
  e.time = node.time;
  e.T_map_robot = belief.nominal.T_map_robot;
  Mat3 turn = Mat3::Identity();  // from the robot's axes to the map's
  const double c = std::cos(e.T_map_robot.theta), s = std::sin(e.T_map_robot.theta);
  turn.topLeftCorner<2, 2>() << c, -s, s, c;
  e.covariance = turn * belief.covariance.topLeftCorner<3, 3>() * turn.transpose();
  if (!fixes_.empty() && !oriented_) e.health = Health::lost;
  return e;
}

void describe(OptionFields& f, KalmanOptions& o) {
  f.add("kalman.way_noise", o.way_noise, {"m/sqrt(m)", "wheels, along the way", 0, 10});
  f.add("kalman.side_noise", o.side_noise, {"m/sqrt(m)", "wheels, across the way", 0, 10});
  f.add("kalman.turn_noise", o.turn_noise, {"rad/sqrt(m)", "wheels, heading by way", 0, 10});
  f.add("kalman.spin_noise", o.spin_noise, {"rad/sqrt(rad)", "wheels, heading by turn", 0, 10});
  f.add("kalman.idle_noise", o.idle_noise, {"m/sqrt(s)", "motion that nothing tells of", 0, 100});
  f.add("kalman.scale_sigma", o.scale_sigma, {"1", "how wrong the way may be counted", 0, 1});
  f.add("kalman.turn_scale_sigma", o.turn_scale_sigma,
        {"1", "how wrong turns or steering may be counted", 0, 1});
  f.add("kalman.turn_offset_sigma", o.turn_offset_sigma,
        {"rad/m", "how much straight ahead may turn, of two wheels", 0, 1});
  f.add("kalman.steering_sigma", o.steering_sigma,
        {"rad", "how far straight ahead of a car's steering may be off", 0, 1});
  f.add("kalman.steering_curve_sigma", o.steering_curve_sigma,
        {"1/rad^2", "of the cube of the angle in what a car steers", 0, 10});
  f.add("kalman.wheelbase", o.wheelbase, {"m", "of a car", 0.01, 100});
  f.add("kalman.gps_sigma", o.gps_sigma, {"m", "of fixes that do not state theirs", 0.001, 1000});
  f.add("kalman.gps_fast_share", o.gps_fast_share,
        {"1", "share of that which changes from fix to fix", 0.001, 1});
  f.add("kalman.gps_memory", o.gps_memory, {"s", "of the rest", 0.1, 1e6});
  f.add("kalman.antenna_sigma", o.antenna_sigma, {"m", "how far off the robot's point", 0, 100});
  f.add("kalman.outage", o.pieces.outage, {"s", "without a fix, after which all is new", 0.1, 1e6});
  f.add("kalman.jump", o.pieces.jump, {"m", "between fixes against the wheels", 0.01, 1000});
  f.add("kalman.piece", o.pieces.least, {"1", "fixes between jumps that count", 1, 1000});
  f.add("kalman.gate", o.gate, {"1", "NIS beyond which less is believed", 1, 1e9});
  f.add("kalman.find_heading", o.find_heading,
        {"m", "driven before fixes tell the heading", 0.1, 1e4});
  f.add("kalman.rounds", o.rounds, {"1", "of smoothing at most", 1, 1000});
}

}  // namespace majak::localize
