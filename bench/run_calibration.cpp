// SPDX-License-Identifier: Apache-2.0
// Is a calibration as right as it says? Simulated short tours with 1 % of wheel difference, 2 % of
// track, 3 cm and 1 degree of mounting and 50 ms of time offset, each mapped and calibrated. A car,
// which reports speed and steering (in the yard one of full size): 1 % of speed, 0.57 degrees of
// steering, 2 % of wheelbase.
//   run_calibration [RUNS] [FIRST-SEED] [WORLD] [car]
#include <fmt/core.h>

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/core/parallel.hpp"
#include "majak/eval/consistency.hpp"
#include "majak/motion/drive_log.hpp"
#include "majak/sensor/lms291.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/simulator.hpp"
#include "majak/slam/graph_slam.hpp"

namespace majak::bench {
namespace {

constexpr double kLeft = 0.995, kRight = 1.005, kTrackScale = 1.02, kLag = 0.05;
const Pose2 kToldOff{-0.03, 0.03,
                     radians(1.0)};  // the mounting that the log says, less the true one
constexpr double kSpeedScale = 1.01, kSteeringOffset = 0.01;
constexpr std::size_t kValues = motion::kUnknowns + 2;
constexpr std::array<const char*, kValues> kNames{"scale",   "turn scale",       "turn per metre",
                                                  "laser x", "laser y",          "laser heading",
                                                  "lag",     "wheel difference", "track"};

struct Run {
  std::array<double, kValues> error{}, sigma{};
  double nees = 0;
};

sim::SimulationOptions faulty(int seed, bool car, const std::string& world) {
  sim::SimulationOptions o;
  if (car && world == "yard") sim::make_car(o);
  o.seed = seed, o.odometry_lag = kLag;
  o.robot.scale_sigma = o.robot.unequal_sigma = o.robot.track_sigma = o.robot.steering_sigma = 0;
  if (car) {
    o.robot.drive = sim::DriveKind::ackermann, o.robot.reports_steering = true;
    o.robot.left_scale = kSpeedScale, o.robot.steering_offset = kSteeringOffset;
  } else {
    o.robot.left_scale = kLeft, o.robot.right_scale = kRight, o.robot.track_scale = kTrackScale;
  }
  return o;
}

Pose2 mounting_of(const sim::SimulationOptions& o) {
  return {o.mounting_x, o.mounting_y, o.mounting_theta};
}

motion::Calibration calibrate(const sim::SimulationOptions& o, const std::string& world_name) {
  const sim::World world(sim::built_in(world_name));
  const bool car = o.robot.reports_steering;
  motion::LogCalibrationOptions told;
  (car ? told.wheelbase : told.track) = kTrackScale * (car ? o.robot.wheelbase : o.robot.track);
  slam::GraphSlamOptions options;
  options.chain.drive.wheelbase = told.wheelbase;
  slam::GraphSlam slam(options, {1});
  motion::DriveLog log;
  for (Event& event : sim::simulate(world, sim::plan_tour(world, {.short_tour = true}), o)) {
    if (auto* scan = std::get_if<Scan>(&event))
      scan->T_robot_laser = from_vector(mounting_of(o).vector() + kToldOff.vector());
    log.add(event);
    slam.add(std::move(event));
  }
  return motion::calibrate_log(log, slam.finish().site, told).calibration;
}

std::array<double, kValues> true_values(const sim::SimulationOptions& o) {
  const Pose2 mounting = mounting_of(o);
  // A scan stands for the middle of its sweep.
  const auto& variant = sensor::variant_of_beams(181);
  const double lag = kLag + to_seconds(sensor::beam_time(variant, 90));
  if (o.robot.reports_steering) {  // a record tells of the time since the one before
    return {1 / kSpeedScale,
            kTrackScale / kSpeedScale,
            -kSteeringOffset,
            mounting.x,
            mounting.y,
            mounting.theta,
            lag + 1 / o.odometry_rate,
            0,
            o.robot.wheelbase};
  }
  const double left = 1 / kLeft, right = 1 / kRight, mean = (left + right) / 2;
  return {mean,
          mean * kTrackScale,
          (right - left) / o.robot.track,
          mounting.x,
          mounting.y,
          mounting.theta,
          lag,
          (right - left) / mean,
          o.robot.track};
}

Run run(const sim::SimulationOptions& options, const std::string& world) {
  const motion::Calibration c = calibrate(options, world);
  const auto truth = true_values(options);
  Run out;
  motion::Vec7 error;
  for (std::size_t k = 0; k < kValues; ++k) {
    const Learnt& value = k < motion::kUnknowns    ? c.values[k]
                          : k == motion::kUnknowns ? c.wheel_difference
                                                   : c.length;
    out.error[k] = value.value - truth[k], out.sigma[k] = value.sigma;
    if (k < motion::kUnknowns) error(static_cast<int>(k)) = out.error[k];
  }
  out.nees = error.dot(c.covariance.inverse() * error);
  return out;
}

void print(const std::vector<Run>& runs, bool car) {
  const double n = static_cast<double>(runs.size()), dof = n * motion::kUnknowns;
  double nees = 0;
  for (const Run& r : runs) nees += r.nees / n;
  fmt::print("NEES {:.2f}, 7 expected, 95 % band of {} runs {:.2f} ... {:.2f}\n", nees, runs.size(),
             eval::chi_square_quantile(0.025, dof) / n, eval::chi_square_quantile(0.975, dof) / n);
  for (std::size_t k = 0; k < kValues; ++k) {
    const bool difference = k == motion::kUnknowns;
    if (car && difference) continue;
    const char* name = car && k == 2             ? "steering offset"
                       : car && k + 1 == kValues ? "wheelbase"
                                                 : kNames[k];
    double square = 0, ratio = 0, mean = 0, sigma = 0;
    for (const Run& r : runs) {
      const double e = r.error[k], s = r.sigma[k];
      square += e * e / n, ratio += e * e / (s * s) / n, mean += e / n, sigma += s / n;
    }
    fmt::print(
        "{:<17} rms error {:.5f}, mean {:+.5f}, stated sigma {:.5f}, rms error/sigma {:.2f}\n",
        name, std::sqrt(square), mean, sigma, std::sqrt(ratio));
  }
}

}  // namespace
}  // namespace majak::bench

int main(int argc, char** argv) {
  const int runs = argc > 1 ? std::atoi(argv[1]) : 100, seed = argc > 2 ? std::atoi(argv[2]) : 1001;
  const std::string world = argc > 3 ? argv[3] : "building";
  const bool car = argc > 4 && std::string(argv[4]) == "car";
  try {
    std::vector<majak::bench::Run> results(static_cast<std::size_t>(std::max(runs, 1)));
    majak::parallel_for({}, results.size(), [&](std::size_t i) {
      results[i] =
          majak::bench::run(majak::bench::faulty(seed + static_cast<int>(i), car, world), world);
    });
    majak::bench::print(results, car);
  } catch (const majak::Error& error) {
    fmt::print(stderr, "run_calibration: {}\n", error.what());
    return 1;
  }
  return 0;
}
