// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/reoptimise.hpp"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "majak/core/error.hpp"

namespace majak::slam {
namespace {

constexpr std::size_t kNoKey = std::numeric_limits<std::size_t>::max();

// Of each scan: its number among the key scans.
std::vector<std::size_t> key_numbers(const Site& site) {
  std::vector<std::size_t> numbers(site.scans.size(), kNoKey);
  std::size_t keys = 0;
  for (std::size_t i = 0; i < site.scans.size(); ++i)
    if (site.scans[i].key) numbers[i] = keys++;
  return numbers;
}

void require_links(const Site& site) {
  const auto keys = static_cast<std::size_t>(std::count_if(
      site.scans.begin(), site.scans.end(), [](const PosedScan& s) { return s.key; }));
  bool whole = keys > 0 && site.key_links.size() == keys;
  for (std::size_t k = 0; whole && k < keys; ++k) whole = site.key_links[k].local_map <= k;
  if (!whole)
    throw Error(
        "this run does not say how its key scans hang together, so that its closures cannot be "
        "switched; map its log again with graph-slam");
}

// The key scans as loop closing found them: in the front end's frame.
KeyScans key_scans_of(const Site& site, const std::vector<std::size_t>& numbers,
                      const match::ScanPointsOptions& options, Threads threads) {
  KeyScans keys(site.key_links.size());
  for (std::size_t i = 0; i < site.scans.size(); ++i) {
    if (numbers[i] == kNoKey) continue;
    KeyScan& key = keys[numbers[i]];
    const KeyLink& link = site.key_links[numbers[i]];
    key.scan = i;
    key.T_robot_laser = site.scans[i].scan.T_robot_laser;
    key.T_front_robot = site.scans[i].T_map_robot_front_end;
    key.local_map = link.local_map;
    key.weak_step = link.weak_step;
    key.match_information = link.match_information;
  }
  for (const Constraint& c : site.constraints) {
    const std::size_t k = numbers[c.to];
    if (c.kind != ConstraintKind::odometry || k == kNoKey) continue;
    keys[k].T_previous_predicted = c.T_from_to;
    keys[k].motion_information = c.information;
  }
  keys[0].T_map_robot = keys[0].T_front_robot;
  for (std::size_t k = 1; k < keys.size(); ++k)
    keys[k].T_map_robot =
        keys[k - 1].T_map_robot * between(keys[k - 1].T_front_robot, keys[k].T_front_robot);
  constexpr std::size_t kChunk = 64;
  parallel_for(threads, (keys.size() + kChunk - 1) / kChunk, [&](std::size_t chunk) {
    match::BeamDirections directions;
    for (std::size_t k = chunk * kChunk; k < std::min(keys.size(), (chunk + 1) * kChunk); ++k)
      keys[k].points = match::scan_points(site.scans[keys[k].scan].scan, options, true, directions);
  });
  return keys;
}

std::vector<Closure> closures_of(const Site& site, const std::vector<std::size_t>& numbers) {
  std::vector<Closure> closures;
  for (const Constraint& c : site.constraints) {
    const std::size_t from = numbers[c.from], to = numbers[c.to];
    if (c.kind != ConstraintKind::closure || from == kNoKey || to == kNoKey) continue;
    Closure closure;
    closure.from_key = from, closure.to_key = to;
    closure.T_from_to = c.T_from_to;
    closure.information = c.information;
    closure.agreement = c.score;
    closure.overlap = c.overlap;
    closures.push_back(closure);
  }
  return closures;
}

}  // namespace

bool switched_off(const Site& site, std::size_t from, std::size_t to) {
  return std::any_of(site.edits.begin(), site.edits.end(), [&](const Edit& edit) {
    return edit.kind == EditKind::closure_off && edit.from == from && edit.to == to;
  });
}

Site reoptimised(Site site, const GraphSlamOptions& options, Threads threads) {
  require_links(site);
  const std::vector<std::size_t> numbers = key_numbers(site);
  KeyScans keys = key_scans_of(site, numbers, options.chain.front_end.points, threads);
  LoopClosingOptions loop_options = options.loops;
  for (const Edit& edit : site.edits)
    if (edit.kind == EditKind::closure_off)
      loop_options.switched_off.emplace_back(edit.from, edit.to);
  LoopCloser loops(loop_options);
  if (options.close_loops) loops.replay(keys, closures_of(site, numbers));
  site.constraints.clear();
  site.key_links.clear();
  for (PosedScan& posed : site.scans) {
    posed.estimate.health = Health::ok;
    posed.estimate.weak_direction = Vec2::Zero();
  }
  finish_site(site, keys, loops, options, threads);
  return site;
}

}  // namespace majak::slam
