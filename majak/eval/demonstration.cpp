// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/demonstration.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>

#include "majak/core/error.hpp"
#include "majak/core/rigid_fit.hpp"
#include "majak/eval/consistency.hpp"
#include "majak/eval/split_maps.hpp"
#include "majak/localize/dead_reckoning.hpp"

namespace majak::eval {
namespace {

constexpr double kTogether = 60;  // s of truth whose errors go together

/// A point of the robot where it truly was, by fixes or by truth.
struct Witness {
  Time time;
  Vec2 p;
  int group;
  bool sound;
  std::optional<Pose2> truth;
};

struct Reference {
  std::vector<Witness> witnesses;
  Vec2 point = Vec2::Zero();  ///< m, on the robot, where the witnesses are
  double variance = 0;        ///< m^2, each axis, of a witness
  double heading = 0;         ///< rad, at first
};

Reference reference_of(const Demonstration& d, const DemonstrationInput& input) {
  Reference r;
  if (d.truth.empty()) {
    r.point = input.antenna;
    r.variance = std::pow(input.ekf.gps_sigma, 2) + std::pow(input.ekf.gps_fast_sigma, 2);
    r.heading = input.heading;
    for (const ReferenceFix& f : d.fixes.fixes)
      r.witnesses.push_back({f.time, f.p, static_cast<int>(f.burst), f.sound, {}});
  } else {
    const auto begin = d.truth.front().time;
    r.heading = d.truth.front().pose.theta;
    for (const StampedPose& t : d.truth) {
      const double seconds = to_seconds(t.time - begin);
      r.witnesses.push_back(
          {t.time, t.pose.translation(), static_cast<int>(seconds / kTogether), true, t.pose});
    }
  }
  return r;
}

/// The path where there is a witness: which one, the estimate then, and the point on the robot.
struct Met {
  const Witness* witness;
  Pose2 T_map_robot;
  Mat3 covariance;
  Vec2 p_map;
};

std::vector<Met> meet(const std::vector<Estimate>& estimates, const Reference& reference,
                      const std::vector<bool>& chosen) {
  Trajectory path;
  for (const Estimate& e : estimates) path.push_back({e.time, e.T_map_robot});
  const TrajectoryIndex index(path);
  std::vector<Met> met;
  for (std::size_t i = 0; i < reference.witnesses.size(); ++i) {
    if (!chosen.empty() && !chosen[i]) continue;
    const Witness& w = reference.witnesses[i];
    if (const auto at = index.at(w.time))
      met.push_back({&w, at->pose, estimates[at->index].covariance, at->pose * reference.point});
  }
  return met;
}

Pose2 frame(const std::vector<Met>& met, const Reference& reference, Against against) {
  if (met.empty()) return {};
  if (against == Against::aligned) {
    std::vector<Vec2> path, witnesses;
    for (const Met& m : met)
      if (m.witness->sound) path.push_back(m.p_map), witnesses.push_back(m.witness->p);
    return rigid_fit(path, witnesses);
  }
  if (against != Against::first_pose) return {};
  const Pose2 turn{0, 0, reference.heading - met.front().T_map_robot.theta};
  const Vec2 off = met.front().witness->p - turn * met.front().p_map;
  return {off.x(), off.y(), turn.theta};
}

std::optional<double> nis_of(const Met& m, const Reference& reference, const Pose2& T) {
  if (m.witness->truth) return nees(m.T_map_robot, m.covariance, T.inverse() * *m.witness->truth);
  Eigen::Matrix<double, 2, 3> by_pose;
  const Vec2 lever = m.p_map - m.T_map_robot.translation();
  by_pose << 1, 0, -lever.y(), 0, 1, lever.x();
  Eigen::Matrix2d s = by_pose * m.covariance * by_pose.transpose();
  s.diagonal().array() += reference.variance;
  const Vec2 off = T.inverse() * m.witness->p - m.p_map;
  return off.dot(s.inverse() * off);
}

PathScore score(const std::vector<Estimate>& estimates, const Reference& reference,
                const std::vector<bool>& chosen, Against against) {
  const std::vector<Met> met = meet(estimates, reference, chosen);
  PathScore s{against, frame(met, reference, against), {}};
  for (const Met& m : met) {
    PlaceError e{m.witness->time,
                 s.T_reference_map * m.p_map - m.witness->p,
                 m.witness->group,
                 m.witness->sound,
                 {}};
    // Where the frame comes from fixes, the path's covariance says nothing of it.
    if (against == Against::held_out || against == Against::fed ||
        (against == Against::first_pose && m.witness->truth))
      e.nis = nis_of(m, reference, s.T_reference_map);
    s.errors.push_back(e);
  }
  return s;
}

class Runner {
 public:
  explicit Runner(const DemonstrationInput& input) : input_(input) {}

  DemonstrationRun run(Feed feed, std::vector<bool> withheld) const {
    DemonstrationRun run{feed, std::move(withheld), {}, {}, {}};
    slam::EkfSlam slam(input_.ekf, start());
    const double begin = now();
    std::size_t fix = 0;
    std::int64_t scans = 0;
    for (const Event& event : input_.events) {
      if (std::holds_alternative<GpsFix>(event) && run.withheld[fix++]) continue;
      const double before = now();
      if (!slam.add(event)) continue;
      run.steps.push_back({slam.filter().size(), now() - before});
      if (input_.progress) input_.progress(name_of(feed), ++scans);
    }
    run.ekf.map = slam.finish();
    run.ekf.cpu = now() - begin;
    run.graph.map = slam::optimize_landmarks(run.ekf.map, input_.ekf, input_.graph);
    run.graph.cpu = now() - begin - run.ekf.cpu;
    return run;
  }

 private:
  double now() const { return input_.clock ? input_.clock() : 0; }
  // Where truth is known, so is the start.
  Pose2 start() const {
    for (const Event& event : input_.events)
      if (const auto* t = std::get_if<Truth>(&event)) return t->T_world_robot;
    return {};
  }

  const DemonstrationInput& input_;
};

void tell(DemonstrationRun& run, const Reference& reference, const std::vector<bool>& chosen,
          Against against) {
  for (DemonstrationAnswer* a : {&run.ekf, &run.graph})
    a->scores.push_back(score(a->map.localization.estimates, reference, chosen, against));
}

// ---- Landmarks -------------------------------------------------------------------------------

/// By number, the true one that a landmark is.
std::vector<std::optional<Vec2>> true_places(const slam::LandmarkMap& map,
                                             const LandmarkMatch& match,
                                             const std::vector<std::size_t>& standing,
                                             const std::vector<Vec2>& trunks) {
  std::vector<std::optional<Vec2>> places(map.landmarks.size());
  for (const LandmarkMatch::Pair& pair : match.pairs)
    places[standing[pair.mapped]] = trunks[pair.truth];
  return places;
}

ObstacleErrors obstacle_errors(const slam::LandmarkMap& map, const Demonstration& d) {
  ObstacleErrors errors;
  const auto& estimates = map.localization.estimates;
  std::vector<std::optional<Vec2>> places;
  for (const slam::MappedLandmark& l : map.landmarks) places.emplace_back(l.p_map);
  if (!d.trunks.empty()) {
    std::vector<PlacedLandmark> mapped, truth;
    std::vector<std::size_t> standing;
    for (std::size_t i = 0; i < map.landmarks.size(); ++i)
      if (!map.landmarks[i].gone) {
        standing.push_back(i);
        mapped.push_back({map.landmarks[i].p_map, map.landmarks[i].covariance});
      }
    for (const Vec2& p : d.trunks) truth.push_back({p, {}});
    errors.match = match_landmarks(mapped, truth);
    errors.aligned = match_landmarks(mapped, truth, {.align = true});
    places = true_places(map, *errors.match, standing, d.trunks);
  }
  std::vector<LandmarkSeen> seen;
  const TrajectoryIndex truth(d.truth);
  for (const slam::LandmarkObservation& o : map.observations) {
    const Estimate& e = estimates[o.scan];
    seen.push_back({e.time, e.T_map_robot, o.q_robot, o.landmark});
    const auto& place = places[static_cast<std::size_t>(o.landmark)];
    const auto truly = truth.at(e.time);
    if (place && (truly || d.truth.empty()))
      errors.sightings.push_back(sighting_error(
          o.q_robot, e.T_map_robot, truly ? truly->pose : e.T_map_robot, *place, d.T_robot_laser));
  }
  errors.split = split_half(seen);
  return errors;
}

Trajectory wheels_alone(const DemonstrationInput& input, const Pose2& start) {
  localize::DeadReckoningOptions options;
  options.wheelbase = input.ekf.wheelbase;
  const auto method = localize::dead_reckoning(options, start);
  for (const Event& event : input.events) method.add(event);
  Trajectory path;
  for (const Estimate& e : method.finish().estimates) path.push_back({e.time, e.T_map_robot});
  return path;
}

void look_into(const DemonstrationInput& input, Demonstration& d) {
  std::vector<Truth> truth;
  bool scans = false;
  for (const Event& event : input.events) {
    if (const auto* scan = std::get_if<Scan>(&event); scan && !scans) {
      d.T_robot_laser = scan->T_robot_laser;
      scans = true;
    }
    if (const auto* t = std::get_if<Truth>(&event)) truth.push_back(*t);
  }
  d.truth = truth_of(truth);
  d.trunks = input.trunks;
  d.fixes = reference_fixes(input.events, input.ekf.wheelbase);
  if (!scans) throw Error("the demonstration needs scans; majak info tells what is in the log");
  if (d.truth.empty() && d.fixes.fixes.empty())
    throw Error("the demonstration needs satellite fixes, or truth, to be measured against");
}

}  // namespace

const char* name_of(Feed feed) {
  constexpr const char* kNames[] = {"without satellites", "with half of the bursts",
                                    "satellites cut off for minutes", "with all satellites"};
  return kNames[static_cast<std::size_t>(feed)];
}

const char* name_of(Against against) {
  constexpr const char* kNames[] = {"after one alignment", "from the first pose alone",
                                    "not fed with, nothing aligned", "fed with, nothing aligned"};
  return kNames[static_cast<std::size_t>(against)];
}

Demonstration demonstrate(const DemonstrationInput& input) {
  Demonstration d;
  look_into(input, d);
  const Reference reference = reference_of(d, input);
  const Runner runner(input);
  const std::size_t n = d.fixes.fixes.size();
  const bool known = !d.truth.empty();

  d.runs.push_back(runner.run(Feed::none, std::vector<bool>(n, true)));
  tell(d.runs.back(), reference, {}, Against::aligned);
  tell(d.runs.back(), reference, {}, Against::first_pose);
  if (n > 0) {
    if (!known)
      for (const std::size_t fold : {0, 1}) {
        const auto held = hold_out_fold(d.fixes, fold);
        d.runs.push_back(runner.run(Feed::fold, held));
        tell(d.runs.back(), reference, held, Against::held_out);
      }
    const Time begin = d.fixes.fixes.front().time, end = d.fixes.fixes.back().time;
    const Time middle = begin + (end - begin) / 2;
    const Duration half = from_seconds(0.5 * input.cut_off);
    const auto cut = hold_out_between(d.fixes, middle - half, middle + half);
    d.runs.push_back(runner.run(Feed::cut_off, cut));
    tell(d.runs.back(), reference, known ? std::vector<bool>{} : cut, Against::held_out);
    d.runs.push_back(runner.run(Feed::all, std::vector<bool>(n, false)));
    tell(d.runs.back(), reference, {}, known ? Against::held_out : Against::fed);
  }
  for (DemonstrationRun& run : d.runs)
    for (DemonstrationAnswer* a : {&run.ekf, &run.graph}) a->obstacles = obstacle_errors(a->map, d);
  for (DemonstrationRun& run : d.runs)
    run.graph.obstacles.maps = split_maps(run.graph.map, input.ekf, input.graph);
  d.wheels = wheels_alone(input, d.with_all().graph.map.localization.estimates.front().T_map_robot);
  return d;
}

std::vector<PlaceError> pooled(const Demonstration& demonstration, Feed feed, Against against,
                               bool graph) {
  std::vector<PlaceError> all;
  for (const DemonstrationRun& run : demonstration.runs) {
    if (run.feed != feed) continue;
    for (const PathScore& s : (graph ? run.graph : run.ekf).scores)
      if (s.against == against) all.insert(all.end(), s.errors.begin(), s.errors.end());
  }
  return all;
}

Headline headline(const std::vector<PlaceError>& errors, bool sound_only) {
  Headline h;
  std::vector<double> sizes;
  std::vector<int> groups;
  std::map<int, std::vector<Vec2>> by_group;
  double nis = 0, known = 0;
  for (const PlaceError& e : errors) {
    if (sound_only && !e.sound) continue;
    sizes.push_back(e.error());
    groups.push_back(e.group);
    by_group[e.group].push_back(e.off);
    if (e.nis) nis += *e.nis, known += 1;
  }
  if (sizes.empty()) return h;
  h.groups = by_group.size();
  double spread = 0, dof = 0;
  for (const auto& [group, offs] : by_group) {
    Vec2 mean = Vec2::Zero();
    for (const Vec2& off : offs) mean += off / static_cast<double>(offs.size());
    for (const Vec2& off : offs) spread += (off - mean).squaredNorm();
    dof += 2 * static_cast<double>(offs.size() - 1);
  }
  if (dof > 0) h.scatter = std::sqrt(spread / dof);
  if (known > 0) h.nis = nis / known;
  h.mean = mean_with_confidence(sizes, groups);
  h.stats = error_stats(std::move(sizes));
  return h;
}

namespace {

int square_of(const Vec2& p) {
  constexpr double kSide = 50;  // m
  return static_cast<int>(std::floor(p.x() / kSide)) * 1000 +
         static_cast<int>(std::floor(p.y() / kSide));
}

}  // namespace

Headline headline(const LandmarkMatch& match, const Demonstration& demonstration) {
  std::vector<PlaceError> errors;
  for (const LandmarkMatch::Pair& pair : match.pairs)
    errors.push_back({0, pair.error, square_of(demonstration.trunks[pair.truth]), true, pair.nees});
  return headline(errors);
}

Headline headline(const SplitHalf& split) {
  std::vector<PlaceError> errors;
  for (const SplitHalf::Landmark& l : split.landmarks)
    errors.push_back({0, l.even - l.odd, square_of(l.even), true, {}});
  return headline(errors);
}

}  // namespace majak::eval
