// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/site_view.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "majak/draw/findings.hpp"
#include "majak/eval/ate_rpe.hpp"
#include "majak/eval/trajectory.hpp"
#include "majak/io/view_records.hpp"
#include "majak/map/edits.hpp"
#include "majak/slam/reoptimise.hpp"

namespace majak::draw {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const Pose2& p) { return {p.x, p.y, p.theta}; }

/// Where the mountings of a log change all the time, only so many are told apart.
constexpr std::size_t kMostLasers = 256;

/// A path of its own frame, laid onto the map where it begins.
std::optional<Pose2> laid(const PosedScan& first, const std::optional<Pose2>& T_own_first,
                          const std::optional<Pose2>& T_own_robot) {
  if (!T_own_first || !T_own_robot) return std::nullopt;
  return first.estimate.T_map_robot * between(*T_own_first, *T_own_robot);
}

}  // namespace

std::size_t laser_number(std::vector<Pose2>& lasers, const Pose2& T_robot_laser) {
  const auto at = std::find(lasers.begin(), lasers.end(), T_robot_laser);
  if (at != lasers.end()) return static_cast<std::size_t>(at - lasers.begin());
  if (lasers.size() == kMostLasers) return kMostLasers - 1;
  lasers.push_back(T_robot_laser);
  return lasers.size() - 1;
}

std::string view_run(const RunTold& run) {
  Json lasers = Json::array(), skipped = Json::array();
  for (std::size_t i = 0; i < run.lasers.size(); ++i)
    lasers.push_back({{"frame", "laser" + std::to_string(i)}, {"pose", json_of(run.lasers[i])}});
  for (const auto& [what, entry] : run.report.entries())
    skipped.push_back({{"what", what}, {"count", entry.count}, {"first_line", entry.first_line}});
  const Json told{{"name", run.name},
                  {"state", run.state},
                  {"scans", run.scans},
                  {"begin", std::to_string(run.begin)},
                  {"end", std::to_string(run.end)},
                  {"lasers", lasers},
                  {"version", run.version},
                  {"may", run.may},
                  {"findings", run.findings},
                  {"report", skipped},
                  {"generation", run.generation}};
  return io::view_json(io::ViewTopic::run,
                       told.dump(-1, ' ', false, Json::error_handler_t::replace));
}

SiteView::SiteView(std::shared_ptr<const Site> site, SiteViewOptions options)
    : site_(std::move(site)), options_(std::move(options)) {
  std::vector<std::size_t> between_keys;
  for (std::size_t i = 0; i < site_->scans.size(); ++i) {
    const PosedScan& posed = site_->scans[i];
    laser_of_.push_back(
        static_cast<std::uint32_t>(laser_number(lasers_, posed.scan.T_robot_laser)));
    (posed.key ? scans_ : between_keys).push_back(i);
  }
  if (!options_.keys_only) scans_.insert(scans_.end(), between_keys.begin(), between_keys.end());
  if (scans_.size() <= options_.most_scans) return;
  for (std::size_t i = 0; i < options_.most_scans; ++i)
    scans_[i] = scans_[i * scans_.size() / options_.most_scans];
  scans_.resize(options_.most_scans);
}

std::string SiteView::run() const {
  const Site& site = *site_;
  return view_run({site.source_name, options_.state, site.scans.size(),
                   site.scans.front().scan.time, site.scans.back().scan.time, lasers_,
                   options_.version, options_.may, odometry_in_words(site), site.report,
                   options_.generation});
}

std::string SiteView::graph() const { return io::view_graph(*site_); }

std::string SiteView::closures() const {
  Json list = Json::array();
  for (const Constraint& c : site_->constraints) {
    if (c.kind != ConstraintKind::closure) continue;
    const PosedScan &from = site_->scans[c.from], &to = site_->scans[c.to];
    const Pose2 moved =
        between(between(from.T_map_robot_front_end, to.T_map_robot_front_end), c.T_from_to);
    list.push_back({{"from", c.from},
                    {"to", c.to},
                    {"measured", json_of(c.T_from_to)},
                    {"score", c.score},
                    {"overlap", c.overlap},
                    {"chi2", c.chi2},
                    {"enabled", c.enabled},
                    {"by_hand", slam::switched_off(*site_, c.from, c.to)},
                    {"effect_m", moved.translation().norm()},
                    {"effect_rad", std::abs(moved.theta)}});
  }
  return io::view_json(io::ViewTopic::closures, list.dump());
}

std::string SiteView::edits(bool can_redo, bool kept) const {
  Json list = Json::array();
  for (const Edit& edit : site_->edits) {
    Json points = Json::array();
    for (const Vec2& p : map::points_in_map(*site_, edit)) points.push_back({p.x(), p.y()});
    Json told{{"id", edit.id}, {"kind", name_of(edit.kind)}};
    if (!points.empty()) told["points"] = points;
    if (edit.kind == EditKind::turn) told["radians"] = edit.radians;
    if (edit.kind == EditKind::closure_off) told["from"] = edit.from, told["to"] = edit.to;
    list.push_back(std::move(told));
  }
  const Json edits{{"edits", list},
                   {"can_undo", !site_->edits.empty()},
                   {"can_redo", can_redo},
                   {"saved", kept}};
  return io::view_json(io::ViewTopic::edits, edits.dump());
}

std::string SiteView::truth() const {
  eval::Trajectory estimated;
  for (const PosedScan& s : site_->scans)
    estimated.push_back({s.scan.time, s.estimate.T_map_robot});
  const eval::Trajectory reference = eval::truth_of(site_->truth);
  const auto pairs = eval::associate(estimated, reference).pairs;
  if (pairs.empty()) return {};
  const Pose2 T_map_reference = eval::align(pairs).inverse();
  io::StampedPoses path;
  for (const eval::StampedPose& p : reference) {
    path.stamps.push_back(p.time);
    path.poses.push_back(T_map_reference * p.pose);
  }
  return io::view_truth(path);
}

std::string SiteView::estimates() const {
  const PosedScan& first = site_->scans.front();
  std::string records;
  io::ViewedPose view;
  for (std::size_t i = 0; i < site_->scans.size(); ++i) {
    const PosedScan& posed = site_->scans[i];
    view.scan = i;
    view.is_key = posed.key;
    if (posed.key) view.key = i;
    view.estimate = posed.estimate;
    view.estimate.time = posed.scan.time;
    view.match_score = posed.match_score;
    view.T_map_odometry = laid(first, first.T_odom_robot, posed.T_odom_robot);
    view.T_map_front_end = laid(first, first.T_map_robot_front_end, posed.T_map_robot_front_end);
    if (posed.key || !options_.keys_only) records += io::view_estimate(view);
  }
  return records;
}

std::string SiteView::scan_number(std::size_t number) const {
  return io::view_scan(number, site_->scans[number].scan, laser_of_[number]);
}

std::string view_stream(const SiteView& view, const map::OccupancyGrid& grid) {
  std::string stream = io::view_head() + view.run() + io::view_map(grid) + view.estimates() +
                       view.graph() + view.closures() + view.edits(false, true) + view.truth();
  for (std::size_t i = 0; i < view.scans(); ++i) stream += view.scan(i);
  return stream;
}

}  // namespace majak::draw
