// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/mapping_trial.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "majak/core/error.hpp"
#include "majak/eval/ate_rpe.hpp"
#include "majak/eval/consistency.hpp"
#include "majak/eval/true_walls.hpp"
#include "majak/match/scan_points.hpp"

namespace majak::eval {
namespace {

constexpr double kSeenAgain = 1.0;    // m between two places that see the same
constexpr double kWay = 15;           // m driven between them, at least
constexpr double kOnEachOther = 0.2;  // m off, within which they lie on each other

/// Work over the events of a log, by fifths.
class Meter {
 public:
  Meter(const std::function<double()>& clock, std::size_t events)
      : clock_(clock), fifth_(events / 5 + 1) {}

  template <class Body>
  void run(std::size_t event, bool scan, const Body& body) {
    const double before = now();
    body();
    const std::size_t part = event / fifth_;
    spent_[part] += now() - before;
    scans_[part] += scan;
  }
  double now() const { return clock_ ? clock_() : 0; }
  double per_scan(std::size_t part) const {
    return scans_[part] > 0 ? spent_[part] / static_cast<double>(scans_[part]) : 0;
  }
  double whole() const { return spent_[0] + spent_[1] + spent_[2] + spent_[3] + spent_[4]; }

 private:
  const std::function<double()>& clock_;
  std::size_t fifth_;
  double spent_[5] = {};
  std::size_t scans_[5] = {};
};

Trajectory path_of(const Site& site) {
  Trajectory path;
  for (const PosedScan& s : site.scans) path.push_back({s.scan.time, s.estimate.T_map_robot});
  return path;
}

/// Key scans where the truth knows them, aligned to it.
struct Place {
  const Scan* scan;
  Pose2 truth, estimate;
  double way;  // m driven up to there
};

std::vector<Place> places_of(const Site& site, const Trajectory& truth, const Pose2& T_truth_map) {
  const TrajectoryIndex index(truth);
  std::vector<Place> places;
  double way = 0;
  for (const PosedScan& s : site.scans) {
    const auto at = s.key ? index.at(s.scan.time) : std::nullopt;
    if (!at) continue;
    if (!places.empty()) way += (at->pose.translation() - places.back().truth.translation()).norm();
    places.push_back({&s.scan, at->pose, T_truth_map * s.estimate.T_map_robot, way});
  }
  return places;
}

double map_error(const std::vector<Place>& places) {
  TrueWalls walls;
  for (const Place& p : places) walls.add(*p.scan, p.truth);
  double sum = 0;
  std::size_t count = 0;
  const std::size_t stride = places.size() / 200 + 1;
  for (std::size_t i = 0; i < places.size(); i += stride) {
    const auto points = match::scan_points(*places[i].scan, {.max_range = 20}, false);
    for (std::size_t k = 0; k < points.size(); ++k, ++count)
      sum += walls.off(places[i].estimate * Vec2(points.x[k], points.y[k]));
  }
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

std::optional<double> recognised(const std::vector<Place>& places) {
  std::size_t again = 0, together = 0;
  for (std::size_t j = 0; j < places.size(); ++j) {
    const Place* nearest = nullptr;
    double least = kSeenAgain;
    for (std::size_t i = 0; i < j && places[j].way - places[i].way > kWay; ++i) {
      const double off = (places[i].truth.translation() - places[j].truth.translation()).norm();
      if (off < least) least = off, nearest = &places[i];
    }
    if (!nearest) continue;
    const Pose2 off = between(between(nearest->truth, places[j].truth),
                              between(nearest->estimate, places[j].estimate));
    ++again;
    together += off.translation().norm() < kOnEachOther;
  }
  if (again == 0) return std::nullopt;
  return static_cast<double>(together) / static_cast<double>(again);
}

void judge(const slam::Mapping& mapping, const TrialLog& log, MappingScore& score) {
  const Trajectory path = path_of(mapping.site);
  if (!log.relations.empty())
    score.relation = evaluate_relations_in_both_frames(
                         path, mapping.site.scans.front().scan.T_robot_laser, log.relations)
                         .best()
                         .all.translation.mean;
  const Association paired = associate(path, log.truth);
  if (paired.pairs.empty()) return;
  const AbsoluteError error = absolute_error(paired.pairs);
  score.rms = error.translation.rms;
  score.worst = error.translation.max;
  score.way = path_length(paired.pairs);
  if (mapping.posterior) {
    std::vector<Estimate> estimates;
    for (const PosedScan& s : mapping.site.scans) estimates.push_back(s.estimate);
    const std::vector<double> nees = nees_of_run(estimates, log.truth);
    if (!nees.empty()) score.nees = error_stats(nees).mean;
  }
  const std::vector<Place> places = places_of(mapping.site, log.truth, error.T_reference_map);
  score.map_error = map_error(places);
  score.recognised = recognised(places);
}

}  // namespace

MappingScore try_mapping(const TrialLog& log, const methods::MappingMethod& method,
                         const methods::MappingOptions& options, Threads threads,
                         const std::function<double()>& clock) {
  MappingScore score;
  Meter meter(clock, log.events.size());
  slam::Mapping mapping;
  try {
    const slam::Mapper mapper = method.make(options, threads);
    for (std::size_t i = 0; i < log.events.size(); ++i) {
      Event event = log.events[i];
      const bool scan = std::holds_alternative<Scan>(event);
      meter.run(i, scan, [&] { score.online |= mapper.add(std::move(event)).has_value(); });
    }
    const double before = meter.now();
    mapping = mapper.finish();
    score.cpu_finish = meter.now() - before;
  } catch (const Error& e) {
    score.said = e.what();
    return score;
  }
  score.ran = true;
  score.scans = mapping.site.scans.size();
  score.cpu = meter.whole() + score.cpu_finish;
  score.cpu_first = meter.per_scan(0);
  score.cpu_last = meter.per_scan(4);
  score.bytes = mapping.belief_bytes;
  score.landmarks = mapping.landmarks;
  for (const slam::LoopCorrection& c : mapping.corrections) {
    ++score.corrections;
    score.undone += c.undone.has_value();
  }
  for (const auto& [what, entry] : mapping.site.report.entries())
    score.no_loop |= what.starts_with("no loop found");
  judge(mapping, log, score);
  return score;
}

}  // namespace majak::eval
