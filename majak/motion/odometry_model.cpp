// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/odometry_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace majak::motion {
namespace {

constexpr std::size_t kNoRecord = static_cast<std::size_t>(-1);
constexpr std::size_t kHistory = 2000;  // scans looked back at when learning
constexpr std::size_t kSampled = 400;   // scans that a search over lags looks at
constexpr std::size_t kLeastSteps = 100;
constexpr Duration kShift = kSecond / 10;  // half the width of the difference that gives a rate
constexpr Duration kLongestHold = kSecond;
constexpr int kRounds = 2;   // Newton steps, of which the first does nearly all
constexpr double kSure = 2;  // sigmas from 0 from which a lag is applied, as it is told to be
// A value is used when its sigma is below this.
constexpr double kUsableLag = 0.03, kUsableScale = 0.02, kUsablePlace = 0.02, kUsableTurn = 0.01;
// A scan is no instant: half the time of a sweep.
constexpr double kLagFloor = 0.007;  // s
// What the laser's own steps are wrong by, seen over simulated drives.
constexpr double kScaleFloor = 0.0015, kTurnScaleFloor = 0.002;

}  // namespace

void OdometryModel::Stream::push(Time time, const Pose2& pose, double speed, bool reversed) {
  Sample s{time, pose, pose, speed};
  if (!samples.empty()) {
    Pose2 step = between(samples.back().raw, pose);
    if (reversed && speed < 0 && step.x > 0) step.x = -step.x, step.y = -step.y;
    if (leaps(step, std::abs(to_seconds(time - samples.back().time)))) {
      step = {};
      jumps.push_back(std::max(latest.back(), time));
    }
    s.mended = samples.back().mended * step;
  }
  latest.push_back(latest.empty() ? time : std::max(latest.back(), time));
  samples.push_back(s);
}

std::optional<Pose2> OdometryModel::Stream::at(Time time, std::size_t& hint) const {
  if (samples.empty() || time < latest.front() || time > latest.back()) return std::nullopt;
  std::size_t after = std::min(hint, latest.size() - 1);
  for (int k = 0; k < 8 && latest[after] < time; ++k) ++after;
  if (latest[after] < time || (after > 0 && latest[after - 1] >= time))
    after = static_cast<std::size_t>(std::lower_bound(latest.begin(), latest.end(), time) -
                                     latest.begin());
  hint = after;
  if (latest[after] == time || after == 0) return samples[after].mended;
  const double part = static_cast<double>(time - latest[after - 1]) /
                      static_cast<double>(latest[after] - latest[after - 1]);
  const Pose2 &a = samples[after - 1].mended,
              &b = samples[after].mended;  // a few centimetres apart: straight
  return Pose2{a.x + part * (b.x - a.x), a.y + part * (b.y - a.y),
               wrap_angle(a.theta + part * angle_diff(b.theta, a.theta))};
}

bool OdometryModel::Stream::jumped(Time from, Time to) const {
  const auto next = std::upper_bound(jumps.begin(), jumps.end(), from);
  return next != jumps.end() && *next <= to;
}

double OdometryModel::Stream::speed(Time time) const {
  const auto after = std::upper_bound(latest.begin(), latest.end(), time) - latest.begin();
  return after > 0 ? samples[static_cast<std::size_t>(after) - 1].speed : 0;
}

void OdometryModel::add(const Odometry& odometry) {
  if (wheels_) return;
  stream_.push(odometry.time, odometry.T_odom_robot, odometry.speed.value_or(0), reversed_);
  count_jumps();
}

// A record holds until the next one, but not through a gap.
void OdometryModel::add(const WheelMotion& wheels) {
  const bool sound = std::isfinite(wheels.speed) && std::abs(wheels.steering) < kPi / 2;
  if (!sound || (!wheels_ && !stream_.samples.empty())) return;
  Pose2 pose;
  if (wheels_) {
    const Duration held = std::max<Duration>(wheels.time - wheels_->time, 0);
    const double way = wheels_->speed * to_seconds(std::min(held, kLongestHold));
    pose = stream_.samples.back().raw *
           exp({way, 0, way * std::tan(wheels_->steering) / options_.wheelbase});
    if (held > kLongestHold) stream_.jumps.push_back(std::max(stream_.latest.back(), wheels.time));
  }
  stream_.push(wheels.time, pose, wheels_ ? wheels_->speed : 0, false);
  wheels_ = wheels;
  count_jumps();
}

void OdometryModel::add(const Scan& scan) {
  scan_times_.push_back(scan.time);
  observed_.push_back({});
  record_of_.push_back(scan.T_odom_robot ? records_.samples.size() : kNoRecord);
  if (scan.T_odom_robot)
    records_.push(scan.time, *scan.T_odom_robot, stream_.speed(scan.time), reversed_);
  else if (scan_times_.size() == 1)
    choice_.records = false;
  count_jumps();
}

void OdometryModel::count_jumps() {
  findings_.jumps =
      static_cast<std::int64_t>(std::max(records_.jumps.size(), stream_.jumps.size()));
}

bool OdometryModel::ready(std::size_t scan) const {
  const Time wanted = scan_times_[scan] + choice_.lag;
  const Stream& s = choice_.records ? records_ : stream_;
  if (choice_.records && choice_.lag == 0) return true;
  return s.latest.empty() || s.latest.back() >= wanted;
}

std::optional<Pose2> OdometryModel::pose(const Choice& choice, std::size_t scan,
                                         std::size_t& hint) const {
  if (choice.records && choice.lag == 0)
    return record_of_[scan] != kNoRecord ? std::optional(records_.samples[record_of_[scan]].mended)
                                         : std::nullopt;
  return (choice.records ? records_ : stream_).at(scan_times_[scan] + choice.lag, hint);
}

std::optional<Pose2> OdometryModel::pose(const Choice& choice, std::size_t scan) const {
  std::size_t hint = choice.records ? scan : stream_.samples.size();  // the newest, as a rule
  return pose(choice, scan, hint);
}

std::optional<Pose2> OdometryModel::pose(std::size_t scan) const { return pose(choice_, scan); }

std::optional<Pose2> OdometryModel::wheel_motion(const Choice& choice, std::size_t scan) const {
  if (scan == 0) return std::nullopt;
  const auto before = pose(choice, scan - 1), now = pose(choice, scan);
  if (!before || !now) return std::nullopt;
  const Stream& stream = choice.records ? records_ : stream_;
  if (stream.jumped(scan_times_[scan - 1] + choice.lag, scan_times_[scan] + choice.lag))
    return std::nullopt;
  return between(*before, *now);
}

// The nominal robot's step from that of the wheels.
Pose2 OdometryModel::foretold(const Pose2& wheels) const {
  const Pose2 mended{scale_ * wheels.x, scale_ * wheels.y, wrap_angle(turn_scale_ * wheels.theta)};
  return offset_.inverse() * mended * offset_;
}

std::optional<PredictedMotion> OdometryModel::predict(std::size_t scan) const {
  const auto wheels = wheel_motion(choice_, scan);
  if (!wheels) return std::nullopt;
  PredictedMotion motion;
  motion.T_previous_robot = foretold(*wheels);
  const double step = scale_ * std::hypot(wheels->x, wheels->y),
               turn = turn_scale_ * std::abs(wheels->theta);
  if (findings_.translation_noise <= 0) {  // nothing learnt yet
    motion.sigma_translation = options_.floor_translation + options_.share * step;
    motion.sigma_rotation = options_.floor_rotation + options_.share * turn;
    return motion;
  }
  // Errors of the wheels add up like a random walk.
  motion.sigma_translation =
      options_.learnt_floor_translation + 1.5 * findings_.translation_noise * std::sqrt(step);
  motion.sigma_rotation =
      options_.learnt_floor_rotation + 1.5 * findings_.rotation_noise * std::sqrt(turn);
  return motion;
}

void OdometryModel::observe(std::size_t scan, const Pose2& T_previous_robot, bool trusted) {
  observed_[scan] = {T_previous_robot, trusted};
  if (scan < next_learning_) return;
  next_learning_ *= 2;
  learn(scan);
}

void OdometryModel::learn(std::size_t newest) {
  const std::size_t first = newest > kHistory ? newest - kHistory : 1;
  learn_direction(first);
  learn_faults(first);
}

// A logger that integrates |v| writes a step ahead where it states a negative speed.
void OdometryModel::learn_direction(std::size_t first) {
  if (reversed_ || stream_.samples.empty()) return;
  double along = 0;
  std::int64_t records = 0;
  for (std::size_t i = first; i < observed_.size(); ++i) {
    if (!observed_[i].trusted) continue;
    const auto wheels = wheel_motion({false, 0}, i);
    const auto& latest = stream_.latest;
    const auto k = static_cast<std::size_t>(
        std::lower_bound(latest.begin(), latest.end(), scan_times_[i]) - latest.begin());
    if (!wheels || k >= latest.size() || stream_.samples[k].speed >= 0 || wheels->x <= 0.005)
      continue;
    along += wheels->x * observed_[i].motion.x;
    ++records;
  }
  if (records < 5 || along >= 0) return;
  reversed_ = true;
  const auto mend = [](Stream& stream) {
    Stream mended;
    for (const Sample& s : stream.samples) mended.push(s.time, s.raw, s.speed, true);
    stream = std::move(mended);
  };
  for (std::size_t i = 1; i < stream_.samples.size(); ++i)
    findings_.reversed_records += stream_.samples[i].speed < 0 &&
                                  between(stream_.samples[i - 1].raw, stream_.samples[i].raw).x > 0;
  mend(stream_);
  mend(records_);
}

// Mean disagreement in heading and way, each scan's capped.
double OdometryModel::disagreement(const Choice& choice, std::size_t first,
                                   std::size_t stride) const {
  double sum = 0;
  std::size_t n = 0, hint = 0;
  for (std::size_t i = first; i < observed_.size(); i += stride) {
    if (!observed_[i].trusted) continue;
    const auto before = pose(choice, i - 1, hint), now = pose(choice, i, hint);
    if (!before || !now) continue;
    const Pose2& seen = observed_[i].motion;
    const double turn = turn_scale_ * angle_diff(now->theta, before->theta);
    const double way = scale_ * std::hypot(now->x - before->x, now->y - before->y);
    sum += std::min(std::abs(angle_diff(turn, seen.theta)), kGrossTurn);
    sum += std::min(std::abs(way - std::hypot(seen.x, seen.y)), kGrossStep);
    ++n;
  }
  return n < kLeastSteps ? 1e9 : sum / static_cast<double>(n);
}

OdometryModel::Choice OdometryModel::search_lag(std::size_t first) const {
  const std::size_t stride = 1 + (observed_.size() - first) / kSampled;
  double best = 0.97 * disagreement(choice_, first, stride);  // a change must be worth it
  Choice chosen = choice_;
  const int steps = static_cast<int>(std::lround(options_.max_lag / options_.lag_step));
  for (const bool records : {true, false}) {
    if ((records ? records_ : stream_).samples.empty()) continue;
    for (int k = -steps; k <= steps; ++k) {
      const Choice choice{records, from_seconds(k * options_.lag_step)};
      const double value = disagreement(choice, first, stride);
      if (value < best) best = value, chosen = choice;
    }
  }
  return chosen;
}

// Where scans are stamped in bursts their own records fit, and anything interpolated between them
// does not: such stamps tell no lag.
bool OdometryModel::stamps_tell(const Choice& choice, std::size_t first) const {
  if (!choice.records || choice.lag != 0) return true;
  const std::size_t stride = 1 + (observed_.size() - first) / kSampled;
  const double exact = disagreement(choice, first, stride);
  return std::max(disagreement({true, -kSecond / 1000}, first, stride),
                  disagreement({true, kSecond / 1000}, first, stride)) < 1.1 * exact;
}

std::vector<ComparedStep> OdometryModel::compare(const Choice& choice, bool timed,
                                                 std::size_t first) const {
  const std::array<Choice, 3> shifted{
      choice, {choice.records, choice.lag - kShift}, {choice.records, choice.lag + kShift}};
  std::array<std::vector<std::optional<Pose2>>, 3> paths;
  for (std::size_t k = 0; k < 3; ++k) {
    std::size_t hint = 0;
    for (std::size_t i = first - 1; i < observed_.size(); ++i)
      paths[k].push_back(pose(shifted[k], i, hint));
  }
  std::vector<ComparedStep> steps;
  for (std::size_t i = first + 1; i + 1 < observed_.size(); ++i) {
    if (!observed_[i - 1].trusted || !observed_[i].trusted || !observed_[i + 1].trusted) continue;
    std::array<Pose2, 3> wheels;
    bool all = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto &before = paths[k][i - first], &now = paths[k][i - first + 1];
      all = all && before && now;
      if (all) wheels[k] = between(*before, *now);
    }
    const double dt_before = to_seconds(scan_times_[i - 1] - scan_times_[i - 2]);
    const double dt_after = to_seconds(scan_times_[i + 1] - scan_times_[i]);
    if (!all || dt_before <= 0 || dt_after <= 0) continue;
    const Vec3 before = observed_[i - 1].motion.vector(), after = observed_[i + 1].motion.vector();
    const Vec3 rate = (wheels[2].vector() - wheels[1].vector()) / (2 * to_seconds(kShift));
    steps.push_back(
        {observed_[i].motion, wheels[0], Vec3::Zero(), 0.5 * (before + after), Vec3::Zero()});
    if (!timed) continue;
    steps.back().wheels_per_lag = rate;
    steps.back().change = 0.5 * (after / dt_after - before / dt_before);
  }
  return steps;
}

void OdometryModel::learn_faults(std::size_t first) {
  Choice found = search_lag(first);
  const Duration searched = found.lag;
  const bool timed = stamps_tell(found, first);
  OdometryFit fit;
  fit.faults = {0, scale_, turn_scale_, offset_};
  for (int round = 0; round < kRounds; ++round) {
    const auto steps = compare(found, timed, first);
    if (steps.size() < kLeastSteps) return;
    fit = fit_odometry(steps, fit.faults, round + 1 == kRounds);
    const Duration furthest = from_seconds(1.5 * options_.lag_step);
    found.lag = std::clamp(found.lag + from_seconds(fit.faults.lag), searched - furthest,
                           searched + furthest);
  }
  choose_lag(found, fit, first);
  take_findings(fit);
  learn_noise(first);
}

void OdometryModel::take_findings(const OdometryFit& fit) {
  const auto learnt = [](double value, double sigma, double usable, double floor = 0) {
    return Learnt{value, std::hypot(sigma, floor), sigma < usable};
  };
  const OdometryFaults& f = fit.faults;
  findings_.translation_scale = learnt(f.scale, fit.scale, kUsableScale, kScaleFloor);
  findings_.rotation_scale = learnt(f.turn_scale, fit.turn_scale, kUsableScale, kTurnScaleFloor);
  findings_.laser_x_m = learnt(f.D.x, fit.D.x(), kUsablePlace);
  findings_.laser_y_m = learnt(f.D.y, fit.D.y(), kUsablePlace);
  findings_.laser_theta_rad = learnt(f.D.theta, fit.D.z(), kUsableTurn);
  scale_ = findings_.translation_scale.used ? f.scale : 1;
  turn_scale_ = findings_.rotation_scale.used ? f.turn_scale : 1;
  offset_ = {findings_.laser_x_m.used ? f.D.x : 0, findings_.laser_y_m.used ? f.D.y : 0,
             findings_.laser_theta_rad.used ? f.D.theta : 0};
}

// Determined: a small sigma, and a disagreement that grows to both sides. Applied: not nothing.
void OdometryModel::choose_lag(const Choice& found, const OdometryFit& fit, std::size_t first) {
  const auto at = [&](Duration aside) {
    return disagreement({found.records, found.lag + aside}, first);
  };
  const double here = at(0);
  Learnt& lag = findings_.lag_s;
  lag = {to_seconds(found.lag), std::hypot(fit.lag, kLagFloor), false};
  lag.used = fit.lag < kUsableLag && here < at(-2 * kShift) && here < at(2 * kShift);
  const bool applied = lag.used && std::abs(lag.value) > kSure * lag.sigma;
  choice_ = {found.records, applied ? found.lag : 0};
}

// Errors of the wheels add up like a random walk: per root of the way and of the turn.
void OdometryModel::learn_noise(std::size_t first) {
  double cost = 0, rows = 0, way = 0, turned = 0, turn_cost = 0, samples = 0;
  std::size_t hint = 0;
  for (std::size_t i = first; i < observed_.size(); ++i) {
    if (!observed_[i].trusted) continue;
    const auto before = pose(choice_, i - 1, hint), now = pose(choice_, i, hint);
    if (!before || !now) continue;
    const Pose2& seen = observed_[i].motion;
    const Pose2 wheels = between(*before, *now), told = foretold(wheels);
    const double off_turn = angle_diff(seen.theta, told.theta);
    const double off_step = (seen.translation() - told.translation()).squaredNorm();
    if (off_step > kGrossStep * kGrossStep || std::abs(off_turn) > kGrossTurn) continue;
    const double w = 1.0 / (1.0 + off_step / (0.02 * 0.02));
    cost += w * off_step, rows += w, samples += 1;
    way += wheels.translation().norm(), turned += std::abs(wheels.theta);
    turn_cost += off_turn * off_turn;
  }
  if (samples < kLeastSteps) return;
  findings_.translation_noise = std::sqrt(cost / (2 * rows) * samples / std::max(way, 1e-3));
  findings_.rotation_noise = std::sqrt(turn_cost / std::max(turned, 1e-3));
}

}  // namespace majak::motion
