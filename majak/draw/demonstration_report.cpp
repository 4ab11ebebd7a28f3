// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/demonstration_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>

#include "majak/draw/demonstration_figures.hpp"
#include "majak/draw/report_page.hpp"
#include "majak/draw/sketch.hpp"
#include "majak/eval/split_maps.hpp"

namespace majak::draw {
namespace {

using eval::Against;
using eval::Demonstration;
using eval::DemonstrationAnswer;
using eval::DemonstrationRun;
using eval::Feed;
using eval::Headline;
using Row = std::vector<std::string>;

std::string soft(const std::string& text) {
  return fmt::format("<p class=\"soft\">{}</p>\n", escape(text));
}

std::string metres_between(const Headline& h) {
  return fmt::format("95 %: {} to {}", metres(h.mean.low), metres(h.mean.high));
}

/// The figure that stands for the robot's place: the graph's, all satellites at hand.
Headline place_headline(const Demonstration& d) {
  if (!d.truth.empty() && !d.fixes.fixes.empty())
    return eval::headline(eval::pooled(d, Feed::all, Against::held_out, true));
  if (!d.fixes.fixes.empty())
    return eval::headline(eval::pooled(d, Feed::fold, Against::held_out, true));
  return eval::headline(eval::pooled(d, Feed::none, Against::first_pose, true));
}

Headline obstacle_headline(const Demonstration& d, const DemonstrationAnswer& answer) {
  return answer.obstacles.match
             ? eval::headline(*answer.obstacles.match, d.trunks)
             : eval::headline(answer.obstacles.maps.value_or(answer.obstacles.split));
}

double way_driven(const Demonstration& d) {
  const auto& estimates = d.with_all().graph.map.localization.estimates;
  double way = 0;
  for (std::size_t i = 1; i < estimates.size(); ++i)
    way += (estimates[i].T_map_robot.translation() - estimates[i - 1].T_map_robot.translation())
               .norm();
  return way;
}

std::string tiles(const Demonstration& d) {
  const Headline place = place_headline(d), obstacles = obstacle_headline(d, d.with_all().graph);
  const auto& estimates = d.with_all().graph.map.localization.estimates;
  std::string out = "<div class=\"tiles\">\n";
  out += tile(metres(place.mean.mean), "mean error of the robot's place", metres_between(place));
  out +=
      tile(metres(obstacles.mean.mean),
           d.trunks.empty() ? "between two maps of the obstacles" : "mean error of the obstacles",
           metres_between(obstacles));
  out += tile(metres(way_driven(d)), "driven",
              "in " + clock(to_seconds(estimates.back().time - estimates.front().time)));
  out += tile(std::to_string(d.with_all().graph.map.landmarks.size()), "landmarks",
              fmt::format("{} sightings", d.with_all().graph.map.observations.size()));
  return out + "</div>\n";
}

std::string against_section(const Demonstration& d) {
  std::vector<std::string> words;
  if (!d.truth.empty()) {
    words.push_back(
        "The place: against the true pose at each scan, which the log knows and no run was fed "
        "with.");
  } else {
    const Headline h = place_headline(d);
    words.push_back(
        fmt::format("The place: against satellite fixes that the run was not fed with. The {} "
                    "bursts of fixes are "
                    "held out by turns in two folds, the first and the last one never; nothing is "
                    "aligned. {} of {} "
                    "fixes are sound by data alone: they step as the wheels do.",
                    d.fixes.bursts,
                    std::count_if(d.fixes.fixes.begin(), d.fixes.fixes.end(),
                                  [](const auto& f) { return f.sound; }),
                    d.fixes.fixes.size()));
    words.push_back(
        fmt::format("How good these fixes are: within a burst they scatter by {} in each axis "
                    "about the burst's mean. "
                    "Each burst is off as a whole, too; that is part of the figures here, and no "
                    "path, however good, "
                    "comes to nothing.",
                    metres(h.scatter)));
    words.push_back(
        "The thesis said 0.5 m, against the fixes it was fed with; that figure is in the table as "
        "well, "
        "and says little.");
  }
  words.push_back(
      d.trunks.empty()
          ? "The obstacles: nobody has surveyed them. The landmark graph is solved once with "
            "what was seen in the even minutes and once with the odd ones; told is how far apart "
            "the two maps have each trunk that was seen eight times and more in both, nothing "
            "aligned. What is wrong alike in both "
            "does not show. The thesis said 0.3 m."
          : "The obstacles: against the trunks as the simulator placed them, nothing "
            "aligned. The thesis said 0.3 m.");
  words.push_back(
      "Intervals are bootstrapped over what errs together: bursts, minutes, squares of 50 m.");
  return section("Measured against what", list(words));
}

// ---- The map ---------------------------------------------------------------------------------

std::string dots(const std::vector<Point>& metres, const View& view) {
  std::string d;
  std::pair<long, long> last{};
  for (const Point& p : metres) {
    const Point q = view(p);
    const std::pair<long, long> here{std::lround(10 * q.x), std::lround(10 * q.y)};
    if (here != last) d += fmt::format("M{} {}h0", number(q.x, 1), number(q.y, 1));
    last = here;
  }
  return d;
}

std::string landmark_layer(const std::vector<slam::MappedLandmark>& landmarks, const View& view) {
  constexpr double kQuantile = 2.4477;  // sqrt of 5.991: 95 %
  std::string out = "<g class=\"layer ellipses\">\n";
  for (const slam::MappedLandmark& l : landmarks) {
    if (l.gone) continue;
    const EllipseAxes e = axes_of(l.covariance);
    const Point c = view(point(l.p_map));
    out += fmt::format(
        "<ellipse rx=\"{}\" ry=\"{}\" transform=\"translate({} {})rotate({})\"><title>{} m across, "
        "seen {} times, sigma {} x {} cm</title></ellipse>\n",
        number(view.length(kQuantile * e.major)), number(view.length(kQuantile * e.minor)),
        number(c.x), number(c.y), number(-degrees(e.angle), 0), number(l.diameter), l.sightings,
        number(100 * e.major, 1), number(100 * e.minor, 1));
  }
  return out + "</g>\n";
}

std::vector<Point> sightings_of(const slam::LandmarkMap& map) {
  std::vector<Point> seen;
  for (const slam::LandmarkObservation& o : map.observations)
    seen.push_back(point(map.localization.estimates[o.scan].T_map_robot * o.q_robot));
  return seen;
}

template <class Poses, class Place>
std::vector<Point> way_through(const Poses& poses, const Place& place) {
  std::vector<Point> way;
  for (const auto& p : poses) way.push_back(point(place(p).translation()));
  return way;
}

std::string map_section(const Demonstration& d) {
  constexpr double kWidth = 1000, kMargin = 5;  // units; m
  const DemonstrationRun& run = d.with_all();
  const auto of_estimate = [](const Estimate& e) { return e.T_map_robot; };
  const auto of_stamped = [](const eval::StampedPose& p) { return p.pose; };
  const auto graph = way_through(run.graph.map.localization.estimates, of_estimate);
  std::vector<Point> inside = graph;
  for (const slam::MappedLandmark& l : run.graph.map.landmarks) inside.push_back(point(l.p_map));
  const auto [left, right] =
      std::minmax_element(inside.begin(), inside.end(), [](auto& a, auto& b) { return a.x < b.x; });
  const auto [low, high] =
      std::minmax_element(inside.begin(), inside.end(), [](auto& a, auto& b) { return a.y < b.y; });
  const double unit = (right->x - left->x + 2 * kMargin) / kWidth;
  const double height = (high->y - low->y + 2 * kMargin) / unit;
  const View view(left->x - kMargin, low->y - kMargin, unit, height);

  std::vector<Layer> layers;
  std::string svg = fmt::format(
      "<svg class=\"map plain\" id=\"map\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"path "
      "and landmarks\">\n",
      kWidth, number(height));
  const auto add = [&](const std::string& layer, const char* style, std::string label, bool shown) {
    svg += layer;
    layers.push_back({style, std::move(label), shown});
  };
  const auto add_dots = [&](const std::vector<Point>& at, const char* style, std::string label,
                            bool shown) {
    if (at.empty()) return;
    add(fmt::format("<path class=\"layer line {}\" d=\"{}\"/>\n", style, dots(at, view)), style,
        std::move(label), shown);
  };
  add(line_layer("odometry", way_through(d.wheels, of_stamped), view), "odometry", "wheels alone",
      false);
  add_dots(sightings_of(run.ekf.map), "seen", "sightings, as seen then", false);
  add_dots(sightings_of(run.graph.map), "known", "sightings, as known at last", false);
  std::vector<Point> fixes, trunks;
  for (const eval::ReferenceFix& f : d.fixes.fixes) fixes.push_back(point(f.p));
  for (const Vec2& p : d.trunks) trunks.push_back(point(p));
  add_dots(fixes, "fixes", "satellite fixes", true);
  add(landmark_layer(run.graph.map.landmarks, view), "ellipses", "landmarks, 95 %", true);
  add_dots(trunks, "trunks", "true trunks", true);
  if (!d.truth.empty())
    add(line_layer("truth", way_through(d.truth, of_stamped), view), "truth", "true path", true);
  add(line_layer("before", way_through(run.ekf.map.localization.estimates, of_estimate), view),
      "before", "EKF-SLAM, as known then", true);
  add(line_layer("after", graph, view), "after", "landmark graph", true);
  svg += scale_bar(view, kWidth, height) + "</svg>\n";
  return section(
      "Path and obstacles",
      switched_map(std::move(svg), layers) +
          soft("Drag to move; double click or Ctrl and the wheel to zoom; landmarks tell "
               "more under the pointer."));
}

// ---- Errors ----------------------------------------------------------------------------------

Row error_row(const Demonstration& d, Feed feed, Against against, bool graph) {
  const auto errors = eval::pooled(d, feed, against, graph);
  const Headline sound = eval::headline(errors), all = eval::headline(errors, false);
  return {fmt::format("{}, {}", eval::name_of(feed), eval::name_of(against)),
          graph ? "graph" : "EKF",
          number(sound.mean.mean),
          fmt::format("{} to {}", number(sound.mean.low), number(sound.mean.high)),
          number(sound.stats.median),
          number(sound.stats.max, 1),
          fmt::format("{} ({})", number(all.stats.mean), all.stats.count),
          std::to_string(sound.stats.count),
          sound.nis ? number(*sound.nis, 1) : ""};
}

std::string error_section(const Demonstration& d) {
  const Row head = {"",
                    "method",
                    "mean, m",
                    "95 % of the mean",
                    "median, m",
                    "max, m",
                    "mean of all (number)",
                    "number",
                    d.truth.empty() ? "NIS (2)" : "NEES (3)"};
  std::vector<Row> rows;
  for (const DemonstrationRun& run : d.runs)
    for (const eval::PathScore& s : run.ekf.scores)
      for (const bool graph : {false, true}) {
        Row row = error_row(d, run.feed, s.against, graph);
        if (std::find(rows.begin(), rows.end(), row) == rows.end()) rows.push_back(std::move(row));
      }
  return section(
      "The robot's place",
      table(head, rows) +
          soft("EKF-SLAM: as known at each time. Graph: as known at last. Sound references, beside "
               "them all there are. In brackets what an honest covariance gives in the mean.") +
          figure_in_page(errors_over_time(d), "errors over time"));
}

Row obstacle_row(const Demonstration& d, const DemonstrationRun& run, bool graph) {
  const DemonstrationAnswer& a = graph ? run.graph : run.ekf;
  Row row = {eval::name_of(run.feed), graph ? "graph" : "EKF",
             std::to_string(a.map.landmarks.size()), number(a.obstacles.split.error.mean)};
  if (const auto& maps = a.obstacles.maps)
    row.insert(row.end(), {number(maps->error.mean), number(maps->error.median),
                           number(eval::aligned(*maps).error.mean)});
  else
    row.insert(row.end(), {"", "", ""});
  row.push_back(std::to_string(a.obstacles.split.error.count));
  if (!a.obstacles.match) return row;
  const eval::LandmarkMatch& match = *a.obstacles.match;
  const Headline h = eval::headline(match, d.trunks);
  row.insert(row.end(), {number(h.mean.mean, 3), number(h.stats.median, 3), number(h.stats.max),
                         number(a.obstacles.aligned->error.mean, 3),
                         std::to_string(match.pairs.size()), std::to_string(match.missed.size()),
                         std::to_string(match.mistaken.size()), h.nis ? number(*h.nis, 1) : ""});
  return row;
}

std::string range_words(const Demonstration& d) {
  const auto bins = eval::errors_over_range(eval::sightings_of(d), 5, 30);
  if (bins.size() < 2) return "";
  const eval::RangeBin &near = bins.front(), &far = bins.back();
  std::string words = fmt::format(
      "A sighting errs, root of the mean square, by {} along and {} across the beam at {} m, by {} "
      "and {} at {} m.",
      metres(near.along), metres(near.across), number(near.range, 1), metres(far.along),
      metres(far.across), number(far.range, 1));
  if (!d.truth.empty())
    words += fmt::format(
        " Of that across, at {} m, the heading is to blame for {} and the laser for {}.",
        number(far.range, 1), metres(far.by_heading), metres(far.by_laser));
  else
    words += " Here against the map that the sightings made.";
  return words + " 1° at 30 m is 0.52 m; the laser's own error is some 35 mm.";
}

std::string obstacle_section(const Demonstration& d) {
  Row head = {"",          "method",           "landmarks", "halves, one path: m", "two maps: m",
              "median, m", "aligned: mean, m", "number"};
  if (!d.trunks.empty())
    head.insert(head.end(), {"error: mean, m", "median, m", "max, m", "aligned: mean, m", "trunks",
                             "missed", "no trunks", "NEES (2)"});
  std::vector<Row> rows;
  for (const DemonstrationRun& run : d.runs)
    for (const bool graph : {false, true}) rows.push_back(obstacle_row(d, run, graph));
  return section(
      "The obstacles",
      table(head, rows) +
          soft("How far apart each trunk stands by what was seen of it in the even and in the "
               "odd minutes: on one path, and in two maps that were made of them separately, "
               "before and after one alignment.") +
          soft(range_words(d)) + figure_in_page(errors_over_range(d), "errors over range"));
}

std::string consistency_section(const Demonstration& d) {
  return section(
      "Are the covariances honest?",
      figure_in_page(consistency_over_time(d), "consistency over time") +
          soft("1 is honest, above it the filter is surer than it may be, below less sure. The "
               "landmarks' own is low on purpose: what sightings from one side have in "
               "common counts once a metre, so each correction is weighed as if it erred "
               "more than it does."));
}

std::string learnt_section(const Demonstration& d) {
  std::vector<Row> rows;
  for (const localize::LearntValue& v : d.with_all().graph.map.localization.learnt)
    rows.push_back(
        {v.name, number(v.value, 4), "± " + number(v.sigma, 4), v.unit == "1" ? "" : v.unit});
  return section("What the car turned out to be", table({"", "", "", ""}, rows));
}

std::string happened_section(const Demonstration& d) {
  std::vector<std::string> words;
  for (const DemonstrationRun& run : d.runs) {
    std::int64_t health[3] = {};
    for (const Estimate& e : run.ekf.map.localization.estimates)
      ++health[static_cast<std::size_t>(e.health)];
    std::string text = fmt::format("{}: {} poses ok, {} degraded, {} lost", eval::name_of(run.feed),
                                   health[0], health[1], health[2]);
    for (const auto& [what, entry] : run.ekf.map.localization.report.entries())
      text += fmt::format("; {} x {}", entry.count, what);
    words.push_back(text);
  }
  return section("What happened", list(words));
}

std::string time_section(const Demonstration& d) {
  std::vector<Row> rows;
  for (const DemonstrationRun& run : d.runs)
    rows.push_back({eval::name_of(run.feed), number(run.ekf.cpu), number(run.graph.cpu)});
  if (d.alone().ekf.cpu <= 0) return "";
  return section("Time it took", table({"CPU, s", "EKF-SLAM", "graph, after it"}, rows) +
                                     figure_in_page(time_over_size(d), "time over size"));
}

}  // namespace

std::string demonstration_html(const Demonstration& d, const DemonstrationPage& about) {
  const Headline place = place_headline(d);
  const std::string lead = fmt::format(
      "The robot's place is known to {} in the mean ({} at the worst), the obstacles' to {}.",
      metres(place.mean.mean), metres(place.stats.max),
      metres(obstacle_headline(d, d.with_all().graph).mean.mean));
  return page(about.log + ": the demonstration", lead,
              tiles(d) + against_section(d) + map_section(d) + error_section(d) +
                  obstacle_section(d) + consistency_section(d) + learnt_section(d) +
                  happened_section(d) + time_section(d),
              fmt::format("Drawn by majak{}{}.", about.version.empty() ? "" : " ", about.version));
}

}  // namespace majak::draw
