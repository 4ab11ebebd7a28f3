// SPDX-License-Identifier: Apache-2.0
#include "majak/io/summary.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "majak/map/edits.hpp"

namespace majak::io {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kSlips = 20;

/// Reorders its argument.
double median(std::vector<double>& values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void add_scans(const Site& site, Figures& f) {
  Time earliest = 0, latest = 0;
  double score = 0;
  for (const PosedScan& posed : site.scans) {
    if (f.scans++ == 0) earliest = latest = posed.scan.time;
    earliest = std::min(earliest, posed.scan.time);
    latest = std::max(latest, posed.scan.time);
    f.key_scans += posed.key;
    f.ok += posed.estimate.health == Health::ok;
    f.degraded += posed.estimate.health == Health::degraded;
    f.lost += posed.estimate.health == Health::lost;
    score += static_cast<double>(posed.match_score);
    const double shift =
        (posed.estimate.T_map_robot.translation() - posed.T_map_robot_front_end.translation())
            .norm();
    f.front_end_shift_max_m = std::max(f.front_end_shift_max_m, shift);
  }
  f.duration_s = to_seconds(latest - earliest);
  if (f.scans > 0) f.match_score_mean = score / static_cast<double>(f.scans);
}

/// Along the key scans, because the noise of every scan would lengthen the path.
void add_path(const Site& site, Figures& f) {
  const Pose2* last = nullptr;
  for (const PosedScan& posed : site.scans) {
    if (f.key_scans > 0 && !posed.key) continue;
    const Pose2& pose = posed.estimate.T_map_robot;
    if (last) {
      f.path_m += (pose.translation() - last->translation()).norm();
      f.turned_rad += std::abs(angle_diff(pose.theta, last->theta));
    }
    last = &pose;
  }
}

void add_sigmas(const Site& site, Figures& f) {
  std::vector<double> position, heading;
  for (const PosedScan& posed : site.scans) {
    const double variance = posed.estimate.covariance(2, 2);
    position.push_back(least_known(posed.estimate.covariance).sigma);
    heading.push_back(variance > 0 && std::isfinite(variance) ? std::sqrt(variance) : 0.0);
  }
  if (position.empty()) return;
  f.position_sigma_max_m = *std::max_element(position.begin(), position.end());
  f.heading_sigma_max_rad = *std::max_element(heading.begin(), heading.end());
  f.position_sigma_median_m = median(position);
  f.heading_sigma_median_rad = median(heading);
}

Json learnt_json(const Learnt& learnt) {
  return {{"value", learnt.value}, {"sigma", learnt.sigma}, {"used", learnt.used}};
}

Json odometry_json(const Site& site) {
  const OdometryFindings& o = site.odometry;
  return {{"used", site.used_odometry},
          {"lag_s", learnt_json(o.lag_s)},
          {"translation_scale", learnt_json(o.translation_scale)},
          {"rotation_scale", learnt_json(o.rotation_scale)},
          {"laser_x_m", learnt_json(o.laser_x_m)},
          {"laser_y_m", learnt_json(o.laser_y_m)},
          {"laser_theta_rad", learnt_json(o.laser_theta_rad)},
          {"reversed_records", o.reversed_records},
          {"jumps", o.jumps},
          {"translation_noise_m_per_sqrt_m", o.translation_noise},
          {"rotation_noise_rad_per_sqrt_rad", o.rotation_noise}};
}

Json skipped_json(const Report& report) {
  Json list = Json::array();
  for (const auto& [what, entry] : report.entries()) {
    list.push_back({{"what", what}, {"count", entry.count}, {"first_line", entry.first_line}});
  }
  return list;
}

Json slips_json(const std::vector<motion::SlipEvent>& slips) {
  Json list = Json::array();
  for (std::size_t i = 0; i < std::min(slips.size(), kSlips); ++i) {
    const motion::SlipEvent& e = slips[i];
    list.push_back({{"kind", motion::name_of(e.kind)},
                    {"begin_s", to_seconds(e.begin)},
                    {"end_s", to_seconds(e.end)},
                    {"way_m", e.way},
                    {"turn_deg", degrees(e.turn)}});
  }
  return {{"count", slips.size()}, {"biggest", list}};
}

Json edits_json(const Site& site) {
  Json list = Json::array();
  for (const Edit& edit : site.edits) {
    Json json = {{"id", edit.id}, {"kind", name_of(edit.kind)}};
    if (edit.kind == EditKind::turn) json["radians"] = edit.radians;
    if (edit.kind == EditKind::closure_off) json["from"] = edit.from, json["to"] = edit.to;
    for (const Vec2& p : map::points_in_map(site, edit)) json["points"].push_back({p.x(), p.y()});
    list.push_back(json);
  }
  return list;
}

Json named_json(const std::vector<NamedFigure>& figures) {
  Json object = Json::object();
  for (const auto& [name, value] : figures) object[name] = value;
  return object;
}

Json figures_json(const Figures& f) {
  return {{"scans", f.scans},
          {"key_scans", f.key_scans},
          {"scans_ok", f.ok},
          {"scans_degraded", f.degraded},
          {"scans_lost", f.lost},
          {"duration_s", f.duration_s},
          {"path_m", f.path_m},
          {"turned_rad", f.turned_rad},
          {"matches", f.matches},
          {"closures", f.closures},
          {"closures_rejected", f.closures_rejected},
          {"match_score_mean", f.match_score_mean},
          {"position_sigma_median_m", f.position_sigma_median_m},
          {"position_sigma_max_m", f.position_sigma_max_m},
          {"heading_sigma_median_rad", f.heading_sigma_median_rad},
          {"heading_sigma_max_rad", f.heading_sigma_max_rad},
          {"front_end_shift_max_m", f.front_end_shift_max_m},
          {"map_width_m", f.width_m},
          {"map_height_m", f.height_m},
          {"known_area_m2", f.known_area_m2},
          {"grid_resolution_m", f.grid_resolution_m},
          {"grid_scans_drawn", f.scans_drawn},
          {"records_skipped", f.skipped}};
}

}  // namespace

Figures figures_of(const Site& site, const map::OccupancyGrid& grid) {
  Figures f;
  add_scans(site, f);
  add_path(site, f);
  add_sigmas(site, f);
  for (const Constraint& c : site.constraints) {
    const bool closure = c.kind == ConstraintKind::closure;
    f.closures += closure && c.enabled;
    f.closures_rejected += closure && !c.enabled;
    f.matches += c.kind == ConstraintKind::match;
  }
  for (const auto& [what, entry] : site.report.entries()) f.skipped += entry.count;
  const map::CellBox box = grid.bounds();
  f.width_m = box.width * grid.resolution();
  f.height_m = box.height * grid.resolution();
  f.known_area_m2 = grid.known_area();
  f.grid_resolution_m = grid.resolution();
  f.scans_drawn = grid.scans_drawn();
  return f;
}

std::string summary_json(const Site& site, const map::OccupancyGrid& grid,
                         const std::vector<NamedFigure>& extras,
                         const std::vector<NamedFigure>& timing,
                         const std::vector<motion::SlipEvent>& slips) {
  Json summary = {{"log", site.source_name}};
  summary.update(figures_json(figures_of(site, grid)));
  summary["odometry"] = odometry_json(site);
  summary["slips"] = slips_json(slips);
  summary["skipped"] = skipped_json(site.report);
  summary["edits"] = edits_json(site);
  if (!extras.empty()) summary["evaluation"] = named_json(extras);
  if (!timing.empty()) summary["timing"] = named_json(timing);
  // Names from a log may be in any encoding; a wrong byte becomes a replacement character.
  return summary.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace majak::io
