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

/// Up and down lanes, trees everywhere but on them.
sim::Scene orchard(double metres) {
  sim::Scene scene;
  scene.name = "orchard";
  scene.straight = true;
  const int lanes = static_cast<int>(std::ceil(metres / (kWide + kLane)));
  for (int lane = 0; lane < lanes; ++lane) {
    const double y = lane * kLane, begin = lane % 2 == 0 ? 0 : kWide, end = kWide - begin;
    const double in = begin < end ? 12 : -12;  // the corners are cut
    scene.tour.push_back({begin + in, y}), scene.tour.push_back({end - in, y});
    if (lane + 1 < lanes)
      scene.tour.push_back({end, y + 12}), scene.tour.push_back({end, y + kLane - 12});
  }
  scene.start = {scene.tour[0].x(), scene.tour[0].y(), 0};
  RandomStream random(4);
  for (double y = -40; y < lanes * kLane; y += kApart)
    for (double x = -40; x < kWide + 40; x += kApart) {
      const double u = x + random.uniform(-4, 4);
      const Vec2 p(u, y + random.uniform(-4, 4));
      const double aside = std::abs(p.y() - kLane * std::round(p.y() / kLane));
      const bool edge = p.x() < 16 || p.x() > kWide - 16;
      if (aside > 3 && !edge) scene.discs.push_back({p, random.uniform(0.1, 0.4), 0.4});
    }
  return scene;
}

std::vector<Event> drive(double metres) {
  const sim::World world{orchard(metres)};
  sim::SimulationOptions options;
  sim::make_car(options);
  options.robot.speed = 5;
  options.beams = 361, options.scan_rate = 2.5;
  return sim::simulate(world, sim::plan_tour(world), options);
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
