// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/compare.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "majak/core/error.hpp"
#include "majak/eval/statistics.hpp"
#include "majak/match/beams.hpp"

namespace majak::eval {
namespace {

constexpr std::size_t kSampled = 60;               // scans that are looked at for a share
constexpr double kSameRange = 0.05, kOnMap = 0.3;  // m
constexpr std::size_t kGaussian = 3 * 8 + 9 * 8;   // bytes of a pose and its covariance
constexpr LookupOptions kExact{10'000, 0};

std::vector<const Scan*> scans_of(const std::vector<Event>& events) {
  std::vector<const Scan*> scans;
  for (const Event& event : events)
    if (const auto* scan = std::get_if<Scan>(&event); scan && scan->laser == 0)
      scans.push_back(scan);
  return scans;
}

/// Evenly along the log, kSampled of them at most.
std::vector<const Scan*> some_scans(const std::vector<Event>& events) {
  const auto all = scans_of(events);
  const std::size_t n = std::min(kSampled, all.size());
  std::vector<const Scan*> some;
  for (std::size_t k = 0; k < n; ++k) some.push_back(all[(2 * k + 1) * all.size() / (2 * n)]);
  return some;
}

bool same_ranges(const Scan& a, const Scan& b) {
  if (a.ranges.size() != b.ranges.size()) return false;
  std::size_t same = 0, all = 0;
  for (std::size_t i = 0; i < a.ranges.size(); ++i) {
    if (!std::isfinite(a.ranges[i])) continue;
    ++all;
    same += std::abs(a.ranges[i] - b.ranges[i]) < kSameRange;
  }
  return 10 * same >= 9 * all;
}

// ---- A method over a log -----------------------------------------------------------------------

struct Timed {
  localize::Localization result;
  double whole = 0, most = 0;  // s of CPU
};

Timed run(const CompareInput& in, const methods::Method& method, const std::vector<Event>& events) {
  Timed timed;
  const auto localizer = method.make(in.options);
  const auto now = [&] { return in.clock ? in.clock() : 0.0; };
  double since = 0;  // the last estimate
  for (std::size_t i = 0; i < events.size(); ++i) {
    if (in.progress) in.progress(method.name, static_cast<std::int64_t>(i));
    const double begin = now();
    const bool made_one = localizer.add(events[i]).has_value();
    since += now() - begin;
    if (!made_one) continue;
    timed.whole += since, timed.most = std::max(timed.most, std::exchange(since, 0));
  }
  const double begin = now();
  timed.result = localizer.finish();
  timed.whole += since + now() - begin;
  return timed;
}

/// Counts the updates along a way: 1 at the first pose, then one after each step or turn. Where
/// nothing is known of the way each pose is one.
std::vector<int> count_updates(const std::vector<Time>& times, const Trajectory& way,
                               const CompareOptions& how) {
  const TrajectoryIndex index(way);
  std::vector<int> counts;
  std::optional<Pose2> last;
  double driven = 0, turned = 0;
  int count = 0;
  for (const Time t : times) {
    const auto here = index.at(t);
    if (here && last) {
      driven += (here->pose.translation() - last->translation()).norm();
      turned += std::abs(angle_diff(here->pose.theta, last->theta));
    }
    if (count == 0 || !here || driven >= how.step || turned >= how.turn)
      ++count, driven = turned = 0;
    if (here) last = here->pose;
    counts.push_back(count);
  }
  return counts;
}

std::vector<Time> times_of(const std::vector<Estimate>& estimates) {
  std::vector<Time> times;
  times.reserve(estimates.size());
  for (const Estimate& e : estimates) times.push_back(e.time);
  return times;
}

/// Each estimate against the truth; nothing where there is none at its time.
std::vector<std::optional<Pose2>> errors_of(const std::vector<Estimate>& estimates,
                                            const Trajectory& truth) {
  const TrajectoryIndex index(truth);
  std::vector<std::optional<Pose2>> errors;
  for (const Estimate& e : estimates) {
    const auto real = index.at(e.time);
    errors.push_back(real ? std::optional(between(real->pose, e.T_map_robot)) : std::nullopt);
  }
  return errors;
}

bool is_right(const Pose2& off, const CompareOptions& how) {
  return off.translation().norm() < how.right && std::abs(off.theta) < how.right_turn;
}

/// Not lost, and right where that is known.
bool knows(const Estimate& e, const std::optional<Pose2>& off, bool truth,
           const CompareOptions& how) {
  return e.health != Health::lost && (!truth || (off && is_right(*off, how)));
}

void tell_errors(const CompareInput& in, MethodResult& r) {
  std::vector<double> meters, radians;
  double compared = 0, right = 0, ok = 0, wrong = 0;
  const auto errors = errors_of(r.estimates, in.truth);
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const Health health = r.estimates[i].health;
    ++r.health[static_cast<int>(health)];
    if (!errors[i]) continue;
    ++compared;
    const bool good = is_right(*errors[i], in.how);
    if (health == Health::ok) ++ok, wrong += !good;
    if (health == Health::lost) continue;
    right += good;
    meters.push_back(errors[i]->translation().norm());
    radians.push_back(std::abs(errors[i]->theta));
  }
  if (compared > 0) r.right = right / compared;
  if (ok > 0) r.wrong = wrong / ok;
  if (meters.empty()) return;
  r.translation = {quantile(meters, 0.5), quantile(meters, 0.95)};
  r.rotation = {quantile(radians, 0.5), quantile(radians, 0.95)};
}

std::optional<int> first_known(const CompareInput& in, const std::vector<Estimate>& estimates,
                               const Trajectory& way) {
  const auto errors = errors_of(estimates, in.truth);
  const auto counts = count_updates(times_of(estimates), way, in.how);
  for (std::size_t i = 0; i < estimates.size(); ++i)
    if (knows(estimates[i], errors[i], !in.truth.empty(), in.how)) return counts[i];
  return std::nullopt;
}

Recovery recovery_of(const CompareInput& in, const Splice& splice,
                     const std::vector<Estimate>& estimates, const Trajectory& way) {
  const auto errors = errors_of(estimates, splice.spliced(in.truth));
  const bool truth = !in.truth.empty();
  Recovery r;
  std::vector<Time> after;
  std::size_t first = 0;
  for (; first < estimates.size() && estimates[first].time < splice.jump; ++first)
    r.knew = knows(estimates[first], errors[first], truth, in.how);
  for (std::size_t i = first; i < estimates.size(); ++i) after.push_back(estimates[i].time);
  const auto counts = count_updates(after, splice.spliced(way), in.how);
  for (std::size_t i = first; i < estimates.size() && !r.right_again; ++i) {
    const bool lost = estimates[i].health == Health::lost;
    if (lost && !r.told_lost) r.told_lost = counts[i - first];
    if (knows(estimates[i], errors[i], truth, in.how) && (truth || r.told_lost))
      r.right_again = counts[i - first];
  }
  return r;
}

std::string number(const std::optional<double>& v, double scale, int digits) {
  return v ? fmt::format("{:.{}f}", scale * *v, digits) : "";
}
std::string number(const std::optional<int>& v) { return v ? fmt::format("{}", *v) : ""; }
std::optional<double> median(const std::optional<Spread>& s) {
  return s ? std::optional(s->median) : std::nullopt;
}
std::optional<double> p95(const std::optional<Spread>& s) {
  return s ? std::optional(s->p95) : std::nullopt;
}

}  // namespace

Comparison compare(const CompareInput& in, const std::vector<std::string>& names) {
  Comparison comparison;
  const auto scans = scans_of(in.events);
  std::vector<Time> times;
  times.reserve(scans.size());
  for (const Scan* scan : scans) times.push_back(scan->time);
  const Trajectory way = in.truth.empty() ? wheels_of(in.events) : in.truth;
  const auto counts = count_updates(times, way, in.how);
  comparison.scans = scans.size();
  comparison.updates = counts.empty() ? 0 : counts.back();
  comparison.splice = splice(in.events, way, in.how.apart);
  for (const std::string& name : names) {
    const methods::Method& method = methods::method(name);
    MethodResult r;
    r.method = name;
    r.told = method.told;
    Timed timed = run(in, method, in.events);
    if (timed.result.estimates.empty()) {
      comparison.left_out.push_back(fmt::format("{} needs {}", name, method.needs));
      continue;
    }
    auto bytes = belief_bytes(timed.result);
    std::sort(bytes.begin(), bytes.end());
    r.belief_median = bytes[bytes.size() / 2], r.belief_most = bytes.back();
    r.estimates = std::move(timed.result.estimates);
    r.updates = timed.result.updates > 0 ? timed.result.updates
                                         : static_cast<std::int64_t>(r.estimates.size());
    r.cpu_mean = timed.whole / static_cast<double>(std::max<std::size_t>(1, scans.size()));
    r.cpu_most = timed.most;
    tell_errors(in, r);
    if (!r.told) r.found = first_known(in, r.estimates, way);
    if (comparison.splice) {
      const Timed carried = run(in, method, comparison.splice->events);
      r.recovery = recovery_of(in, *comparison.splice, carried.result.estimates, way);
    }
    comparison.methods.push_back(std::move(r));
  }
  if (comparison.methods.empty() && !comparison.left_out.empty())
    throw Error(comparison.left_out.front() + "; majak info tells what is in the log");
  if (comparison.splice) comparison.splice->events.clear();
  return comparison;
}

std::vector<std::size_t> belief_bytes(const localize::Localization& result) {
  if (!result.belief_bytes.empty()) return result.belief_bytes;
  std::vector<std::size_t> bytes;
  auto at = result.hypotheses.begin();
  for (const Estimate& e : result.estimates) {
    std::size_t several = 0;
    for (; at != result.hypotheses.end() && at->time <= e.time; ++at)
      several = at->time == e.time ? at->hypotheses.size() : 0;
    bytes.push_back(kGaussian + several * sizeof(localize::Hypothesis));
  }
  return bytes;
}

std::optional<Trajectory> path_of_same_log(const Site& site, const std::vector<Event>& events) {
  Trajectory path;
  for (const PosedScan& s : site.scans) path.push_back({s.scan.time, s.estimate.T_map_robot});
  const TrajectoryIndex index(path, kExact);
  const auto some = some_scans(events);
  std::size_t same = 0;
  for (const Scan* scan : some) {
    const auto at = index.at(scan->time);
    same += at && same_ranges(site.scans[at->index].scan, *scan);
  }
  if (some.empty() || 10 * same < 8 * some.size()) return std::nullopt;
  return path;
}

double share_on_map(const localize::Place& place, const std::vector<Event>& events,
                    const Trajectory& truth) {
  const TrajectoryIndex index(truth);
  std::size_t on = 0, all = 0;
  for (const Scan* scan : some_scans(events)) {
    const auto at = index.at(scan->time);
    if (!at) continue;
    const match::Beams beams = match::beams(*scan);
    all += beams.returns;
    for (std::size_t k = 0; k < beams.returns; ++k)
      on += place.distances.at(at->pose * Vec2(beams.x[k], beams.y[k])) < kOnMap;
  }
  return all == 0 ? 0 : static_cast<double>(on) / static_cast<double>(all);
}

std::string comparison_csv(const Comparison& comparison) {
  std::string text =
      "method,told_start,error_median_m,error_p95_m,error_median_deg,error_p95_deg,right_share,"
      "wrong_of_ok_share,ok_share,degraded_share,lost_share,cpu_mean_ms_a_scan,cpu_most_ms,"
      "updates,updates_a_cpu_s,belief_median_bytes,belief_most_bytes,found_after_updates,"
      "carried_knew_before,carried_told_lost_after_updates,carried_right_after_updates\n";
  for (const MethodResult& r : comparison.methods) {
    const auto n = static_cast<double>(r.estimates.size());
    const double whole = r.cpu_mean * static_cast<double>(comparison.scans);
    text += fmt::format(
        "{},{},{},{},{},{},{},{},{:.4f},{:.4f},{:.4f},{:.4f},{:.3f},{},{},{},{},{},{},{},{}\n",
        r.method, r.told ? 1 : 0, number(median(r.translation), 1, 4),
        number(p95(r.translation), 1, 4), number(median(r.rotation), degrees(1), 3),
        number(p95(r.rotation), degrees(1), 3), number(r.right, 1, 4), number(r.wrong, 1, 4),
        static_cast<double>(r.health[0]) / n, static_cast<double>(r.health[1]) / n,
        static_cast<double>(r.health[2]) / n, 1e3 * r.cpu_mean, 1e3 * r.cpu_most, r.updates,
        whole > 0 ? fmt::format("{:.0f}", static_cast<double>(r.updates) / whole) : "",
        r.belief_median, r.belief_most, number(r.found),
        r.recovery ? (r.recovery->knew ? "1" : "0") : "",
        r.recovery ? number(r.recovery->told_lost) : "",
        r.recovery ? number(r.recovery->right_again) : "");
  }
  return text;
}

}  // namespace majak::eval
