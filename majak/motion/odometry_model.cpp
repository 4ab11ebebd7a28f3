// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/odometry_model.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

namespace majak::motion {
namespace {

constexpr std::size_t kNoRecord = static_cast<std::size_t>(-1);
constexpr std::size_t kHistory = 2000;      // scans looked back at when learning
constexpr double kGrossTurn = 0.10;         // rad, disagreement beyond which a scan is an outlier
constexpr double kGrossStep = 0.15;         // m

}  // namespace

void OdometryModel::Stream::push(Time time, const Pose2& pose, double speed, bool reversed) {
  Sample s{time, pose, pose, speed};
  if (!samples.empty()) {
    Pose2 step = between(samples.back().raw, pose);
    if (reversed && speed < 0 && step.x > 0) step.x = -step.x, step.y = -step.y;
    s.mended = samples.back().mended * step;
  }
  latest.push_back(latest.empty() ? time : std::max(latest.back(), time));
  samples.push_back(s);
}

std::optional<Pose2> OdometryModel::Stream::at(Time time) const {
  if (samples.empty() || time < latest.front() || time > latest.back()) return std::nullopt;
  const auto after = static_cast<std::size_t>(std::lower_bound(latest.begin(), latest.end(), time) - latest.begin());
  if (latest[after] == time || after == 0) return samples[after].mended;
  const double part = static_cast<double>(time - latest[after - 1]) / static_cast<double>(latest[after] - latest[after - 1]);
  const Pose2 &a = samples[after - 1].mended, &b = samples[after].mended;  // a few centimetres apart: straight
  return Pose2{a.x + part * (b.x - a.x), a.y + part * (b.y - a.y), wrap_angle(a.theta + part * angle_diff(b.theta, a.theta))};
}

void OdometryModel::add(const Odometry& odometry) {
  stream_.push(odometry.time, odometry.T_odom_robot, odometry.speed.value_or(0), reversed_);
}

void OdometryModel::add(const Scan& scan) {
  scan_times_.push_back(scan.time);
  observed_.push_back({});
  record_of_.push_back(scan.T_odom_robot ? records_.samples.size() : kNoRecord);
  if (scan.T_odom_robot)
    records_.push(scan.time, *scan.T_odom_robot, 0, false);
  else if (scan_times_.size() == 1)
    choice_.records = false;
}

bool OdometryModel::ready(std::size_t scan) const {
  const Time wanted = scan_times_[scan] + choice_.lag;
  const Stream& s = choice_.records ? records_ : stream_;
  if (choice_.records && choice_.lag == 0) return true;
  return s.latest.empty() || s.latest.back() >= wanted;
}

std::optional<Pose2> OdometryModel::pose(const Choice& choice, std::size_t scan) const {
  if (choice.records && choice.lag == 0)
    return record_of_[scan] != kNoRecord ? std::optional(records_.samples[record_of_[scan]].mended) : std::nullopt;
  return (choice.records ? records_ : stream_).at(scan_times_[scan] + choice.lag);
}

std::optional<Pose2> OdometryModel::pose(std::size_t scan) const { return pose(choice_, scan); }

std::optional<Pose2> OdometryModel::wheel_motion(const Choice& choice, std::size_t scan) const {
  if (scan == 0) return std::nullopt;
  const auto before = pose(choice, scan - 1), now = pose(choice, scan);
  if (!before || !now) return std::nullopt;
  return between(*before, *now);
}

std::optional<PredictedMotion> OdometryModel::predict(std::size_t scan) const {
  const auto wheels = wheel_motion(choice_, scan);
  if (!wheels) return std::nullopt;
  const Pose2 mended{scale_ * wheels->x, scale_ * wheels->y, wrap_angle(turn_scale_ * wheels->theta)};
  PredictedMotion motion;
  motion.T_previous_robot = offset_.inverse() * mended * offset_;
  const double step = std::hypot(mended.x, mended.y), turn = std::abs(mended.theta);
  if (findings_.translation_noise <= 0) {  // nothing learnt yet
    motion.sigma_translation = options_.floor_translation + options_.share * step;
    motion.sigma_rotation = options_.floor_rotation + options_.share * turn;
    return motion;
  }
  // Errors of the wheels add up like a random walk.
  motion.sigma_translation = options_.learnt_floor_translation + 1.5 * findings_.translation_noise * std::sqrt(step);
  motion.sigma_rotation = options_.learnt_floor_rotation + 1.5 * findings_.rotation_noise * std::sqrt(turn);
  return motion;
}

void OdometryModel::observe(std::size_t scan, const Pose2& T_previous_robot, bool trusted) {
  observed_[scan] = {T_previous_robot, trusted};
  if (scan < next_learning_) return;
  next_learning_ *= 2;
  learn();
}

void OdometryModel::learn() {
  const std::size_t n = next_learning_ / 2, first = n > kHistory ? n - kHistory : 1;
  learn_direction(first);
  learn_lag(first);
  learn_linear(first);
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
    const auto k = static_cast<std::size_t>(std::lower_bound(latest.begin(), latest.end(), scan_times_[i]) - latest.begin());
    if (!wheels || k >= latest.size() || stream_.samples[k].speed >= 0 || wheels->x <= 0.005) continue;
    along += wheels->x * observed_[i].motion.x;
    ++records;
  }
  if (records < 5 || along >= 0) return;
  reversed_ = true;
  choice_.records = false;  // the scans' own records state no speed, so they cannot be mended
  mend();
}

void OdometryModel::mend() {
  Stream mended;
  findings_.reversed_records = 0;
  for (const Sample& s : stream_.samples) {
    if (!mended.samples.empty() && s.speed < 0 && between(mended.samples.back().raw, s.raw).x > 0) ++findings_.reversed_records;
    mended.push(s.time, s.raw, s.speed, true);
  }
  stream_ = std::move(mended);
}

// Mean disagreement in heading, each scan's capped; turning tells the time best.
double OdometryModel::disagreement(const Choice& choice, std::size_t first) const {
  double sum = 0;
  std::size_t n = 0;
  for (std::size_t i = first; i < observed_.size(); ++i) {
    if (!observed_[i].trusted) continue;
    const auto wheels = wheel_motion(choice, i);
    if (!wheels) continue;
    sum += std::min(std::abs(angle_diff(wheels->theta, observed_[i].motion.theta)), kGrossTurn);
    sum += std::min(std::abs(std::hypot(wheels->x, wheels->y) - std::hypot(observed_[i].motion.x, observed_[i].motion.y)), kGrossStep);
    ++n;
  }
  return n < 100 ? 1e9 : sum / static_cast<double>(n);
}

void OdometryModel::learn_lag(std::size_t first) {
  const double now = disagreement(choice_, first);
  double best = 0.97 * now;  // a change must be worth it
  Choice chosen = choice_;
  const int steps = static_cast<int>(std::lround(options_.max_lag / options_.lag_step));
  for (const bool records : {true, false}) {
    if ((records ? records_ : stream_).samples.empty() || (records && reversed_)) continue;
    for (int k = -steps; k <= steps; ++k) {
      const Choice choice{records, from_seconds(k * options_.lag_step)};
      const double value = disagreement(choice, first);
      if (value < best) best = value, chosen = choice;
    }
  }
  choice_ = chosen;
  findings_.lag_s = {to_seconds(choice_.lag), options_.lag_step, choice_.lag != 0};
}

// Scale, turn scale and offset by robust linear least squares of
//   t_laser = R(-theta) (scale * t_wheels + (R - I) (x, y)),   turn_laser = turn_scale * turn_wheels,
// which is linear in scale cos(theta), R(-theta) (x, y), scale sin(theta).
void OdometryModel::learn_linear(std::size_t first) {
  Eigen::Matrix4d h = Eigen::Matrix4d::Zero();
  Eigen::Vector4d b = Eigen::Vector4d::Zero();
  double cost = 0, rows = 0, turn_xy = 0, turn_xx = 0, way = 0, turned = 0, turn_cost = 0;
  const Vec2 turned_back = Pose2{0, 0, -offset_.theta} * offset_.translation();
  const Eigen::Vector4d current(scale_ * std::cos(offset_.theta), turned_back.x(), turned_back.y(), scale_ * std::sin(offset_.theta));
  for (std::size_t i = first; i < observed_.size(); ++i) {
    if (!observed_[i].trusted) continue;
    const auto wheels = wheel_motion(choice_, i);
    if (!wheels) continue;
    const Pose2& seen = observed_[i].motion;
    const double off_turn = angle_diff(seen.theta, turn_scale_ * wheels->theta);
    const double c = std::cos(wheels->theta) - 1, s = std::sin(wheels->theta);
    Eigen::Matrix<double, 2, 4> a;
    a << wheels->x, c, -s, wheels->y, wheels->y, s, c, -wheels->x;
    const Vec2 e = seen.translation() - a * current;
    if (e.norm() > kGrossStep || std::abs(off_turn) > kGrossTurn) continue;
    const double w = 1.0 / (1.0 + e.squaredNorm() / (0.02 * 0.02));
    h += w * a.transpose() * a;
    b += w * a.transpose() * seen.translation();
    cost += w * e.squaredNorm(), rows += 2 * w;
    turn_xy += wheels->theta * seen.theta, turn_xx += wheels->theta * wheels->theta;
    way += wheels->translation().norm(), turned += std::abs(wheels->theta);
    turn_cost += off_turn * off_turn;
  }
  if (rows < 200) return;
  // What the log does not determine stays at its nominal value: a weak prior of 1 (scale), 0.3 m, 0.1 rad.
  const double variance = std::max(cost / rows, 1e-6);
  Eigen::Vector4d prior(1 / (0.1 * 0.1), 1 / (0.1 * 0.1), 1 / (0.1 * 0.1), 1 / (0.05 * 0.05));
  h /= variance, b /= variance;
  h.diagonal() += prior;
  b(0) += prior(0);
  const Eigen::Vector4d x = h.llt().solve(b);
  const Eigen::Vector4d sigma = h.inverse().diagonal().cwiseSqrt();
  scale_ = std::hypot(x(0), x(3));
  const double theta = std::atan2(x(3), x(0));
  const Vec2 place = Pose2{0, 0, theta} * Vec2(x(1), x(2));
  offset_ = {place.x(), place.y(), theta};
  findings_.translation_scale = {scale_, sigma(0), true};
  findings_.laser_x_m = {place.x(), sigma(1), true};
  findings_.laser_y_m = {place.y(), sigma(2), true};
  findings_.laser_theta_rad = {theta, sigma(3), true};
  const double samples = rows / 2;
  if (turn_xx > 0.1) {
    turn_scale_ = turn_xy / turn_xx;
    findings_.rotation_scale = {turn_scale_, std::sqrt(turn_cost / samples / turn_xx), true};
  }
  // Shares of the motion, twice the scatter that was seen.
  findings_.translation_noise = std::sqrt(cost / rows * samples / std::max(way, 1e-3));
  findings_.rotation_noise = std::sqrt(turn_cost / std::max(turned, 1e-3));
}

}  // namespace majak::motion
