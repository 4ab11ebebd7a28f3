// SPDX-License-Identifier: Apache-2.0
// EKF-SLAM and the graph on the Victoria Park set. Without satellites: errors against the fixes
// after one alignment of the whole path, and from the first pose alone (at the first fix, 36
// degrees). With them: against the fixes of bursts that were held out, nothing aligned. Means of
// fixes with their 95 % interval, bursts drawn at random. Trunks: where they stand by sightings of
// even and of odd minutes.
//   run_ekf_slam FOLDER
#include <ctime>
#include <map>

#include "bench/victoria_park.hpp"
#include "majak/core/error.hpp"
#include "majak/core/rigid_fit.hpp"
#include "majak/eval/landmarks.hpp"
#include "majak/eval/trajectory.hpp"
#include "majak/slam/landmark_graph.hpp"

namespace {

using namespace majak;
using bench::ParkData;

const Vec2 kAntenna(3.6, 0.6);  // m, from the rear axle
constexpr double kFirstHeading = radians(36);

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

struct Matched {
  std::vector<Vec2> path, fixes;
  std::vector<bool> sound;
  std::vector<int> burst;
};

Matched match(const ParkData& data, const localize::Localization& run, const Vec2& antenna,
              const std::set<int>* held) {
  eval::Trajectory trajectory;
  for (const Estimate& e : run.estimates) trajectory.push_back({e.time, e.T_map_robot});
  const eval::TrajectoryIndex index(trajectory);
  Matched m;
  for (std::size_t k = 0; k < data.fixes.size(); ++k) {
    if (held && !held->contains(data.burst[k])) continue;
    const auto found = index.at(data.fixes[k].time);
    if (!found) continue;
    m.path.push_back(found->pose * antenna);
    m.fixes.emplace_back(data.fixes[k].east, data.fixes[k].north);
    m.sound.push_back(data.sound[k]);
    m.burst.push_back(data.burst[k]);
  }
  return m;
}

void tell(const std::string& name, const Matched& m, const Pose2& T_gps_map) {
  std::vector<double> all, sound;
  std::vector<int> bursts;
  for (std::size_t i = 0; i < m.path.size(); ++i) {
    all.push_back((T_gps_map * m.path[i] - m.fixes[i]).norm());
    if (m.sound[i]) sound.push_back(all.back()), bursts.push_back(m.burst[i]);
  }
  bench::tell_errors(name, "all", all);
  bench::tell_errors(name, "sound", sound);
  const auto mean = eval::mean_with_confidence(sound, bursts);
  fmt::print("   mean of the sound ones {:.2f} ... {:.2f}\n", mean.low, mean.high);
}

void tell_trunks(const char* name, const slam::LandmarkMap& map) {
  std::vector<eval::LandmarkSeen> seen;
  for (const slam::LandmarkObservation& o : map.observations) {
    const Estimate& e = map.localization.estimates[o.scan];
    seen.push_back({e.time, e.T_map_robot, o.q_robot, o.landmark});
  }
  const eval::ErrorStats error = eval::split_half(seen).error;
  fmt::print(
      "{}: {} trunks by even and odd minutes apart, mean {:.3f}  median {:.3f}  max {:.2f}\n", name,
      error.count, error.mean, error.median, error.max);
}

void without_satellites(const ParkData& data, const char* name, const localize::Localization& run) {
  const Matched m = match(data, run, kAntenna, nullptr);
  std::vector<Vec2> path, fixes;
  for (std::size_t i = 0; i < m.path.size(); ++i)
    if (m.sound[i]) path.push_back(m.path[i]), fixes.push_back(m.fixes[i]);
  tell(fmt::format("{}, aligned", name), m, rigid_fit(path, fixes));
  const Pose2 turn{0, 0, kFirstHeading - run.estimates.front().T_map_robot.theta};
  const Vec2 off = m.fixes.front() - turn * m.path.front();
  tell(fmt::format("{}, first pose", name), m, {off.x(), off.y(), turn.theta});
}

slam::LandmarkMap run(const ParkData& data, const std::set<int>& held, bool satellites) {
  slam::EkfSlamOptions options;
  options.use_gps = satellites;
  const double begin = cpu_seconds();
  slam::EkfSlam slam(options);
  std::size_t fix = 0;
  for (const Event& event : data.events) {
    if (std::holds_alternative<GpsFix>(event) && held.contains(data.burst[fix++])) continue;
    slam.add(event);
  }
  auto map = slam.finish();
  double nis = 0, dof = 0;
  for (const auto& i : map.localization.innovations)
    if (i.sensor == std::string("landmarks")) nis += i.nis, dof += i.dof;
  fmt::print("EKF: {:.2f} CPU s, {} landmarks, {} sightings, NIS by degree of freedom {:.2f}\n",
             cpu_seconds() - begin, map.landmarks.size(), map.observations.size(), nis / dof);
  for (const auto& v : map.localization.learnt)
    fmt::print("   {} {:.4f} +- {:.4f} {}\n", v.name, v.value, v.sigma, v.unit);
  for (const auto& [what, entry] : map.localization.report.entries())
    fmt::print("   {} {}\n", entry.count, what);
  return map;
}

slam::LandmarkMap by_graph(const slam::LandmarkMap& seen) {
  const double begin = cpu_seconds();
  auto map = slam::optimize_landmarks(seen);
  fmt::print("graph: {:.2f} CPU s, {} landmarks\n", cpu_seconds() - begin, map.landmarks.size());
  return map;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc != 2) throw Error("run_ekf_slam FOLDER");
    const ParkData data(argv[1]);
    const auto map = run(data, {}, false);
    without_satellites(data, "EKF", map.localization);
    const auto best = graph(map);
    without_satellites(data, "graph", best.localization);
    tell_trunks("EKF", map), tell_trunks("graph", best);
    for (const int fold : {0, 1}) {
      const std::set<int> held = data.held_out(fold);
      const auto with = run(data, held, true);
      tell(fmt::format("EKF, fold {}", fold), match(data, with.localization, kAntenna, &held), {});
      tell(fmt::format("graph, fold {}", fold),
           match(data, by_graph(with).localization, kAntenna, &held), {});
    }
  } catch (const Error& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  }
}
