// SPDX-License-Identifier: Apache-2.0
#include "majak/localize/kalman.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "majak/beacon/resection.hpp"
#include "majak/core/rigid_fit.hpp"

namespace majak::localize {
namespace {

constexpr double kBeginPosition = 30;  // m, before the first fix has been heard
constexpr double kFirstHeading = 0.5;  // rad, of a heading taken from the first fixes
constexpr double kConverged = 0.002;   // m that the last round of smoothing moves
constexpr std::size_t kMostStages = 40;
constexpr double kLearnt = 0.7;        // share of its first variance from which a number is learnt
constexpr std::size_t kPatience = 20;  // measurements that may wait for odometry

}  // namespace

Kalman::Kalman(const KalmanOptions& options, const Pose2& start, const beacon::BeaconMap& beacons)
    : options_(options), beacons_(beacons), pieces_(options.pieces), T_map_begin_(start) {
  pending_.at(kScale) = pending_.at(kTurnScale) = 1;
}

// ---- Events ----------------------------------------------------------------------------------

std::optional<Estimate> Kalman::add(const Event& event) {
  if (const auto* wheels = std::get_if<WheelMotion>(&event)) {
    drive(*wheels);
    return scans_ ? std::nullopt : at_once({wheels->time, kNone, true, {}, {}, false});
  }
  if (const auto* odometry = std::get_if<Odometry>(&event)) {
    auto newest = drive(odometry->time, odometry->T_odom_robot);
    return scans_ ? newest : at_once({odometry->time, kNone, true, {}, {}, false});
  }
  Measured m{time_of(event), kNone, true, {}, {}, false};
  if (const auto* scan = std::get_if<Scan>(&event)) {
    if (scan->laser != 0) return std::nullopt;
    scans_ = m.scan = true;
    m.match = std::exchange(match_, std::nullopt);
    if (scan->T_odom_robot && !wheels_) drive(scan->time, *scan->T_odom_robot);
    if (!beacons_.beacons.empty()) m.seen = beacon::find_reflectors(*scan, options_.reflectors);
  } else if (const auto* fix = std::get_if<GpsFix>(&event)) {
    m.fix = fixes_.size();
    m.wanted = false;
    fixes_.push_back(*fix);
    weights_.push_back(1);
  } else if (const auto* sighting = std::get_if<BeaconSighting>(&event)) {
    if (beacons_.beacons.empty()) return std::nullopt;
    m.seen = {*sighting};
  } else {
    return std::nullopt;
  }
  if (!odometry_ || m.time <= clock_) return at_once(std::move(m));
  waiting_.push_back(std::move(m));
  return waiting_.size() > kPatience ? take_waiting(waiting_.back().time) : std::nullopt;
}

// The odometry has fallen silent, or has come by.
std::optional<Estimate> Kalman::take_waiting(Time until) {
  std::optional<Estimate> newest;
  while (!waiting_.empty() && waiting_.front().time <= until) {
    Measured m = std::move(waiting_.front());
    waiting_.pop_front();
    newest = at_once(std::move(m));
  }
  return newest;
}

std::optional<Estimate> Kalman::at_once(Measured m) {
  move_to(m.time);
  if (!nodes_.empty() && m.time < nodes_.back().time) {
    report_.count("measurements older than those before them; taken as measured then");
    m.time = nodes_.back().time;
  }
  if (m.fix != kNone) verdicts_.push_back(pieces_.add(fixes_[m.fix], way_, turned_));
  Node node;
  node.time = m.time;
  node.motion = pending_;
  node.scan = m.scan;
  // A node between two scans would have to share the match; it is left to the wheels.
  if (m.match && !nodes_.empty() && nodes_.back().scan) fuse(*m.match, node);
  node.fix = m.fix;
  node.wanted = m.wanted;
  nodes_.push_back(std::move(node));
  const Eigen::Matrix<double, kExtra, 1> at = pending_.at;
  pending_ = {};
  pending_.at = at;
  recognise(std::move(m.seen));

  const std::size_t before = piece_;
  const bool found = !oriented_ && orient(options_.find_heading);
  if (!found)
    filter_node(nodes_.size() - 1, false, options_.gate, piece_,
                oriented_ ? &innovations_ : nullptr);
  if (found ||
      (oriented_ && piece_ != before && settled_ < nodes_.size() - nodes_.size() / kMostStages))
    settle();
  return estimate(nodes_.back(), nodes_.back().filtered);
}

// Which beacons these are: by where the robot is believed to be, or by how they stand.
void Kalman::recognise(std::vector<BeaconSighting> seen) {
  if (seen.empty()) return;
  std::optional<beacon::PosePrior> prior;
  if (oriented_) {
    Belief belief = nodes_.size() > 1 ? nodes_[nodes_.size() - 2].filtered : beginning();
    belief.predict(nodes_.back().motion);
    const Estimate e = estimate(nodes_.back(), belief);
    prior = beacon::PosePrior{e.T_map_robot, e.covariance};
  }
  const bool told =
      std::all_of(seen.begin(), seen.end(), [](const BeaconSighting& s) { return s.beacon >= 0; });
  if (!told) seen = beacon::associate(seen, beacons_, prior, options_.reflectors);
  for (const BeaconSighting& s : seen) {
    if (beacons_.find(s.beacon))
      nodes_.back().seen.push_back(s);
    else
      report_.count("sightings of beacons that the map does not have");
  }
}

// ---- Where it begins -------------------------------------------------------------------------

Kalman::Belief Kalman::beginning() const {
  const KalmanOptions& o = options_;
  Belief b;
  b.nominal.T_map_robot = T_map_begin_;
  b.nominal.extra(kScale) = b.nominal.extra(kTurnScale) = 1;
  auto variance = b.covariance.diagonal();
  if (!fixes_.empty() || !beacons_.beacons.empty()) {
    variance.head<2>().setConstant(kBeginPosition * kBeginPosition);
    variance(2) = oriented_ ? kFirstHeading * kFirstHeading : kPi * kPi;
  }
  variance(3 + kScale) = o.scale_sigma * o.scale_sigma;
  variance(3 + kTurnScale) = o.turn_scale_sigma * o.turn_scale_sigma;
  const double offset = wheels_ ? o.steering_sigma / o.wheelbase : o.turn_offset_sigma;
  variance(3 + kTurnOffset) = offset * offset;
  variance(3 + kCurve) = o.steering_curve_sigma * o.steering_curve_sigma;
  variance.segment<2>(3 + kAntenna).setConstant(o.antenna_sigma * o.antenna_sigma);
  const double slow = fixes_.empty() ? o.gps_sigma : sigma_of(fixes_.front());
  variance.segment<2>(3 + kSlow).setConstant(slow * slow / slow_weight(0));
  return b;
}

// The first moment's beacons tell the pose, or the fixes once they are so far apart.
bool Kalman::orient(double least_way) {
  const Node& newest = nodes_.back();
  if (newest.fix != kNone && verdicts_[newest.fix].trusted) return find_heading(least_way);
  if (newest.seen.empty()) return false;
  std::vector<BeaconSighting> together;
  for (std::size_t k = nodes_.size(); k-- > 0 && nodes_[k].time == newest.time;)
    together.insert(together.end(), nodes_[k].seen.begin(), nodes_[k].seen.end());
  const beacon::PoseFix fix = beacon::resect(together, beacons_);
  if (fix.problem != beacon::FixProblem::none) return false;
  State state = beginning().nominal;
  state.T_map_robot = {};
  for (std::size_t k = 1; k < nodes_.size(); ++k) state = nodes_[k].motion.apply(state);
  T_map_begin_ = fix.T_map_robot * state.T_map_robot.inverse();
  return oriented_ = true;
}

// Turns the path of the wheels until it lies on the fixes.
bool Kalman::find_heading(double least_way) {
  std::vector<Vec2> driven, fixed;
  State state = beginning().nominal;
  state.T_map_robot = {};
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
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
  T_map_begin_ = rigid_fit(driven, fixed);
  oriented_ = true;
  return true;
}

// ---- Results ---------------------------------------------------------------------------------

Localization Kalman::finish() {
  while (!waiting_.empty()) take_waiting(waiting_.back().time);
  verdicts_ = pieces_.verdicts();
  const bool oriented = oriented_;
  if (!oriented && !fixes_.empty()) find_heading(options_.find_heading / 8);
  // From where the filter saw the rest, if it knew the heading by then.
  for (; oriented && settled_ < nodes_.size(); ++settled_)
    nodes_[settled_].smoothed.nominal = nodes_[settled_].filtered.nominal;
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
  std::vector<LearntValue> values;
  const Belief prior = beginning();
  const auto tell = [&](const char* name, const char* unit, int k) {
    const double variance = belief.covariance(3 + k, 3 + k);
    if (variance < kLearnt * prior.covariance(3 + k, 3 + k))
      values.push_back({name, unit, belief.nominal.extra(k), std::sqrt(variance)});
  };
  if (wheels_ || odometry_) {
    tell("scale of the way", "1", kScale);
    tell(wheels_ ? "scale of the steering" : "scale of turns", "1", kTurnScale);
    tell("turn per way", "rad/m", kTurnOffset);
    if (wheels_) tell("cube of the steering", "1/rad^2", kCurve);
  }
  if (!fixes_.empty()) {
    tell("antenna ahead", "m", kAntenna);
    tell("antenna to the left", "m", kAntenna + 1);
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
  if ((!fixes_.empty() || !beacons_.beacons.empty()) && !oriented_) e.health = Health::lost;
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

Localizer kalman(const KalmanOptions& options, const Pose2& start,
                 const beacon::BeaconMap& beacons) {
  const auto method = std::make_shared<Kalman>(options, start, beacons);
  return {[method](const Event& event) { return method->add(event); },
          [method] { return method->finish(); }};
}

}  // namespace majak::localize
