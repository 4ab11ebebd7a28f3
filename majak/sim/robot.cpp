// SPDX-License-Identifier: Apache-2.0
#include "majak/sim/robot.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/sim/pilot.hpp"
#include "majak/sim/streams.hpp"

namespace majak::sim {

namespace {

constexpr int kRestTicks = 50;         // at rest before and after, as logs are
constexpr int kDisturbanceTicks = 20;  // 0.4 s
constexpr int kSpeedTicks = 12;        // a quarter of a second

/// What the wheels report, tick by tick, and what the robot's computer makes of it.
class WheelOdometry {
 public:
  WheelOdometry(const RobotOptions& options, std::uint64_t seed) : options_(options), seed_(seed) {
    RandomStream run(seed, kWheelRun);
    const double common = options.scale_sigma * run.normal();
    const double exact[3] = {options.left_scale, options.right_scale, options.right_scale};
    for (int i = 0; i < 3; ++i) {
      scale_[i] = exact[i] * (1 + common + options.unequal_sigma * run.normal());
    }
    const double arm_scale = options.track_scale * (1 + options.track_sigma * run.normal());
    steering_offset_ = options.steering_offset + options.steering_sigma * run.normal();
    // The robot's computer believes these lengths; the truth uses the options' own.
    differential_.track = options.track * arm_scale;
    ackermann_.wheelbase = options.wheelbase * arm_scale;
    omni_.arm = options.arm * arm_scale;
  }

  /// The motion that the odometry derives from one tick of true motion.
  Vec3 measure(const Vec3& motion, std::uint64_t tick) {
    RandomStream noise(seed_, kWheelNoise, tick);
    switch (options_.drive) {
      case DriveKind::differential: {
        const auto w = motion::Differential{options_.track}.inverse(motion);
        const double left = roll(0, w.left, noise);
        return differential_.forward({left, roll(1, w.right, noise)});
      }
      case DriveKind::ackermann: {
        const auto w = motion::Ackermann{options_.wheelbase}.inverse(motion);
        const double way = roll(0, options_.reports_steering ? motion.x() : w.way, noise);
        if (w.way != 0) steering_ = w.steering;  // at rest the wheel stays as it is
        read_steering(tick, noise);
        if (!options_.reports_steering) return ackermann_.forward({way, reading_});
        return {way, 0, way * std::tan(reading_) / ackermann_.wheelbase};
      }
      case DriveKind::omnidirectional:
        break;
    }
    auto w = motion::Omnidirectional{options_.arm}.inverse(motion);
    for (int i = 0; i < 3; ++i) w[i] = roll(i, w[i], noise);
    return omni_.forward(w);
  }
  /// Sum of the readings of the steering so far, rad.
  double steered() const { return steered_; }

 private:
  void read_steering(std::uint64_t tick, RandomStream& noise) {
    const double error = steering_offset_ + options_.steering_noise * noise.normal();
    const double time = static_cast<double>(tick) * to_seconds(RobotRun::kTick);
    const double stuck = time - options_.steering_stuck_at;
    const bool sticks = tick > 0 && stuck >= 0 && stuck < options_.steering_stuck_for;
    if (!sticks) reading_ = options_.steering_scale * steering_ + error;
    steered_ += reading_;
  }

  /// Way that the encoder of a wheel counts while the wheel truly rolls `way`.
  double roll(int wheel, double way, RandomStream& noise) {
    const double slip = options_.slip * std::sqrt(std::abs(way)) * noise.normal();
    rolled_[wheel] += way * scale_[wheel] + slip;
    if (options_.encoder_step <= 0) return way * scale_[wheel] + slip;
    const double before = counted_[wheel];
    counted_[wheel] = std::floor(rolled_[wheel] / options_.encoder_step);
    return (counted_[wheel] - before) * options_.encoder_step;
  }

  const RobotOptions& options_;
  std::uint64_t seed_;
  motion::Differential differential_;
  motion::Ackermann ackermann_;
  motion::Omnidirectional omni_;
  std::array<double, 3> scale_{};
  double steering_offset_ = 0;
  double steering_ = 0, reading_ = 0, steered_ = 0;  // rad
  std::array<double, 3> rolled_{};                   // m
  std::array<double, 3> counted_{};                  // whole encoder steps
};

/// Slips and bumps, one in each of as many equal parts of the way, in turn as long as there are
/// both.
class Disturber {
 public:
  Disturber(const RobotOptions& options, double way, std::uint64_t seed) {
    const int n = options.slips + options.bumps;
    int slips = options.slips, bumps = options.bumps;
    for (int i = 0; i < n; ++i) {
      RandomStream r(seed, kDisturbance, static_cast<std::uint64_t>(i));
      const bool bump = bumps > 0 && (slips == 0 || i % 2 == 1);
      --(bump ? bumps : slips);
      starts_.push_back(way * (i + r.uniform(0.3, 0.7)) / n);
      const double side = r.uniform() < 0.5 ? -1 : 1;
      const double way_off = r.uniform(0.05, 0.12), turn = side * radians(r.uniform(4, 12));
      planned_.push_back(
          {0, 0, bump, bump ? Vec3(0.02, side * way_off, turn) : Vec3(2 * way_off, 0, turn)});
    }
  }
  /// The part of one that falls on this tick, while the robot drives; else nothing.
  struct Part {
    Vec3 slip = Vec3::Zero(), bump = Vec3::Zero();
  };
  Part next(double driven, Duration now, bool moves) {
    if (left_ == 0 && next_ < starts_.size() && driven >= starts_[next_] && moves) {
      left_ = kDisturbanceTicks;
      done_.push_back(planned_[next_++]);
      done_.back().begin = now, done_.back().end = now + kDisturbanceTicks * RobotRun::kTick;
    }
    if (left_ == 0) return {};
    --left_;
    const Vec3 part = done_.back().twist / kDisturbanceTicks;
    return done_.back().bump ? Part{Vec3::Zero(), part} : Part{part, Vec3::Zero()};
  }
  const std::vector<Disturbance>& done() const { return done_; }

 private:
  std::vector<double> starts_;  // m driven
  std::vector<Disturbance> planned_, done_;
  std::size_t next_ = 0;
  int left_ = 0;  // ticks
};

void check(const Path& path, const RobotOptions& o) {
  if (path.points.size() < 2) throw Error("the robot has nowhere to go: its path is empty");
  const bool good = o.speed > 0 && o.acceleration > 0 && o.turn_rate > 0 && o.track > 0 &&
                    o.wheelbase > 0 && o.arm > 0 && o.max_steering > 0 && o.max_steering < kPi / 2;
  if (o.reports_steering && o.drive != DriveKind::ackermann)
    throw Error("robot: only an Ackermann drive reports its steering");
  if (!good) throw Error("robot: speed, acceleration, turn rate, lengths and steering must be > 0");
}

}  // namespace

void describe(OptionFields& fields, RobotOptions& o) {
  fields.add("robot.speed", o.speed, {"m/s", "at most", 0.01, 5});
  fields.add("robot.acceleration", o.acceleration, {"m/s^2", "at most", 0.01, 10});
  fields.add("robot.turn_rate", o.turn_rate, {"rad/s", "at most", 0.01, 10});
  fields.add("robot.track", o.track, {"m", "between the wheels, differential drive", 0.05, 5});
  fields.add("robot.wheelbase", o.wheelbase, {"m", "Ackermann drive", 0.05, 5});
  fields.add("robot.max_steering", o.max_steering, {"rad", "Ackermann drive", 0.1, 1.5});
  fields.add("robot.arm", o.arm, {"m", "centre to wheel, omnidirectional drive", 0.05, 5});
  fields.add("robot.left_scale", o.left_scale, {"1", "odometry's way per true way", 0.5, 2});
  fields.add("robot.right_scale", o.right_scale, {"1", "odometry's way per true way", 0.5, 2});
  fields.add("robot.track_scale", o.track_scale, {"1", "believed length per true length", 0.5, 2});
  fields.add("robot.steering_scale", o.steering_scale, {"1", "sensor's angle per true", 0.5, 2});
  fields.add("robot.steering_offset", o.steering_offset, {"rad", "of the sensor", -0.5, 0.5});
  fields.add("robot.scale_sigma", o.scale_sigma, {"1", "drawn once, common to all wheels", 0, 0.5});
  fields.add("robot.unequal_sigma", o.unequal_sigma, {"1", "drawn once for each wheel", 0, 0.5});
  fields.add("robot.track_sigma", o.track_sigma, {"1", "drawn once, of track or arm", 0, 0.5});
  fields.add("robot.steering_sigma", o.steering_sigma, {"rad", "drawn once", 0, 0.5});
  fields.add("robot.slip", o.slip, {"m/sqrt(m)", "random error of each wheel", 0, 0.5});
  fields.add("robot.steering_noise", o.steering_noise, {"rad", "of each reading", 0, 0.5});
  fields.add("robot.encoder_step", o.encoder_step, {"m", "rolled a tick, 0 for none", 0, 0.1});
  fields.add("robot.slips", o.slips, {"", "times the wheels slip", 0, 1000});
  fields.add("robot.bumps", o.bumps, {"", "times something pushes the robot", 0, 1000});
  fields.add("robot.wrong_direction", o.wrong_direction, {"", "backing is counted as ahead"});
  fields.add("robot.steering_stuck_at", o.steering_stuck_at,
             {"s", "Ackermann: the sensor stays at its reading from then on", 0, 1e6});
  fields.add("robot.steering_stuck_for", o.steering_stuck_for, {"s", "how long, 0: never", 0, 1e6});
  fields.add("robot.reports_steering", o.reports_steering,
             {"", "Ackermann: speed and steering instead of poses"});
}

RobotOptions perfect_wheels(RobotOptions o) {
  o.left_scale = o.right_scale = o.track_scale = o.steering_scale = 1;
  o.steering_offset = o.scale_sigma = o.unequal_sigma = o.track_sigma = o.steering_sigma = 0;
  o.slip = o.steering_noise = o.encoder_step = 0;
  return o;
}

std::size_t RobotRun::index(Duration time) const {
  return static_cast<std::size_t>(std::clamp<Duration>(time, 0, duration()) / kTick);
}

Pose2 RobotRun::truth(Duration time) const {
  const std::size_t i = index(time);
  const RobotState& s = states_[i];
  const Duration within =
      std::clamp<Duration>(time, 0, duration()) - static_cast<Duration>(i) * kTick;
  return within == 0 ? s.T_world_robot : s.T_world_robot * exp(to_seconds(within) * s.twist);
}

Pose2 RobotRun::odometry(Duration time) const {
  const std::size_t i = index(time);
  const Duration within =
      std::clamp<Duration>(time, 0, duration()) - static_cast<Duration>(i) * kTick;
  if (within == 0) return states_[i].T_odom_robot;
  return interpolate(states_[i].T_odom_robot, states_[i + 1].T_odom_robot,
                     static_cast<double>(within) / static_cast<double>(kTick));
}

Vec2 RobotRun::counted(Duration time) const {
  const std::size_t i = index(time), next = std::min(i + 1, states_.size() - 1);
  const double part = to_seconds(std::clamp<Duration>(time, 0, duration())) / to_seconds(kTick) -
                      static_cast<double>(i);
  const Vec2 a(states_[i].rolled, states_[i].steered);
  const Vec2 b(states_[next].rolled, states_[next].steered);
  return Vec2(1, to_seconds(kTick)).cwiseProduct(a + part * (b - a));
}

double RobotRun::path_length() const {
  double sum = 0;
  for (const RobotState& s : states_) sum += s.twist.head<2>().norm();
  return sum * to_seconds(kTick);
}

RobotRun drive_path(const Path& path, const RobotOptions& options, std::uint64_t seed) {
  check(path, options);
  const double dt = to_seconds(RobotRun::kTick);
  const double patience = 60 + 20 * length(path.points) / options.speed;  // s
  Pilot pilot(path, options);
  WheelOdometry wheels(options, seed);
  std::vector<RobotState> states;
  std::vector<Vec3> measured;
  Pose2 T_world_robot = path.start, T_odom_robot;
  Disturber disturber(options, length(path.points), seed);
  double driven = 0, rolled = 0;
  int rest = 0;
  while (rest < kRestTicks) {
    const std::size_t tick = states.size();
    if (static_cast<double>(tick) * dt > patience) {
      throw Error("the robot is stuck at (" + std::to_string(T_world_robot.x) + ", " +
                  std::to_string(T_world_robot.y) + ") m: its drive cannot follow the path");
    }
    const bool resting = tick < kRestTicks || pilot.finished();
    const Vec3 twist = resting ? Vec3::Zero() : pilot.next_twist(T_world_robot, dt);
    rest += pilot.finished() ? 1 : 0;
    // The speed of the last quarter of a second, as a wheel controller filters it.
    Vec3 recent = Vec3::Zero();
    const std::size_t used = std::min<std::size_t>(measured.size(), kSpeedTicks);
    for (std::size_t i = measured.size() - used; i < measured.size(); ++i) recent += measured[i];
    recent /= kSpeedTicks * dt;
    const auto disturbed = disturber.next(driven, static_cast<Duration>(tick) * RobotRun::kTick,
                                          std::abs(twist.x()) > 0.5 * options.speed);
    const Vec3 motion = twist * dt + disturbed.bump;
    driven += twist.head<2>().norm() * dt;
    states.push_back({T_world_robot, twist + disturbed.bump / dt, T_odom_robot, recent.x(),
                      recent.z(), rolled, wheels.steered()});
    Vec3 believed = wheels.measure(twist * dt, tick) + disturbed.slip;
    measured.push_back(believed);
    if (options.wrong_direction && believed.x() < 0) believed.x() = -believed.x();
    rolled += believed.x();
    T_world_robot = T_world_robot * exp(motion);
    T_odom_robot = T_odom_robot * exp(believed);
  }
  return RobotRun(std::move(states), disturber.done());
}

}  // namespace majak::sim
