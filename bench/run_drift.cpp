// SPDX-License-Identifier: Apache-2.0
// Does a calibration hold for what comes after? Learnt on the first half of a log, mapped alone;
// dead reckoning over the second half, raw and calibrated, against the relations and against a map
// of the second half alone; and the other way round. "Fitted": scale, scale of turns and unequal
// wheels so that the drift of the half learnt from is smallest. The oracle rows are no calibration:
// the same sought on the half that is measured, so that one figure of it is smallest.
//   run_drift LOG RELATIONS
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/eval/ate_rpe.hpp"
#include "majak/eval/relations.hpp"
#include "majak/io/source.hpp"
#include "majak/localize/dead_reckoning.hpp"
#include "majak/motion/drive_log.hpp"
#include "majak/slam/graph_slam.hpp"

namespace majak::bench {
namespace {

constexpr std::array<double, 2> kDistances{10, 50};  // m
constexpr std::array<const char*, 3> kFigures{"relations", "10 m", "50 m"};
using Figures = std::array<double, kFigures.size()>;  // mean translational errors, m

struct Halves {
  std::vector<Event> first, second;
};

Halves read_halves(const std::string& log) {
  std::vector<Event> events;
  const auto source = io::open_log(log, {});
  while (auto event = source->next()) events.push_back(std::move(*event));
  const auto is_scan = [](const Event& e) { return std::holds_alternative<Scan>(e); };
  auto left = std::count_if(events.begin(), events.end(), is_scan) / 2;
  const auto middle = std::find_if(events.begin(), events.end(),
                                   [&](const Event& e) { return is_scan(e) && left-- == 0; });
  return {{events.begin(), middle}, {middle, events.end()}};
}

Site map_of(const std::vector<Event>& events) {
  slam::GraphSlam slam({}, {2});
  for (const Event& event : events) slam.add(event);
  return slam.finish().site;
}

/// Dead reckoning over one half, measured.
class Half {
 public:
  Half(const std::vector<Event>& events, const Site& site, const std::string& relations) {
    Report report;
    relations_ = eval::read_relations(relations, report);
    for (Event event : events) {
      if (auto* scan = std::get_if<Scan>(&event)) scan->ranges.clear();
      wheels_.push_back(std::move(event));
    }
    T_robot_laser_ = site.scans.front().scan.T_robot_laser;
    for (const PosedScan& s : site.scans)
      laser_.push_back({s.scan.time, s.estimate.T_map_robot * T_robot_laser_});
  }

  /// Drift is that of the laser, wherever it is said to sit.
  Figures measure(const motion::DriveCorrection& correction) const {
    const Pose2 T_robot_laser =
        correction.mounting ? Pose2{correction.laser_x, correction.laser_y, correction.laser_theta}
                            : T_robot_laser_;
    const eval::Trajectory robot = reckon(correction);
    const auto related =
        eval::evaluate_relations_in_both_frames(robot, T_robot_laser, relations_).best();
    Figures out{related.all.translation.mean};
    const eval::TrajectoryIndex index(robot);
    std::vector<eval::PosePair> pairs;
    for (const eval::StampedPose& seen : laser_)
      if (const auto there = index.at(seen.time))
        pairs.push_back({seen.time, there->pose * T_robot_laser, seen.pose, there->exact});
    const auto drift = eval::relative_errors(pairs, {kDistances.begin(), kDistances.end()});
    if (drift.size() < kDistances.size()) throw Error("the second half is shorter than 50 m");
    for (std::size_t k = 0; k < drift.size(); ++k) out[k + 1] = drift[k].translation.mean;
    return out;
  }

 private:
  eval::Trajectory reckon(const motion::DriveCorrection& correction) const {
    motion::CorrectedDrive drive(correction);
    const auto localizer = localize::dead_reckoning({});
    for (Event event : wheels_) {
      drive.apply(event);
      localizer.add(event);
    }
    eval::Trajectory out;
    for (const Estimate& e : localizer.finish().estimates) out.push_back({e.time, e.T_map_robot});
    return out;
  }

  std::vector<eval::Relation> relations_;
  std::vector<Event> wheels_;
  eval::Trajectory laser_;  ///< T_map_laser
  Pose2 T_robot_laser_;     ///< nominal
};

struct Parameter {
  double motion::DriveCorrection::*value;
  double step;
};
constexpr std::array<Parameter, 4> kSought{{{&motion::DriveCorrection::scale, 0.02},
                                            {&motion::DriveCorrection::turn_scale, 0.02},
                                            {&motion::DriveCorrection::turn_per_metre, 0.01},
                                            {&motion::DriveCorrection::way_per_turn, 0.01}}};

/// The correction that makes one figure smallest, by coordinate search with halving steps.
motion::DriveCorrection fitted(const Half& half, motion::DriveCorrection best, std::size_t figure) {
  double least = half.measure(best)[figure];
  for (double part = 1; part > 0.01; part /= 2) {
    for (const Parameter& p : kSought) {
      for (const double sign : {1.0, -1.0}) {
        for (bool better = true; better;) {
          motion::DriveCorrection tried = best;
          tried.*p.value += sign * part * p.step;
          const double found = half.measure(tried)[figure];
          better = found < least;
          if (better) best = tried, least = found;
        }
      }
    }
  }
  return best;
}

void print(const char* name, const Figures& f, const Figures& raw) {
  fmt::print("{:<28}", name);
  for (const double value : f) fmt::print("{:>10.3f} m", value);
  fmt::print("   times less:");
  for (std::size_t k = 0; k < f.size(); ++k) fmt::print("{:>6.2f}", raw[k] / f[k]);
  fmt::print("\n");
}

/// One half of a log, and the map of it alone.
struct Mapped {
  std::vector<Event> events;
  Site site;
};

motion::Calibration learn(const Mapped& half) {
  motion::DriveLog log;
  for (const Event& event : half.events) log.add(event);
  return motion::calibrate_log(log, half.site).calibration;
}

void compare(const char* title, const Mapped& learnt, const Mapped& tested,
             const std::string& relations) {
  const Half half(tested.events, tested.site, relations);
  const Figures raw = half.measure({});
  fmt::print("{:<28}", title);
  for (const char* name : kFigures) fmt::print("{:>12}", name);
  fmt::print("\n");
  print("raw", raw, raw);
  const motion::DriveCorrection found = learn(learnt).correction, same = learn(tested).correction;
  print("calibrated", half.measure(found), raw);
  const Half other(learnt.events, learnt.site, relations);
  print("fitted to drift over 10 m", half.measure(fitted(other, found, 1)), raw);
  print("calibrated by the same half", half.measure(same), raw);
  for (std::size_t k = 0; k < kFigures.size(); ++k)
    print(fmt::format("oracle of {}", kFigures[k]).c_str(), half.measure(fitted(half, same, k)),
          raw);
}

void run(const std::string& log, const std::string& relations) {
  auto [first, second] = read_halves(log);
  const Mapped a{first, map_of(first)}, b{second, map_of(second)};
  fmt::print("{}\n", log);
  compare("first half for the second", a, b, relations);
  compare("second half for the first", b, a, relations);
}

}  // namespace
}  // namespace majak::bench

int main(int argc, char** argv) {
  if (argc != 3) {
    fmt::print(stderr, "run_drift LOG RELATIONS\n");
    return 1;
  }
  try {
    majak::bench::run(argv[1], argv[2]);
  } catch (const majak::Error& error) {
    fmt::print(stderr, "run_drift: {}\n", error.what());
    return 1;
  }
  return 0;
}
