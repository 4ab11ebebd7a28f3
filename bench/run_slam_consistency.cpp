// SPDX-License-Identifier: Apache-2.0
// Do EKF-SLAM and the landmark graph know how wrong they are? A car drives through the simulated
// park many times, each time with other errors of laser and wheels; where it begins is known, so
// that the map's own frame is the world's and the truth exact. NEES of the pose along the way
// against the chi-square band, NEES and errors of the trunks at the end, and what sightings are
// wrong by against what is told of them.
//   run_slam_consistency [--runs N] [--first SEED] [--case default|told|random] [--satellites 0|1]
//                        [--csv FILE] [--picture PREFIX]
// Cases: default options, made for a real car, whose wheels tell less than the simulated one's;
// "told": the filter is told how good they are; "random": and the laser has no error that is the
// same in a whole run.
#include <fmt/core.h>
#include <fmt/os.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "bench/picture.hpp"
#include "majak/core/error.hpp"
#include "majak/core/parallel.hpp"
#include "majak/draw/slam_figures.hpp"
#include "majak/eval/consistency.hpp"
#include "majak/eval/landmarks.hpp"
#include "majak/sim/park.hpp"
#include "majak/sim/simulator.hpp"
#include "majak/sim/tour.hpp"
#include "majak/slam/landmark_graph.hpp"

namespace majak::bench {
namespace {

constexpr Duration kStep = 10 * kSecond;  // between two looks at the pose
constexpr double kBin = 10;               // m of range

struct Arguments {
  int runs = 100, first = 1;
  bool satellites = false;
  std::string name = "default", csv, picture;
};

/// A pose at one time of one run.
struct PoseCheck {
  double nees = 0, place = 0, heading = 0;  ///< 3 expected; m, rad off the truth
};

/// What one method makes of one run.
struct Judged {
  std::vector<PoseCheck> poses;  ///< kStep apart
  eval::LandmarkMatch trunks, aligned;
};

struct SightingCheck {
  double range = 0;
  Vec2 error = Vec2::Zero(), whitened = Vec2::Zero();  ///< along the beam, across it
};

struct Run {
  std::vector<double> way;  ///< m driven at each check
  Judged ekf, graph;
  std::vector<SightingCheck> sightings;
  double ekf_seconds = 0, graph_seconds = 0;
};

sim::SimulationOptions car(int seed, const Arguments& arguments) {
  sim::SimulationOptions options;
  sim::make_car(options);
  options.seed = seed;
  options.robot.speed = 5;
  options.beams = 361, options.scan_rate = 2.5;
  options.satellites.on = arguments.satellites;
  if (arguments.name == "random") options.laser.systematic_error = 0;
  return options;
}

slam::EkfSlamOptions filter_of(const sim::SimulationOptions& car, const Arguments& arguments) {
  slam::EkfSlamOptions options;
  options.wheelbase = car.robot.wheelbase;
  if (arguments.name == "default") return options;
  // Each tick reads the steering anew: its errors add up as a random walk of the heading.
  const double tick = car.robot.speed * to_seconds(sim::RobotRun::kTick);  // m
  options.wheels.way_noise = options.wheels.side_noise = car.robot.slip;
  options.wheels.turn_noise = car.robot.steering_noise * std::sqrt(tick) / car.robot.wheelbase;
  options.wheels.spin_noise = car.robot.slip;
  return options;
}

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

PoseCheck check(const Estimate& e, const Pose2& truth) {
  const Pose2 off = between(truth, e.T_map_robot);
  return {eval::nees(e.T_map_robot, e.covariance, truth).value_or(0), off.translation().norm(),
          std::abs(off.theta)};
}

std::vector<eval::PlacedLandmark> standing(const slam::LandmarkMap& map) {
  std::vector<eval::PlacedLandmark> landmarks;
  for (const slam::MappedLandmark& l : map.landmarks)
    if (!l.gone) landmarks.push_back({l.p_map, l.covariance});
  return landmarks;
}

class Judge {
 public:
  Judge(const sim::World& world, const std::map<Time, Pose2>& truth) : truth_(truth) {
    for (const sim::Disc& disc : world.scene().discs) trunks_.push_back({disc.centre, {}});
  }

  Judged judge(const slam::LandmarkMap& map) const {
    Judged judged;
    for (const Estimate& e : checked(map)) judged.poses.push_back(check(e, truth_.at(e.time)));
    judged.trunks = eval::match_landmarks(standing(map), trunks_);
    judged.aligned = eval::match_landmarks(standing(map), trunks_, {.align = true});
    return judged;
  }

  std::vector<double> way(const slam::LandmarkMap& map) const {
    std::vector<double> ways;
    double way = 0;
    const Pose2* last = nullptr;
    auto checks = checked(map);
    for (const auto& [time, pose] : truth_) {
      if (last) way += (pose.translation() - last->translation()).norm();
      last = &pose;
      if (ways.size() < checks.size() && time == checks[ways.size()].time) ways.push_back(way);
    }
    return ways;
  }

  /// As told of each sighting, and as it was: of landmarks that are trunks.
  std::vector<SightingCheck> sightings(const slam::LandmarkMap& map) const {
    std::vector<eval::PlacedLandmark> all;
    for (const slam::MappedLandmark& l : map.landmarks) all.push_back({l.p_map, {}});
    std::map<std::size_t, Vec2> trunk_of;
    for (const auto& p : eval::match_landmarks(all, trunks_).pairs)
      trunk_of[p.mapped] = trunks_[p.truth].p;
    std::vector<SightingCheck> checks;
    for (const slam::LandmarkObservation& o : map.observations) {
      const auto trunk = trunk_of.find(static_cast<std::size_t>(o.landmark));
      if (trunk == trunk_of.end()) continue;
      const Pose2& truth = truth_.at(map.localization.estimates[o.scan].time);
      const Vec2 q = truth.inverse() * trunk->second, error = o.q_robot - q;
      const Vec2 beam = q - laser_, along = beam.normalized(), left(-along.y(), along.x());
      const Vec2 sigma{std::sqrt(along.dot(o.noise * along)), std::sqrt(left.dot(o.noise * left))};
      const Vec2 turned{along.dot(error), left.dot(error)};
      checks.push_back({beam.norm(), turned, turned.cwiseQuotient(sigma)});
    }
    return checks;
  }

  void set_laser(const Vec2& place) { laser_ = place; }

 private:
  std::vector<Estimate> checked(const slam::LandmarkMap& map) const {
    std::vector<Estimate> checks;
    const auto& estimates = map.localization.estimates;
    Time next = estimates.empty() ? 0 : estimates.front().time + kStep;
    for (const Estimate& e : estimates)
      if (e.time >= next) checks.push_back(e), next += kStep;
    return checks;
  }

  const std::map<Time, Pose2>& truth_;
  std::vector<eval::PlacedLandmark> trunks_;
  Vec2 laser_ = Vec2::Zero();
};

Run drive(const sim::World& world, const sim::Path& path, const sim::SimulationOptions& options,
          const slam::EkfSlamOptions& ekf) {
  slam::EkfSlam slam(ekf, path.start);
  std::map<Time, Pose2> truth;
  const std::vector<Event> events = sim::simulate(world, path, options);
  for (const Event& event : events)
    if (const auto* t = std::get_if<Truth>(&event)) truth[t->time] = t->T_world_robot;
  Run run;
  const double begin = cpu_seconds();
  for (const Event& event : events) slam.add(event);
  const slam::LandmarkMap map = slam.finish();
  const double middle = cpu_seconds();
  const slam::LandmarkMap graph = slam::optimize_landmarks(map, ekf);
  run.graph_seconds = cpu_seconds() - middle, run.ekf_seconds = middle - begin;
  Judge judge(world, truth);
  judge.set_laser({options.mounting_x, options.mounting_y});
  run.ekf = judge.judge(map), run.graph = judge.judge(graph);
  run.way = judge.way(map);
  run.sightings = judge.sightings(graph);
  return run;
}

// ---- Tables ----------------------------------------------------------------------------------

/// Of all runs at one time.
struct Checkpoint {
  double seconds = 0, way = 0;
  eval::NeesSummary ekf, graph;
  double ekf_place = 0, graph_place = 0;  ///< m, root of the mean square
};

eval::NeesSummary nees_at(const std::vector<Run>& runs, Judged Run::*method, std::size_t k) {
  std::vector<double> nees;
  for (const Run& run : runs) nees.push_back((run.*method).poses[k].nees);
  return eval::summarize_nees(nees, 3);
}

double place_at(const std::vector<Run>& runs, Judged Run::*method, std::size_t k) {
  std::vector<double> places;
  for (const Run& run : runs) places.push_back((run.*method).poses[k].place);
  return eval::error_stats(places).rms;
}

std::vector<Checkpoint> checkpoints(const std::vector<Run>& runs) {
  std::size_t count = runs.front().way.size();
  for (const Run& run : runs) count = std::min(count, run.way.size());
  std::vector<Checkpoint> all;
  for (std::size_t k = 0; k < count; ++k)
    all.push_back({to_seconds(kStep) * static_cast<double>(k + 1), runs.front().way[k],
                   nees_at(runs, &Run::ekf, k), nees_at(runs, &Run::graph, k),
                   place_at(runs, &Run::ekf, k), place_at(runs, &Run::graph, k)});
  return all;
}

void tell_poses(const std::vector<Checkpoint>& all) {
  fmt::print(
      "| time | way | NEES: EKF | graph | place rms: EKF | graph |\n|---|---|---|---|---|---|\n");
  for (std::size_t k = 0; k < all.size(); k += k < 5 ? 1 : 3) {
    const Checkpoint& c = all[k];
    const auto mark = [](const eval::NeesSummary& n) {
      return n.mean > n.band_high ? "+" : n.mean < n.band_low ? "-" : "";
    };
    fmt::print("| {:.0f} s | {:.0f} m | {:.2f}{} | {:.2f}{} | {:.3f} m | {:.3f} m |\n", c.seconds,
               c.way, c.ekf.mean, mark(c.ekf), c.graph.mean, mark(c.graph), c.ekf_place,
               c.graph_place);
  }
  const auto& n = all.front().ekf;
  fmt::print("3 expected, 95 % band of the mean over the runs {:.2f} ... {:.2f}; +: above it\n\n",
             n.band_low, n.band_high);
}

void tell_trunks(const std::vector<Run>& runs, const char* name, Judged Run::*method) {
  for (const bool aligned : {false, true}) {
    std::vector<double> errors, nees, missed, mistaken;
    std::vector<int> of, nees_of;
    for (std::size_t r = 0; r < runs.size(); ++r) {
      const auto& m = aligned ? (runs[r].*method).aligned : (runs[r].*method).trunks;
      missed.push_back(static_cast<double>(m.missed.size()));
      mistaken.push_back(static_cast<double>(m.mistaken.size()));
      for (const auto& p : m.pairs) {
        errors.push_back(p.error.norm()), of.push_back(static_cast<int>(r));
        if (p.nees) nees.push_back(*p.nees), nees_of.push_back(static_cast<int>(r));
      }
    }
    const auto error = eval::mean_with_confidence(errors, of);
    const auto n = eval::mean_with_confidence(nees, nees_of);
    const auto stats = eval::error_stats(errors);
    fmt::print(
        "{:5} {:9} trunks {:.0f} a run, missed {:.1f}, mistaken {:.1f}; error mean {:.3f} m "
        "({:.3f} ... {:.3f}), median {:.3f}, rms {:.3f}; NEES {:.2f} ({:.2f} ... {:.2f}), 2 "
        "expected\n",
        name, aligned ? "aligned" : "as it is",
        static_cast<double>(errors.size()) / static_cast<double>(runs.size()),
        eval::error_stats(missed).mean, eval::error_stats(mistaken).mean, error.mean, error.low,
        error.high, stats.median, stats.rms, n.mean, n.low, n.high);
  }
}

void tell_sightings(const std::vector<Run>& runs) {
  struct Sums {
    Vec2 error = Vec2::Zero(), square = Vec2::Zero(), whitened = Vec2::Zero();
    double count = 0;
  };
  std::map<int, Sums> bins;
  for (const Run& run : runs)
    for (const SightingCheck& s : run.sightings) {
      Sums& sums = bins[static_cast<int>(s.range / kBin)];
      sums.error += s.error, sums.square += s.error.cwiseAbs2();
      sums.whitened += s.whitened.cwiseAbs2();
      ++sums.count;
    }
  fmt::print(
      "\n| range | sightings | along: mean, rms, by its sigma | across |\n|---|---|---|---|\n");
  for (const auto& [bin, s] : bins) {
    const Vec2 mean = s.error / s.count, rms = (s.square / s.count).cwiseSqrt(),
               whitened = (s.whitened / s.count).cwiseSqrt();
    fmt::print("| {:.0f} m | {:.0f} | {:.3f}, {:.3f} m, {:.2f} | {:.3f}, {:.3f} m, {:.2f} |\n",
               (bin + 0.5) * kBin, s.count, mean.x(), rms.x(), whitened.x(), mean.y(), rms.y(),
               whitened.y());
  }
}

void write_csv(const std::string& file, const std::vector<Checkpoint>& all) {
  auto out = fmt::output_file(file);
  out.print("seconds,way,ekf_nees,graph_nees,band_low,band_high,ekf_place_rms,graph_place_rms\n");
  for (const Checkpoint& c : all)
    out.print("{},{:.2f},{:.4f},{:.4f},{:.4f},{:.4f},{:.5f},{:.5f}\n", c.seconds, c.way, c.ekf.mean,
              c.graph.mean, c.ekf.band_low, c.ekf.band_high, c.ekf_place, c.graph_place);
}

draw::Figure picture_of(const std::vector<Checkpoint>& all, const Arguments& arguments) {
  draw::NeesPicture picture;
  picture.title = fmt::format("Simulated park, {} runs, {}", arguments.runs, arguments.name);
  picture.band_low = all.front().ekf.band_low, picture.band_high = all.front().ekf.band_high;
  for (const Checkpoint& c : all) {
    picture.seconds.push_back(c.seconds);
    picture.ekf.push_back(c.ekf.mean), picture.graph.push_back(c.graph.mean);
    picture.ekf_place.push_back(c.ekf_place), picture.graph_place.push_back(c.graph_place);
  }
  return draw::nees_picture(picture);
}

/// The last time until which a method stayed below the band's upper end, and where it is above.
void tell_bounds(const std::vector<Checkpoint>& all, const char* name,
                 eval::NeesSummary Checkpoint::*method) {
  std::size_t above = 0, first = all.size();
  for (std::size_t k = 0; k < all.size(); ++k) {
    if ((all[k].*method).mean <= (all[k].*method).band_high) continue;
    ++above, first = std::min(first, k);
  }
  if (above == 0) return fmt::print("{}: never too sure of itself\n", name);
  fmt::print("{}: too sure of itself at {} of {} times, first after {:.0f} s, {:.0f} m\n", name,
             above, all.size(), all[first].seconds, all[first].way);
}

void run_all(const Arguments& arguments) {
  const sim::World world{sim::park()};
  const sim::Path path = sim::plan_tour(world);
  std::vector<Run> runs(static_cast<std::size_t>(arguments.runs));
  parallel_for({}, runs.size(), [&](std::size_t i) {
    const sim::SimulationOptions options = car(arguments.first + static_cast<int>(i), arguments);
    runs[i] = drive(world, path, options, filter_of(options, arguments));
  });
  const std::vector<Checkpoint> all = checkpoints(runs);
  tell_poses(all);
  tell_bounds(all, "EKF", &Checkpoint::ekf);
  tell_bounds(all, "graph", &Checkpoint::graph);
  tell_trunks(runs, "EKF", &Run::ekf);
  tell_trunks(runs, "graph", &Run::graph);
  tell_sightings(runs);
  double ekf = 0, graph = 0;
  for (const Run& run : runs) ekf += run.ekf_seconds, graph += run.graph_seconds;
  const auto n = static_cast<double>(runs.size());
  fmt::print("\nCPU a run: EKF {:.2f} s, graph {:.2f} s\n", ekf / n, graph / n);
  if (!arguments.csv.empty()) write_csv(arguments.csv, all);
  if (!arguments.picture.empty()) write_picture(arguments.picture, picture_of(all, arguments));
}

}  // namespace
}  // namespace majak::bench

int main(int argc, char** argv) {
  majak::bench::Arguments arguments;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string name = argv[i], value = argv[i + 1];
    if (name == "--runs") arguments.runs = std::max(1, std::atoi(value.c_str()));
    if (name == "--first") arguments.first = std::atoi(value.c_str());
    if (name == "--satellites") arguments.satellites = value != "0";
    if (name == "--case") arguments.name = value;
    if (name == "--csv") arguments.csv = value;
    if (name == "--picture") arguments.picture = value;
  }
  try {
    majak::bench::run_all(arguments);
  } catch (const majak::Error& error) {
    fmt::print(stderr, "run_slam_consistency: {}\n", error.what());
    return 1;
  }
  return 0;
}
