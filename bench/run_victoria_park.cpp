// SPDX-License-Identifier: Apache-2.0
// Wheels and satellites on the Victoria Park set, scored on fixes that were held out in whole
// bursts: nothing is aligned afterwards. Folds: every other burst is held out, the first and the
// last one never; one out: each burst by itself. Scored twice: on all fixes, and on those that data
// alone do not cast doubt on (steps as long as the wheels say for five fixes and more, not the last
// before an outage).
//   run_victoria_park FOLDER [kalman.x=y]... [--one-out]
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "bench/victoria_park.hpp"
#include "majak/core/error.hpp"
#include "majak/eval/trajectory.hpp"
#include "majak/io/options_file.hpp"
#include "majak/localize/kalman.hpp"

namespace {

using namespace majak;

using bench::ParkData;

struct Scored {
  std::vector<double> errors;  // of all held-out fixes
  std::vector<double> sound;   // of those that data alone do not cast doubt on
  double nis = 0;
  double largest = 0;  // of the online estimates, against the final ones
};

double value_of(const localize::Localization& run, const std::string& name) {
  for (const auto& v : run.learnt)
    if (v.name == name) return v.value;
  return 0;
}

Scored score(const ParkData& data, const std::set<int>& held,
             const localize::KalmanOptions& options, bool verbose) {
  localize::Kalman kalman(options);
  std::size_t i = 0;
  std::map<Time, Pose2> online;
  for (const Event& event : data.events) {
    if (std::holds_alternative<GpsFix>(event) && held.contains(data.burst[i++])) continue;
    if (const auto e = kalman.add(event)) online[e->time] = e->T_map_robot;
  }
  const auto run = kalman.finish();
  eval::Trajectory path;
  Scored s;
  for (const Estimate& e : run.estimates) {
    path.push_back({e.time, e.T_map_robot});
    const auto o = online.find(e.time);
    if (o != online.end())
      s.largest =
          std::max(s.largest, (o->second.translation() - e.T_map_robot.translation()).norm());
  }
  const eval::TrajectoryIndex index(path);
  const Vec2 antenna(value_of(run, "antenna ahead"), value_of(run, "antenna to the left"));
  std::map<int, std::vector<double>> by_burst;
  for (std::size_t k = 0; k < data.fixes.size(); ++k) {
    if (!held.contains(data.burst[k])) continue;
    const auto pose = index.at(data.fixes[k].time);
    if (!pose) continue;
    const Vec2 error = pose->pose * antenna - Vec2(data.fixes[k].east, data.fixes[k].north);
    s.errors.push_back(error.norm());
    if (data.sound[k]) s.sound.push_back(error.norm());
    by_burst[data.burst[k]].push_back(error.norm());
  }
  std::size_t used = 0;
  for (const auto& n : run.innovations) s.nis += n.nis, ++used;
  s.nis /= static_cast<double>(std::max<std::size_t>(used, 1));
  if (verbose) {
    for (const auto& v : run.learnt)
      fmt::print("   {} {:.4f} +- {:.4f} {}\n", v.name, v.value, v.sigma, v.unit);
    for (auto& [b, e] : by_burst) {
      double sum = 0;
      for (double x : e) sum += x;
      fmt::print("   {}:{:.2f}", b, sum / static_cast<double>(e.size()));
    }
    fmt::print("\n");
  }
  return s;
}

void print(const std::string& name, const Scored& s) {
  bench::tell_errors(name, "all", s.errors);
  bench::tell_errors(name, "sound", s.sound);
  fmt::print("         NIS {:.2f}  online off by {:.1f}\n", s.nis, s.largest);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc < 2) throw Error("run_victoria_park FOLDER [NAME=VALUE ...] [--one-out]");
    localize::KalmanOptions options;
    OptionFields fields;
    localize::describe(fields, options);
    bool one_out = false;
    const ParkData data(argv[1]);
    for (int i = 2; i < argc; ++i) {
      if (std::string(argv[i]) == "--one-out")
        one_out = true;
      else
        io::apply_option(fields, argv[i]);
    }
    for (const int fold : {0, 1}) {
      print(fmt::format("fold {}", fold), score(data, data.held_out(fold), options, true));
    }
    if (one_out) {
      Scored all;
      for (int b = 1; b + 1 < data.bursts; ++b) {
        const Scored s = score(data, {b}, options, false);
        double sum = 0;
        for (double e : s.errors) sum += e;
        fmt::print("   {}:{:.2f}", b, sum / static_cast<double>(s.errors.size()));
        all.errors.insert(all.errors.end(), s.errors.begin(), s.errors.end());
        all.sound.insert(all.sound.end(), s.sound.begin(), s.sound.end());
        all.nis += s.nis / (data.bursts - 2);
        all.largest = std::max(all.largest, s.largest);
      }
      print("one out", all);
    }
  } catch (const Error& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  }
}
