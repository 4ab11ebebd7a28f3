// SPDX-License-Identifier: Apache-2.0
// What a scan costs EKF-SLAM as its map grows: a car drives up and down a large simulated orchard
// of some thousand trees, and through Victoria Park where its log is given. The median tells of
// scans between two looks around, which touch what is near alone; the mean has the looks around.
//   run_slam_time [--metres WAY] [--park FOLDER] [--picture PREFIX]
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <map>
#include <string>
#include <vector>

#include "bench/picture.hpp"
#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/draw/slam_figures.hpp"
#include "majak/eval/statistics.hpp"
#include "majak/io/source.hpp"
#include "majak/sim/simulator.hpp"
#include "majak/slam/ekf_slam.hpp"

namespace majak::bench {
namespace {

constexpr double kWide = 600, kLane = 60, kApart = 14;  // m
constexpr int kBin = 100;                               // landmarks

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// Up and down lanes, with half circles at their ends.
sim::Path lanes(double metres) {
  sim::Path path;
  const double turn = kPi * kLane / 2, each = kWide + turn;
  for (double at = 0; at < metres; at += sim::kPathStep) {
    const double lane = std::floor(at / each), along = at - lane * each;
    const double side = std::fmod(lane, 2) == 0 ? 1 : -1, centre = kWide / 2;
    const double angle = std::max(0.0, along - kWide) / (kLane / 2);
    const double x = std::min(along, kWide) - centre + kLane / 2 * std::sin(angle);
    path.points.emplace_back(centre + side * x, kLane * (lane + 0.5 * (1 - std::cos(angle))));
  }
  return path;
}

/// Trees everywhere but on the way.
sim::Scene orchard(const sim::Path& path) {
  sim::Scene scene;
  scene.name = "orchard";
  RandomStream random(4);
  const double top = path.points.back().y() + 40;
  for (double y = -40; y < top; y += kApart)
    for (double x = -70; x < kWide + 70; x += kApart) {
      const double u = x + random.uniform(-4, 4);
      const Vec2 p(u, y + random.uniform(-4, 4));
      const double thick = random.uniform(0.1, 0.4);
      const bool free = std::all_of(path.points.begin(), path.points.end(),
                                    [&](const Vec2& q) { return (p - q).norm() > 3; });
      if (free) scene.discs.push_back({p, thick, 0.4});
    }
  return scene;
}

std::vector<Event> drive(double metres) {
  const sim::Path path = lanes(metres);
  const sim::World world{orchard(path)};
  sim::SimulationOptions options;
  sim::make_car(options);
  options.robot.speed = 5;
  options.beams = 361, options.scan_rate = 2.5;
  return sim::simulate(world, path, options);
}

draw::StepTimes measure(const std::string& name, const std::vector<Event>& events,
                        double wheelbase) {
  slam::EkfSlamOptions options;
  options.wheelbase = wheelbase, options.use_gps = false;
  slam::EkfSlam slam(options);
  struct Bin {
    std::vector<double> ms, near;
  };
  std::map<int, Bin> bins;
  double whole = 0;
  for (const Event& event : events) {
    const double begin = cpu_seconds();
    const bool scan = slam.add(event).has_value();
    const double seconds = cpu_seconds() - begin;
    whole += seconds;
    if (!scan) continue;
    Bin& bin = bins[static_cast<int>(slam.filter().size()) / kBin];
    bin.ms.push_back(1e3 * seconds);
    bin.near.push_back(static_cast<double>(slam.filter().near().size()));
  }
  draw::StepTimes times{name, {}, {}};
  fmt::print(
      "{}: {:.1f} CPU s\n| landmarks | of them near | median | mean | 99 % "
      "|\n|---|---|---|---|---|\n",
      name, whole);
  for (const auto& [bin, b] : bins) {
    const auto stats = eval::error_stats(b.ms);
    const double at = (bin + 0.5) * kBin;
    times.median.push_back({at, stats.median}), times.mean.push_back({at, stats.mean});
    fmt::print("| {:.0f} | {:.0f} | {:.2f} ms | {:.2f} ms | {:.1f} ms |\n", at,
               eval::error_stats(b.near).mean, stats.median, stats.mean,
               eval::quantile(b.ms, 0.99));
  }
  return times;
}

void run(double metres, const std::string& park, const std::string& picture) {
  std::vector<draw::StepTimes> all;
  all.push_back(measure("simulated orchard", drive(metres), 2.7));
  if (!park.empty()) {
    std::vector<Event> events;
    const auto source = io::open_log(park);
    while (auto event = source->next()) events.push_back(std::move(*event));
    all.push_back(measure("Victoria Park", events, 2.83));
  }
  if (!picture.empty()) write_picture(picture, draw::step_time_picture(all));
}

}  // namespace
}  // namespace majak::bench

int main(int argc, char** argv) {
  double metres = 6000;
  std::string park, picture;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string name = argv[i], value = argv[i + 1];
    if (name == "--metres") metres = std::max(100.0, std::atof(value.c_str()));
    if (name == "--park") park = value;
    if (name == "--picture") picture = value;
  }
  try {
    majak::bench::run(metres, park, picture);
  } catch (const majak::Error& error) {
    fmt::print(stderr, "run_slam_time: {}\n", error.what());
    return 1;
  }
  return 0;
}
