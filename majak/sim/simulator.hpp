// SPDX-License-Identifier: Apache-2.0
// Simulator: a robot with an LMS-291 drives through a world; events come out in the order in which
// a log would have them.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "majak/core/event.hpp"
#include "majak/sensor/lms291.hpp"
#include "majak/sim/doors.hpp"
#include "majak/sim/robot.hpp"
#include "majak/sim/satellites.hpp"
#include "majak/sim/world.hpp"

namespace majak::sim {

struct SimulationOptions {
  int seed = 1;
  int beams = 181;            ///< 181, 361, 101, 201 or 401
  double scan_rate = 7.5;     ///< Hz, rounded to whole turns of the mirror
  double odometry_rate = 10;  ///< Hz
  double start_time = 1e9;    ///< s, stamp of the run's begin (seconds since 1970 look like this)
  sensor::RangeNoiseOptions laser;
  RobotOptions robot;
  SatelliteOptions satellites;
  double mounting_x = 0.1;    ///< m, T_robot_laser
  double mounting_y = 0;      ///< m
  double mounting_theta = 0;  ///< rad

  // Faults, off by default.
  bool tell_mounting = true;  ///< false: the events say that the laser is at the robot's centre
  double odometry_lag = 0;    ///< s; odometry stamped t shows where the robot was at t - lag
  double stamp_bursts = 0;    ///< share of scans with which a burst begins: several are kept back
                              ///< and stamped together when they arrive
  bool intensities = false;   ///< scans carry the strength of each echo
  int people = 0;             ///< who walk along the same ways
  int vehicles = 0;           ///< that drive along the same ways, on either side; for wide ways
  double door_period = 0;     ///< s, each door of the scene changes so often; 0: all doorways empty
  double felled = 0;          ///< share of the trunks and posts (not reflectors) that are gone ...
  double felled_at = 0;       ///< s, ... from that time of the run on
};
void describe(OptionFields& fields, SimulationOptions& options);

/// Every error of laser, wheels and satellites times `factor`; 0: all of them off, mixed pixels and
/// limited reach included. Faults stay.
void scale_noise(SimulationOptions& options, double factor);

/// An Ackermann drive of full size, the laser at its bumper, the antenna on its roof.
void make_car(SimulationOptions& options);

/// Yields Odometry (or WheelMotion: means since the record before), GpsFix, Scan and Truth. Truth
/// carries the stamp of its scan and the pose of the robot when beam 0 was fired; beam i of a scan
/// was fired sensor::beam_time(i) later.
class Simulator {
 public:
  /// `world` must outlive the simulator. Throws Error when an option is out of its range or the
  /// robot cannot follow the path.
  Simulator(const World& world, const Path& path, const SimulationOptions& options);

  /// The next event, or nothing after the last one.
  std::optional<Event> next();

  const RobotRun& run() const { return run_; }
  /// T_robot_laser as it truly is, told or not.
  Pose2 mounting() const { return T_robot_laser_; }
  const sensor::Variant& variant() const { return variant_; }
  Duration scan_period() const { return period_; }
  const Satellites& satellites() const { return satellites_; }
  /// Those that move; empty when door_period is 0.
  const std::vector<Door>& doors() const { return doors_; }
  /// Those that are gone from felled_at on, as indices of the scene's discs, ascending.
  const std::vector<std::size_t>& felled() const { return felled_; }

 private:
  static constexpr int kPatches = 5;  ///< of a beam's spot

  struct Walker {
    double begin = 0, speed = 0, aside = 0;  ///< m along the path, m/s, m to its left
    bool vehicle = false;
  };
  /// All that the laser may see at a time.
  struct View {
    const World& world;
    std::vector<Disc> moving;
    std::vector<Segment> leaves;
  };
  struct Reading {
    float range, intensity;
  };
  void produce();
  void put(Time arrival, Event event);
  Time stamp_of(Duration time) const;
  Duration odometry_time(std::int64_t record) const;
  void produce_fixes(Duration until);
  Event wheels_report(std::int64_t record) const;
  Time arrival_of_scan(std::int64_t scan);
  Scan make_scan(std::int64_t scan, Time stamp) const;
  void fell();
  void send_off();
  View view_at(Duration time) const;
  Pose2 place_of(const Walker& walker, Duration time) const;
  Reading measure(std::int64_t scan, int beam, const Pose2& T_world_beam, const Hit& hit,
                  bool mixed, const View& view) const;
  float intensity(float range, const std::array<sensor::Echo, kPatches>& echoes,
                  RandomStream& random) const;
  bool touches_reflector(const Pose2& T_world_beam) const;

  const World& world_;
  std::optional<World> thinned_;  ///< the world from felled_at on
  std::vector<std::size_t> felled_;
  std::vector<Vec2> path_;
  SimulationOptions options_;
  sensor::Variant variant_;
  sensor::RangeNoise noise_;
  RobotRun run_;
  Satellites satellites_;
  Pose2 T_robot_laser_;
  std::vector<Walker> walkers_;
  std::vector<Door> doors_;
  std::vector<Disc> reflectors_;  ///< those of the world
  Duration period_ = 0;
  std::int64_t next_scan_ = 0, next_odometry_ = 0, next_fix_ = 0;
  std::int64_t burst_end_ = -1;  ///< scans before this one arrive together with it
  Time last_arrival_ = 0;
  std::int64_t order_ = 0;
  std::map<std::pair<Time, std::int64_t>, Event> waiting_;  ///< by arrival, then as produced
};

/// All events of a run.
std::vector<Event> simulate(const World& world, const Path& path, const SimulationOptions& options);

}  // namespace majak::sim
