// SPDX-License-Identifier: Apache-2.0
#include "majak/localize/beacons.hpp"

#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "majak/beacon/resection.hpp"

namespace majak::localize {
namespace {

class Beacons {
 public:
  Beacons(const beacon::BeaconMap& map, const BeaconsOptions& options)
      : map_(map), options_(options) {}

  std::optional<Estimate> add(const Event& event) {
    if (const auto* scan = std::get_if<Scan>(&event)) {
      if (scan->intensities.empty()) return std::nullopt;
      const auto seen = beacon::sightings(*scan, map_, prior(scan->time), options_.reflectors);
      return locate(scan->time, seen);
    }
    const auto* sighting = std::get_if<BeaconSighting>(&event);
    if (sighting == nullptr) return std::nullopt;
    // Sightings of one time belong together; the first of another time closes them.
    std::optional<Estimate> estimate;
    if (!together_.empty() && together_.front().time != sighting->time) estimate = close();
    together_.push_back(*sighting);
    return estimate;
  }

  Localization finish() {
    if (!together_.empty()) close();
    return std::move(result_);
  }

 private:
  std::optional<Estimate> close() {
    const auto seen = std::exchange(together_, {});
    return locate(seen.front().time, seen);
  }

  /// Where the last fix says the robot may be by now.
  std::optional<beacon::PosePrior> prior(Time time) const {
    if (result_.estimates.empty()) return std::nullopt;
    const Estimate& last = result_.estimates.back();
    const double passed = std::abs(to_seconds(time - last.time));
    if (passed > options_.memory) return std::nullopt;
    const double way = options_.speed * passed, turn = options_.turn_rate * passed;
    beacon::PosePrior prior{last.T_map_robot, last.covariance};
    prior.covariance.diagonal() += Vec3(way * way, way * way, turn * turn);
    return prior;
  }

  std::optional<Estimate> locate(Time time, const std::vector<BeaconSighting>& seen) {
    const beacon::PoseFix fix = beacon::resect(seen, map_, options_.fix);
    for (int i = 0; i < fix.unknown; ++i) result_.report.count("sightings of unknown beacons");
    for (int i = 0; i < fix.gross; ++i) result_.report.count("gross errors left out");
    if (fix.problem != beacon::FixProblem::none) {
      result_.report.count(std::string("no fix: ") + beacon::describe(fix.problem));
      return std::nullopt;
    }
    Estimate estimate{.time = time, .T_map_robot = fix.T_map_robot, .covariance = fix.covariance};
    result_.estimates.push_back(estimate);
    result_.innovations.push_back({time, "beacon", fix.chi2, fix.dof, true});
    return estimate;
  }

  beacon::BeaconMap map_;
  BeaconsOptions options_;
  std::vector<BeaconSighting> together_;
  Localization result_;
};

}  // namespace

Localizer beacons(const beacon::BeaconMap& map, const BeaconsOptions& options) {
  const auto method = std::make_shared<Beacons>(map, options);
  return {[method](const Event& event) { return method->add(event); },
          [method] { return method->finish(); }};
}

}  // namespace majak::localize
