// SPDX-License-Identifier: Apache-2.0
#include "majak/methods/methods.hpp"

#include <algorithm>
#include <string>

#include "majak/core/error.hpp"
#include "majak/methods/kalman_with_laser.hpp"

namespace majak::methods {
namespace {

localize::KalmanOptions kalman_options(const LocalizeOptions& o) {
  localize::KalmanOptions options = o.kalman;
  options.reflectors = o.reflectors;
  if (o.drive.wheelbase > 0) options.wheelbase = o.drive.wheelbase;
  return options;
}

localize::PlacePtr place_of(const LocalizeOptions& o, const char* method) {
  if (!o.place) throw Error(std::string(method) + " needs --map MAP");
  return o.place;
}

slam::EkfSlamOptions ekf_options(const LocalizeOptions& o) {
  slam::EkfSlamOptions options = o.ekf_slam;
  if (o.drive.wheelbase > 0) options.wheelbase = o.drive.wheelbase;
  return options;
}

const Method kMethods[] = {
    {"dead-reckoning", "dead reckoning, p. 15", "odometry, or wheel speed and steering",
     "trajectory with growing covariance",
     [](const LocalizeOptions& o) {
       localize::DeadReckoningOptions options = o.dead_reckoning;
       if (o.drive.wheelbase > 0) options.wheelbase = o.drive.wheelbase;
       return localize::dead_reckoning(options, o.start);
     }},
    {"beacons", "active beacons: trilateration and triangulation, p. 19",
     "--beacons FILE, and scans with intensities or sightings", "a pose for each moment by itself",
     [](const LocalizeOptions& o) {
       localize::BeaconsOptions options;
       options.reflectors = o.reflectors;
       return localize::beacons(o.beacons, options);
     },
     false, false},
    {"kalman", "Kalman filter, p. 21",
     "odometry, or wheel speed and steering; satellite fixes or --beacons FILE to correct them",
     "smoothed trajectory with covariance, what the wheels count wrongly",
     [](const LocalizeOptions& o) {
       const localize::KalmanOptions options = kalman_options(o);
       return localize::kalman(options, o.start, o.beacons);
     }},
    {"kalman-laser", "Kalman filter, p. 21", "the same, and scans",
     "the same; matched scans count the motion beside the wheels",
     [](const LocalizeOptions& o) {
       const KalmanWithLaserOptions options{kalman_options(o), {}};
       return kalman_with_laser(options, o.start, o.beacons);
     }},
    {"global", "global methods, p. 21", "--map MAP, scans; odometry helps",
     "the place found by itself, then tracked, found again when lost; hypotheses",
     [](const LocalizeOptions& o) {
       return localize::find_and_track(place_of(o, "global"), o.global, o.tracking, o.find,
                                       o.plausibility);
     },
     true, false},
    {"tracking", "local methods, p. 21", "--map MAP, --start, scans; odometry helps",
     "trajectory with covariance",
     [](const LocalizeOptions& o) {
       return localize::tracking(place_of(o, "tracking"), o.tracking, o.start, o.plausibility,
                                 o.clock);
     },
     true, true},
    {"monte-carlo", "Monte Carlo localization, p. 22", "--map MAP, scans; odometry helps",
     "trajectory with covariance, from no start at all",
     [](const LocalizeOptions& o) {
       return localize::monte_carlo(place_of(o, "monte-carlo"), o.monte_carlo, o.start,
                                    o.plausibility);
     },
     true, false},
    {"markov", "Markov localization, p. 24", "--map MAP, scans; odometry helps",
     "trajectory with covariance, from anywhere and without a start",
     [](const LocalizeOptions& o) {
       return localize::markov(place_of(o, "markov"), o.markov, o.plausibility, o.clock);
     },
     true, false},
    {"ekf-slam", "simultaneous localization and mapping, p. 34",
     "scans that show trunks or poles; odometry, or wheel speed and steering; satellite fixes help",
     "trajectory with covariance as known at each time, what the wheels count wrongly",
     [](const LocalizeOptions& o) { return slam::ekf_slam(ekf_options(o), o.start); }},
    {"landmark-graph", "simultaneous localization and mapping, p. 34", "the same",
     "the same, all poses at once at the end",
     [](const LocalizeOptions& o) {
       return slam::landmark_graph(ekf_options(o), o.landmark_graph, o.start);
     }},
};

}  // namespace

void describe(OptionFields& fields, LocalizeOptions& o) {
  fields.add("start.x", o.start.x, {"m", "where the robot is at first"});
  fields.add("start.y", o.start.y, {"m", "where the robot is at first"});
  fields.add("start.theta", o.start.theta, {"rad", "its heading, counter-clockwise from x"});
  localize::describe(fields, o.dead_reckoning);
  localize::describe(fields, o.kalman);
  localize::describe(fields, o.tracking);
  localize::describe(fields, o.global);
  localize::describe(fields, o.find);
  localize::describe(fields, o.monte_carlo);
  localize::describe(fields, o.markov);
  slam::describe(fields, o.ekf_slam);
  slam::describe(fields, o.landmark_graph);
  localize::describe(fields, o.plausibility);
  fields.add("reflectors.threshold", o.reflectors.threshold,
             {"raw units", "least intensity of a reflector; 0: from the scan itself", 0, 1e9});
  fields.add("reflectors.contrast", o.reflectors.contrast,
             {"1", "times as bright as others at that range", 1, 1e6});
  fields.add("reflectors.diameter", o.reflectors.diameter, {"m", "of round ones; 0: flat", 0, 2});
  motion::describe(fields, o.drive);
}

std::span<const Method> methods() { return kMethods; }

const Method& method(std::string_view name) {
  const auto found = std::find_if(std::begin(kMethods), std::end(kMethods),
                                  [&](const Method& m) { return m.name == name; });
  if (found != std::end(kMethods)) return *found;
  std::string names;
  for (const Method& m : kMethods) names += std::string(names.empty() ? "" : ", ") + m.name;
  throw Error("no method " + std::string(name) + "; there are: " + names);
}

}  // namespace majak::methods
