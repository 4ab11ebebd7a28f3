// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/site_view.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "majak/draw/findings.hpp"
#include "majak/eval/ate_rpe.hpp"
#include "majak/eval/trajectory.hpp"
#include "majak/io/view_records.hpp"

namespace majak::draw {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const Pose2& p) { return {p.x, p.y, p.theta}; }

/// Where the mountings of a log change all the time, only so many are told apart.
constexpr std::size_t kMostLasers = 256;

std::size_t find_or_add(std::vector<Pose2>& lasers, const Pose2& wanted) {
  const auto at = std::find(lasers.begin(), lasers.end(), wanted);
  if (at != lasers.end()) return static_cast<std::size_t>(at - lasers.begin());
  if (lasers.size() == kMostLasers) return kMostLasers - 1;
  lasers.push_back(wanted);
  return lasers.size() - 1;
}

/// A path of its own frame, laid onto the map where it begins.
std::optional<Pose2> laid(const PosedScan& first, const std::optional<Pose2>& T_own_first,
                          const std::optional<Pose2>& T_own_robot) {
  if (!T_own_first || !T_own_robot) return std::nullopt;
  return first.estimate.T_map_robot * between(*T_own_first, *T_own_robot);
}

std::string truth(const Site& site) {
  eval::Trajectory estimated;
  for (const PosedScan& s : site.scans) estimated.push_back({s.scan.time, s.estimate.T_map_robot});
  const eval::Trajectory reference = eval::truth_of(site.truth);
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

}  // namespace

SiteView::SiteView(std::shared_ptr<const Site> site, SiteViewOptions options)
    : site_(std::move(site)), options_(std::move(options)) {
  const std::vector<PosedScan>& scans = site_->scans;
  std::vector<std::size_t> between_keys;
  std::uint32_t key = 0;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (scans[i].key) key = static_cast<std::uint32_t>(i);
    key_of_.push_back(key);
    laser_of_.push_back(
        static_cast<std::uint32_t>(find_or_add(lasers_, scans[i].scan.T_robot_laser)));
    if (scans[i].key || !options_.keys_only) estimates_.push_back(i);
    (scans[i].key ? scans_ : between_keys).push_back(i);
  }
  if (!options_.keys_only) scans_.insert(scans_.end(), between_keys.begin(), between_keys.end());
}

std::vector<std::string> SiteView::head() const {
  std::vector<std::string> records{run(), io::view_graph(*site_), closures()};
  if (std::string path = truth(*site_); !path.empty()) records.push_back(std::move(path));
  return records;
}

std::string SiteView::run() const {
  const Site& site = *site_;
  Json lasers = Json::array(), skipped = Json::array();
  for (std::size_t i = 0; i < lasers_.size(); ++i)
    lasers.push_back({{"frame", "laser" + std::to_string(i)}, {"pose", json_of(lasers_[i])}});
  for (const auto& [what, entry] : site.report.entries())
    skipped.push_back({{"what", what}, {"count", entry.count}, {"first_line", entry.first_line}});
  const Json run{{"name", site.source_name},
                 {"state", options_.state},
                 {"scans", site.scans.size()},
                 {"begin", std::to_string(site.scans.front().scan.time)},
                 {"end", std::to_string(site.scans.back().scan.time)},
                 {"lasers", lasers},
                 {"version", options_.version},
                 {"may", options_.may},
                 {"findings", odometry_in_words(site)},
                 {"report", skipped},
                 {"generation", options_.generation}};
  return io::view_json(io::ViewTopic::run,
                       run.dump(-1, ' ', false, Json::error_handler_t::replace));
}

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
                    {"effect_m", moved.translation().norm()},
                    {"effect_rad", std::abs(moved.theta)}});
  }
  return io::view_json(io::ViewTopic::closures, list.dump());
}

std::string SiteView::estimate(std::size_t scan) const {
  const PosedScan &posed = site_->scans[scan], &first = site_->scans.front();
  io::ViewedPose view;
  view.scan = scan;
  view.key = key_of_[scan];
  view.is_key = posed.key;
  view.estimate = posed.estimate;
  view.estimate.time = posed.scan.time;
  view.match_score = posed.match_score;
  view.T_map_odometry = laid(first, first.T_odom_robot, posed.T_odom_robot);
  view.T_map_front_end = laid(first, first.T_map_robot_front_end, posed.T_map_robot_front_end);
  return io::view_estimate(view);
}

std::string SiteView::record(std::size_t i) const {
  if (i < estimates_.size()) return estimate(estimates_[i]);
  const std::size_t scan = scans_[i - estimates_.size()];
  return io::view_scan(scan, site_->scans[scan].scan, laser_of_[scan]);
}

}  // namespace majak::draw
