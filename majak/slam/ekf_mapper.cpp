// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/ekf_mapper.hpp"

#include <utility>

namespace majak::slam {

EkfSlamOptions ekf_for_rooms() {
  EkfSlamOptions options;
  options.see_corners = true;
  options.use_gps = false;
  options.near = 25, options.look_around = 8;
  options.wheels.turn_noise = 0.03;  // of two driven wheels, not of a car
  options.turn_offset_sigma = 0.05;  // one of them worn
  options.alike_sigma = 0.06;
  options.least_apart = 0.5;
  options.confirmed = 2, options.stands = 0.3;  // key scans are few
  options.gone = 1000;                          // corners are looked past from many sides
  return options;
}

EkfMapper::EkfMapper(const ScanChainOptions& chain, const EkfSlamOptions& options, Threads threads)
    : threads_(threads), chain_(chain), slam_(options) {}

std::optional<Estimate> EkfMapper::add(Event event) {
  chain_.add(std::move(event));
  return take_scans();
}

std::optional<Estimate> EkfMapper::take_scans() {
  std::optional<Estimate> newest;
  while (const auto step = chain_.next()) {
    T_odom_robot_ = T_odom_robot_ * step->T_previous_robot;
    if (step->key) {
      KeyScan& key = chain_.keys().back();
      Scan scan = chain_.site().scans[key.scan].scan;
      scan.T_odom_robot = T_odom_robot_;
      const auto estimate = slam_.add(scan);
      key.T_map_robot = estimate->T_map_robot;
      covariances_.push_back(estimate->covariance);
    }
    newest = chain_.settle();
  }
  return newest;
}

Mapping EkfMapper::finish() {
  chain_.end();
  take_scans();
  require_keys(chain_.keys());
  chain_.hang_all(threads_);
  std::vector<PosedScan>& scans = chain_.site().scans;
  for (std::size_t i = 0; i < scans.size(); ++i)
    scans[i].estimate.covariance = covariances_[chain_.hang(i).key];
  const LandmarkMap map = slam_.finish();
  for (const auto& [what, entry] : map.localization.report.entries())
    chain_.site().report.add(what, entry);
  Mapping mapping;
  mapping.posterior = true;
  mapping.landmarks = map.landmarks.size();
  const std::size_t state = filter::LandmarkFilter::kBody + 2 * mapping.landmarks;
  mapping.belief_bytes = state * (state + 1) * sizeof(double);
  mapping.site = chain_.finish();
  return mapping;
}

}  // namespace majak::slam
