// SPDX-License-Identifier: Apache-2.0
#include "majak/sim/simulator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "majak/core/error.hpp"
#include "majak/sim/streams.hpp"

namespace majak::sim {

namespace {

constexpr Duration kMicrosecond = 1000;
constexpr double kPersonRadius = 0.22;  // m
constexpr double kPolite = 0.6;         // m; a person that near to the robot has stepped aside
constexpr double kVehicleRadius = 0.4;  // m, of its front and its back, the only ones seen
constexpr double kVehicleLength = 2.4;  // m, between their centres
constexpr double kRightOfWay = 2.0;     // m; a vehicle whose middle is that near has turned off
constexpr double kEdge = 0.05;          // m; a smaller step between beams is no edge
constexpr double kOnePlace = 1.0;       // m; patches that near to each other send one echo
constexpr double kFlicker = 0.05;       // one sigma of an echo's strength, as a share of it
constexpr double kStrongest = 65535;    // 16 bits
constexpr Duration kBurstSpacing = kSecond / 1000;

void require(bool good, const char* what) {
  if (!good) throw Error(std::string("simulation: ") + what);
}

}  // namespace

void describe(OptionFields& fields, SimulationOptions& o) {
  fields.add("simulate.seed", o.seed, {"", "equal seeds give equal bytes", 0, 2147483647});
  fields.add("simulate.beams", o.beams, {"", "181, 361, 101, 201 or 401", 101, 401});
  fields.add("simulate.scan_rate", o.scan_rate, {"Hz", "rounded to whole mirror turns", 0.1, 75});
  fields.add("simulate.odometry_rate", o.odometry_rate, {"Hz", "odometry records", 0.1, 50});
  fields.add("simulate.start_time", o.start_time, {"s", "stamp of the run's begin", 0, 4e9});
  fields.add("simulate.mounting_x", o.mounting_x, {"m", "laser ahead of the robot's point", -5, 5});
  fields.add("simulate.mounting_y", o.mounting_y, {"m", "laser to the left of it", -5, 5});
  fields.add("simulate.mounting_theta", o.mounting_theta, {"rad", "laser's heading", -3.2, 3.2});
  fields.add("simulate.tell_mounting", o.tell_mounting, {"", "false: the log says zero"});
  fields.add("simulate.odometry_lag", o.odometry_lag, {"s", "odometry behind the laser", -1, 1});
  fields.add("simulate.stamp_bursts", o.stamp_bursts, {"1", "share of scans: bursts", 0, 1});
  fields.add("simulate.intensities", o.intensities, {"", "scans carry the strength of echoes"});
  fields.add("simulate.people", o.people, {"", "who walk along the same ways", 0, 1000});
  fields.add("simulate.vehicles", o.vehicles, {"", "that drive along the same ways", 0, 1000});
  fields.add("simulate.door_period", o.door_period,
             {"s", "each door of the world changes so often; 0: none moves", 0, 1e6});
  fields.add("simulate.felled", o.felled, {"1", "share of trunks and posts that vanish", 0, 1});
  fields.add("simulate.felled_at", o.felled_at, {"s", "when, from the run's start", 0, 1e6});
  describe(fields, o.laser);
  describe(fields, o.robot);
  describe(fields, o.satellites);
}

void scale_noise(SimulationOptions& o, double factor) {
  if (factor == 0) {
    const double max_range = o.laser.max_range;
    o.laser = sensor::perfect_range();
    o.laser.max_range = max_range;
    o.robot = perfect_wheels(o.robot);
    o.satellites.sigma = o.satellites.bias_sigma = 0;
    return;
  }
  for (double* value :
       {&o.laser.systematic_error, &o.laser.statistical_error, &o.laser.no_return,
        &o.robot.scale_sigma, &o.robot.unequal_sigma, &o.robot.track_sigma, &o.robot.steering_sigma,
        &o.robot.slip, &o.robot.steering_noise, &o.satellites.sigma, &o.satellites.bias_sigma}) {
    *value *= factor;
  }
}

void make_car(SimulationOptions& o) {
  o.robot.drive = DriveKind::ackermann;
  o.robot.wheelbase = 2.7;
  o.robot.max_steering = radians(35);
  o.robot.speed = 3, o.robot.acceleration = 1;
  o.mounting_x = 3.4;
  o.satellites.antenna_x = 1.2, o.satellites.antenna_y = 0.4;
}

Simulator::Simulator(const World& world, const Path& path, const SimulationOptions& options)
    : world_(world),
      path_(path.points),
      options_(options),
      variant_(sensor::variant_of_beams(options.beams)),
      noise_(options.laser, RandomStream(static_cast<std::uint64_t>(options.seed), kLaserRun)),
      run_(drive_path(path, options.robot, static_cast<std::uint64_t>(options.seed))),
      satellites_(options.satellites, run_.duration(), static_cast<std::uint64_t>(options.seed)) {
  require(options.scan_rate > 0 && options.odometry_rate > 0, "rates must be more than 0 Hz");
  require(std::abs(options.odometry_lag) <= 10, "odometry_lag must lie within +-10 s");
  require(options.start_time >= 0 && options.start_time <= 4e9, "start_time must be 0 ... 4e9 s");
  require(options.people >= 0 && options.people <= 1000, "people must be 0 ... 1000");
  require(options.vehicles >= 0 && options.vehicles <= 1000, "vehicles must be 0 ... 1000");
  require(options.door_period >= 0 && options.door_period <= 1e6, "door_period: 0 ... 1e6 s");
  require(options.felled >= 0 && options.felled <= 1, "felled must be 0 ... 1");
  require(options.felled_at >= 0 && options.felled_at <= 1e6, "felled_at must be 0 ... 1e6 s");
  T_robot_laser_ = {options.mounting_x, options.mounting_y, wrap_angle(options.mounting_theta)};
  // The device never scans slower; a slow line only drops whole scans.
  const double turns = std::round(sensor::kLms291.mirror_rate / options.scan_rate);
  const double least = variant_.turns();
  period_ = static_cast<Duration>(std::max(least, turns)) * sensor::kMirrorTurn;
  for (const Disc& disc : world.scene().discs) {
    if (disc.reflectivity > kShining) reflectors_.push_back(disc);
  }
  if (options.felled > 0) fell();
  send_off();
  if (options.door_period > 0)
    doors_ = draw_doors(world.scene(), path, options.door_period, run_.duration(),
                        static_cast<std::uint64_t>(options.seed));
}

/// Each trunk by its own draw, so that a larger share fells the same ones and more.
void Simulator::fell() {
  Scene scene = world_.scene();
  const std::vector<Disc> all = std::exchange(scene.discs, {});
  for (std::size_t i = 0; i < all.size(); ++i) {
    RandomStream r(static_cast<std::uint64_t>(options_.seed), kFelled, i);
    const bool stays = all[i].reflectivity > kShining || r.uniform() >= options_.felled;
    if (stays) scene.discs.push_back(all[i]);
    if (!stays) felled_.push_back(i);
  }
  thinned_.emplace(std::move(scene));
}

void Simulator::send_off() {
  const auto seed = static_cast<std::uint64_t>(options_.seed);
  const double way = length(path_);
  for (int i = 0; i < options_.people; ++i) {
    RandomStream r(seed, kWalker, static_cast<std::uint64_t>(i));
    walkers_.push_back({r.uniform(0, 2 * way), r.uniform(0.7, 1.4), r.uniform(-0.6, 0.6), false});
  }
  for (int i = 0; i < options_.vehicles; ++i) {
    RandomStream r(seed, kVehicle, static_cast<std::uint64_t>(i));
    const double side = r.uniform() < 0.5 ? -1 : 1;
    walkers_.push_back({r.uniform(0, 2 * way), r.uniform(2, 6), side * r.uniform(2.3, 2.7), true});
  }
}

/// Whole microseconds, so that a log with six decimals says exactly this.
Time Simulator::stamp_of(Duration time) const {
  const Time stamp = from_seconds(options_.start_time) + time;
  return (stamp + kMicrosecond / 2) / kMicrosecond * kMicrosecond;
}

Duration Simulator::odometry_time(std::int64_t record) const {
  return from_seconds(static_cast<double>(record) / options_.odometry_rate);
}

std::optional<Event> Simulator::next() {
  // What is still to be produced arrives at its own time at the earliest.
  const auto earliest = [this] {
    Duration time = std::min(next_scan_ * period_, odometry_time(next_odometry_));
    if (options_.satellites.on) time = std::min(time, satellites_.time(next_fix_));
    return stamp_of(time);
  };
  while (next_scan_ * period_ + sensor::scan_duration(variant_) <= run_.duration() &&
         (waiting_.empty() || waiting_.begin()->first.first >= earliest())) {
    produce();
  }
  if (waiting_.empty()) return std::nullopt;
  return std::move(waiting_.extract(waiting_.begin()).mapped());
}

void Simulator::put(Time arrival, Event event) {
  waiting_.emplace(std::pair(arrival, order_++), std::move(event));
}

Event Simulator::wheels_report(std::int64_t record) const {
  const Duration lag = from_seconds(options_.odometry_lag), time = odometry_time(record) - lag;
  const Time stamp = stamp_of(odometry_time(record));
  const RobotState& state = run_.state(time);
  if (!options_.robot.reports_steering)
    return Odometry{stamp, run_.odometry(time), state.speed, state.turn_rate};
  const Duration before = odometry_time(record - 1) - lag;
  const Vec2 mean = (run_.counted(time) - run_.counted(before)) / to_seconds(time - before);
  return WheelMotion{stamp, mean.x(), mean.y()};
}

void Simulator::produce_fixes(Duration until) {
  for (; satellites_.time(next_fix_) <= until; ++next_fix_) {
    auto fix = satellites_.fix(next_fix_, run_.truth(satellites_.time(next_fix_)));
    if (!fix) continue;
    fix->time = stamp_of(fix->time);
    put(fix->time, *fix);
  }
}

/// One scan with its truth, and the odometry records and fixes that precede it.
void Simulator::produce() {
  const Duration scan_time = next_scan_ * period_;
  for (; odometry_time(next_odometry_) <= scan_time; ++next_odometry_)
    put(stamp_of(odometry_time(next_odometry_)), wheels_report(next_odometry_));
  if (options_.satellites.on) produce_fixes(scan_time);
  const Time arrival = arrival_of_scan(next_scan_);
  put(arrival, make_scan(next_scan_, arrival));
  put(arrival, Truth{arrival, run_.truth(scan_time)});
  ++next_scan_;
}

/// The stamp is the time of beam 0, unless the scan is part of a burst.
Time Simulator::arrival_of_scan(std::int64_t scan) {
  const auto seed = static_cast<std::uint64_t>(options_.seed);
  RandomStream r(seed, kStamps, static_cast<std::uint64_t>(scan));
  if (scan > burst_end_ && r.uniform() < options_.stamp_bursts) {
    burst_end_ = scan + 2 + static_cast<std::int64_t>(r.below(5));
  }
  Time arrival = stamp_of(scan * period_);
  if (scan < burst_end_) arrival = stamp_of(burst_end_ * period_);
  // Those that arrive together are stamped a millisecond apart.
  if (scan <= burst_end_) arrival = std::max(arrival, last_arrival_ + kBurstSpacing);
  last_arrival_ = arrival;
  return arrival;
}

Scan Simulator::make_scan(std::int64_t scan, Time stamp) const {
  const Duration begin = scan * period_;
  const int beams = variant_.beams();
  Scan out;
  out.time = stamp;
  out.start_angle = variant_.start_angle();
  out.angle_step = variant_.angle_step();
  out.max_range = static_cast<float>(options_.laser.max_range);
  if (options_.tell_mounting) out.T_robot_laser = T_robot_laser_;
  if (!options_.robot.reports_steering)
    out.T_odom_robot = run_.odometry(begin - from_seconds(options_.odometry_lag));
  const View view = view_at(begin);

  std::vector<Pose2> poses(beams);
  std::vector<Hit> hits(beams);
  for (int i = 0; i < beams; ++i) {
    poses[i] = run_.truth(begin + sensor::beam_time(variant_, i)) * T_robot_laser_;
    hits[i] = view.world.cast(poses[i].translation(), poses[i].theta + out.angle(i),
                              options_.laser.max_range, view.moving, view.leaves);
  }
  // A spot falls on two things only where the neighbouring beams see different ones.
  const auto edge = [&](int i, int j) {
    return hits[i].object != hits[j].object && !(std::abs(hits[i].range - hits[j].range) < kEdge);
  };
  out.ranges.resize(beams);
  if (options_.intensities) out.intensities.resize(beams);
  for (int i = 0; i < beams; ++i) {
    const bool at_an_edge = (i > 0 && edge(i, i - 1)) || (i + 1 < beams && edge(i, i + 1));
    const Pose2 T_world_beam{poses[i].x, poses[i].y, poses[i].theta + out.angle(i)};
    const bool mixed = at_an_edge || touches_reflector(T_world_beam);
    const Reading reading = measure(scan, i, T_world_beam, hits[i], mixed, view);
    out.ranges[i] = reading.range;
    if (options_.intensities) out.intensities[i] = reading.intensity;
  }
  return out;
}

Simulator::Reading Simulator::measure(std::int64_t scan, int beam, const Pose2& T_world_beam,
                                      const Hit& hit, bool mixed, const View& view) const {
  RandomStream random(static_cast<std::uint64_t>(options_.seed),
                      kBeam + static_cast<std::uint64_t>(scan), static_cast<std::uint64_t>(beam));
  std::array<sensor::Echo, kPatches> echoes;
  const double width = options_.laser.beam_width;
  if (!mixed || width == 0) {
    echoes.fill({hit.range, hit.incidence, hit.reflectivity});
    const float range = noise_.simulate_range(hit.range, hit.incidence, hit.reflectivity, random);
    return {range, intensity(range, echoes, random)};
  }
  const double range = std::isfinite(hit.range) ? hit.range : options_.laser.max_range;
  const double half = width * sensor::half_beam_angle(range);
  for (int k = 0; k < kPatches; ++k) {
    const double aside = half * (2.0 * k / (kPatches - 1) - 1.0);
    const Hit h = view.world.cast(T_world_beam.translation(), T_world_beam.theta + aside,
                                  options_.laser.max_range, view.moving, view.leaves);
    echoes[k] = {h.range, h.incidence, h.reflectivity};
  }
  // A reflector outshines whatever else is in the spot.
  const auto others = std::stable_partition(
      echoes.begin(), echoes.end(), [](const auto& e) { return e.reflectivity > kShining; });
  const auto shining = static_cast<std::size_t>(others - echoes.begin());
  const float measured =
      noise_.simulate_range(echoes.data(), shining > 0 ? shining : echoes.size(), random);
  return {measured, intensity(measured, echoes, random)};
}

/// What the patches at the measured range send back, together.
float Simulator::intensity(float range, const std::array<sensor::Echo, kPatches>& echoes,
                           RandomStream& random) const {
  if (!options_.intensities || !std::isfinite(range)) return 0;
  double sum = 0;
  for (const sensor::Echo& e : echoes) {
    if (std::abs(e.range - range) < kOnePlace) sum += sensor::echo_strength(options_.laser, e);
  }
  const double strength = sum / kPatches * (1 + kFlicker * random.normal());
  return static_cast<float>(std::round(std::clamp(strength, 1.0, kStrongest)));
}

/// Does the beam's spot fall on a reflector, be it between two beams?
bool Simulator::touches_reflector(const Pose2& T_world_beam) const {
  return std::any_of(reflectors_.begin(), reflectors_.end(), [&](const Disc& disc) {
    const Vec2 way = disc.centre - T_world_beam.translation();
    const double distance = way.norm();
    const double half = std::asin(std::min(1.0, disc.radius / distance)) +
                        options_.laser.beam_width * sensor::half_beam_angle(distance);
    return std::abs(angle_diff(std::atan2(way.y(), way.x()), T_world_beam.theta)) < half;
  });
}

/// To and fro along the path, each on a line of their own.
Pose2 Simulator::place_of(const Walker& w, Duration time) const {
  const auto last = static_cast<double>(path_.size() - 1);
  const double way = w.begin + w.speed * to_seconds(time);
  const double phase = std::fmod(way / kPathStep, 2 * last);
  const double at = phase < last ? phase : 2 * last - phase;
  const auto i = std::min(static_cast<std::size_t>(at), path_.size() - 2);
  const Vec2 along = path_[i + 1] - path_[i];
  const Vec2 left = Vec2(-along.y(), along.x()).normalized();
  const Vec2 p = path_[i] + (at - static_cast<double>(i)) * along + w.aside * left;
  return {p.x(), p.y(), std::atan2(along.y(), along.x())};
}

Simulator::View Simulator::view_at(Duration time) const {
  const bool thinned = thinned_ && time >= from_seconds(options_.felled_at);
  View view{thinned ? *thinned_ : world_, {}, leaves(doors_, time)};
  const Vec2 robot = run_.truth(time).translation();
  for (const Walker& w : walkers_) {
    const Pose2 T = place_of(w, time);
    const double distance = (T.translation() - robot).norm();
    if (!w.vehicle && distance > kPolite)
      view.moving.push_back({T.translation(), kPersonRadius, 0.3});
    if (!w.vehicle || distance <= kRightOfWay) continue;
    for (const double end : {-kVehicleLength / 2, kVehicleLength / 2})
      view.moving.push_back({T * Vec2(end, 0), kVehicleRadius, 0.3});
  }
  return view;
}

std::vector<Event> simulate(const World& world, const Path& path,
                            const SimulationOptions& options) {
  Simulator simulator(world, path, options);
  std::vector<Event> events;
  while (auto event = simulator.next()) events.push_back(std::move(*event));
  return events;
}

}  // namespace majak::sim
