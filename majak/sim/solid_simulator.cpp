// SPDX-License-Identifier: Apache-2.0
#include "majak/sim/solid_simulator.hpp"

#include <cmath>

#include "majak/sim/streams.hpp"

namespace majak::sim {

SolidSimulator::SolidSimulator(const World& world, const SolidWorld& solid, const Path& path,
                               const SimulationOptions& options, const SecondLaserOptions& second)
    : solid_(solid),
      options_(options),
      second_(second),
      variant_(sensor::variant_of_beams(second.beams)),
      noise_(options.laser, RandomStream(static_cast<std::uint64_t>(options.seed), kLaserRun, 1)),
      simulator_(world, path, options) {}

double SolidSimulator::tilt_at(Duration time) const {
  if (second_.nod == 0) return 0;
  return second_.nod * std::sin(2 * kPi * to_seconds(time) / second_.nod_period);
}

map::TiltTrack SolidSimulator::tilt() const {
  if (second_.nod == 0) return {};
  std::vector<std::pair<Time, double>> samples;
  for (Duration t = 0; t <= run().duration() + RobotRun::kTick; t += RobotRun::kTick)
    samples.emplace_back(from_seconds(options_.start_time) + t, tilt_at(t));
  return map::TiltTrack(std::move(samples));
}

std::optional<Event> SolidSimulator::next() {
  if (waiting_) return std::exchange(waiting_, std::nullopt);
  auto event = simulator_.next();
  if (event && std::holds_alternative<Scan>(*event))
    waiting_ = make_scan(scans_++, std::get<Scan>(*event).time);
  return event;
}

Scan SolidSimulator::make_scan(std::int64_t number, Time stamp) const {
  const Duration begin = number * simulator_.scan_period();
  Scan scan;
  scan.time = stamp;
  scan.laser = second_.mounting.laser;
  scan.start_angle = variant_.start_angle();
  scan.angle_step = variant_.angle_step();
  scan.max_range = static_cast<float>(options_.laser.max_range);
  scan.T_robot_laser = {second_.mounting.x, second_.mounting.y, second_.mounting.yaw};
  scan.T_odom_robot = run().odometry(begin - from_seconds(options_.odometry_lag));
  for (int i = 0; i < variant_.beams(); ++i) {
    const Duration fired = begin + sensor::beam_time(variant_, i);
    const Pose3 T_world_laser =
        in_space(run().truth(fired)) * second_.mounting.T_robot_laser(tilt_at(fired));
    const double angle = scan.angle(static_cast<std::size_t>(i));
    const Vec3 direction = T_world_laser.rotation * Vec3(std::cos(angle), std::sin(angle), 0);
    const SolidHit hit =
        solid_.cast(T_world_laser.translation, direction, options_.laser.max_range);
    RandomStream random(static_cast<std::uint64_t>(options_.seed),
                        kSecondBeam + static_cast<std::uint64_t>(number),
                        static_cast<std::uint64_t>(i));
    scan.ranges.push_back(
        noise_.simulate_range(hit.range, hit.incidence, hit.reflectivity, random));
    if (!options_.intensities) continue;
    const bool echo = std::isfinite(scan.ranges.back());
    const sensor::Echo from{hit.range, hit.incidence, hit.reflectivity};
    scan.intensities.push_back(echo ? static_cast<float>(std::round(std::max(
                                          1.0, sensor::echo_strength(options_.laser, from))))
                                    : 0);
  }
  return scan;
}

}  // namespace majak::sim
