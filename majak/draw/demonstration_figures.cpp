// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/demonstration_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "majak/draw/sketch.hpp"

namespace majak::draw {
namespace {

using eval::Against;
using eval::Demonstration;
using eval::DemonstrationRun;
using eval::Feed;
using eval::PathScore;

const Colour kEkf = ink::blue, kGraph = ink::green, kTruth = ink::red, kFix = ink::orange,
             kWheels = ink::grey;
constexpr double kAround = 12;      // m about the path on the whole map
constexpr double kForLegend = 0.3;  // of the path's width, to the left of it
constexpr double kDetail = 44;      // m, sides of the part that is enlarged
constexpr double kBin = 5;          // m of range
constexpr std::size_t kLeast = 30;  // sightings in a bin that is shown

struct Extent {
  double left = 1e300, bottom = 1e300, right = -1e300, top = -1e300;
  void add(const Vec2& p) {
    left = std::min(left, p.x()), right = std::max(right, p.x());
    bottom = std::min(bottom, p.y()), top = std::max(top, p.y());
  }
};

std::vector<Point> way_of(const slam::LandmarkMap& map) {
  std::vector<Point> way;
  for (const Estimate& e : map.localization.estimates)
    way.push_back(point(e.T_map_robot.translation()));
  return way;
}

std::vector<Point> way_of(const eval::Trajectory& trajectory) {
  std::vector<Point> way;
  for (const eval::StampedPose& p : trajectory) way.push_back(point(p.pose.translation()));
  return way;
}

// ---- The map ---------------------------------------------------------------------------------

Extent extent_of(const Demonstration& d) {
  Extent extent;
  for (const Estimate& e : d.with_all().graph.map.localization.estimates)
    extent.add(e.T_map_robot.translation());
  return extent;
}

/// Where the robot came by in the most different minutes: there loops must coincide.
Vec2 most_passed(const Demonstration& d) {
  constexpr double kCell = 10;  // m
  std::map<std::pair<long, long>, std::set<long>> minutes;
  for (const Estimate& e : d.with_all().graph.map.localization.estimates)
    minutes[{std::lround(e.T_map_robot.x / kCell), std::lround(e.T_map_robot.y / kCell)}].insert(
        std::lround(to_seconds(e.time) / 60));
  const auto most = std::max_element(
      minutes.begin(), minutes.end(),
      [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
  return kCell * Vec2(double(most->first.first), double(most->first.second));
}

void add_map(std::vector<Mark>& marks, const Demonstration& d, double magnified) {
  const DemonstrationRun& run = d.with_all();
  marks.emplace_back(Polyline{way_of(d.wheels), {kWheels.faint(0.6), 1.2, 5}});
  Dots fixes{{}, 2.0, kFix.faint(0.7)}, trunks{{}, 2.4, kTruth.faint(0.7)};
  for (const eval::ReferenceFix& f : d.fixes.fixes) fixes.at.push_back(point(f.p));
  for (const Vec2& p : d.trunks) trunks.at.push_back(point(p));
  marks.emplace_back(std::move(fixes));
  marks.emplace_back(std::move(trunks));
  for (const slam::MappedLandmark& l : run.graph.map.landmarks)
    if (!l.gone)
      marks.emplace_back(
          covariance_ellipse(l.p_map, magnified * magnified * l.covariance, {ink::purple, 1.2}));
  if (!d.truth.empty()) marks.emplace_back(Polyline{way_of(d.truth), {kTruth, 2}});
  marks.emplace_back(Polyline{way_of(run.ekf.map), {kEkf, 1.2}});
  marks.emplace_back(Polyline{way_of(run.graph.map), {kGraph, 1.8}});
}

Panel whole_map(const Box& place, const Demonstration& d) {
  constexpr double kMagnified = 4;
  const Extent e = extent_of(d);
  Panel panel{
      .place = place,
      .title = "Path and trunks, with all satellites",
      .x = {"east (m)", e.left - kAround - kForLegend * (e.right - e.left), e.right + kAround},
      .y = {"north (m)", e.bottom - kAround, e.top + kAround}};
  add_map(panel.marks, d, kMagnified);
  panel.legend = {{"landmark graph", Pen{kGraph, 1.8}},
                  {"EKF-SLAM", Pen{kEkf, 1.2}},
                  {"wheels alone", Pen{kWheels.faint(0.6), 1.2, 5}},
                  {fmt::format("landmark, 95 % x {:.0f}", kMagnified), Pen{ink::purple, 1.2}}};
  if (!d.fixes.fixes.empty()) panel.legend.push_back({"satellite fix", {}, kFix});
  if (!d.truth.empty()) panel.legend.push_back({"true path", Pen{kTruth, 2}});
  if (!d.trunks.empty()) panel.legend.push_back({"true trunk", {}, kTruth});
  panel.legend_at = Corner::top_left;
  return panel;
}

Panel detail(const Box& place, const Demonstration& d) {
  const Vec2 at = most_passed(d);
  Panel panel{.place = place,
              .title = "Where most ways meet, ellipses in true size",
              .x = {"east (m)", at.x() - kDetail / 2, at.x() + kDetail / 2},
              .y = {"north (m)", at.y() - kDetail / 2, at.y() + kDetail / 2}};
  add_map(panel.marks, d, 1);
  return panel;
}

// ---- Errors over time ------------------------------------------------------------------------

/// Lines that break where the reference does.
void add_errors(Panel& panel, const eval::DemonstrationAnswer& answer, Against against,
                const Colour& colour, Time begin) {
  constexpr Duration kBreak = 5 * kSecond;
  for (const PathScore& s : answer.scores) {
    if (s.against != against) continue;
    Polyline line{{}, {colour, 2.4}};
    Time last = 0;
    const auto flush = [&] {
      if (!line.points.empty()) panel.marks.emplace_back(line);
      line.points.clear();
    };
    for (const eval::PlaceError& e : s.errors) {
      if (!e.sound) continue;
      if (e.time - last > kBreak) flush();
      line.points.push_back({to_seconds(e.time - begin) / 60, e.error()});
      last = e.time;
    }
    flush();
  }
}

Panel errors_of(const Box& place, const Demonstration& d, Feed feed, Against against,
                std::string title) {
  Panel panel{.place = place,
              .title = std::move(title),
              .x = {"time (min)"},
              .y = {"error (m)", 0.0},
              .equal = false};
  const auto& estimates = d.with_all().graph.map.localization.estimates;
  const Time begin = estimates.front().time;
  panel.x.low = 0, panel.x.high = to_seconds(estimates.back().time - begin) / 60;
  for (const DemonstrationRun& run : d.runs) {
    if (run.feed != feed) continue;
    add_errors(panel, run.ekf, against, kEkf, begin);
    add_errors(panel, run.graph, against, kGraph, begin);
  }
  panel.legend = {{"EKF-SLAM, then", Pen{kEkf, 1.6}},
                  {"landmark graph, at last", Pen{kGraph, 1.6}}};
  return panel;
}

struct ErrorPanel {
  Feed feed;
  Against against;
  const char* title;
};

std::vector<ErrorPanel> error_panels(const Demonstration& d) {
  std::vector<ErrorPanel> panels;
  const bool known = !d.truth.empty();
  panels.push_back({Feed::none, Against::aligned, "Without satellites, after one alignment"});
  if (d.fixes.fixes.empty()) return panels;
  if (known) {
    panels.push_back({Feed::cut_off, Against::held_out, "Satellites cut off for minutes"});
    panels.push_back({Feed::all, Against::held_out, "With satellites"});
  } else {
    panels.push_back({Feed::fold, Against::held_out, "With satellites: bursts that were held out"});
    panels.push_back({Feed::cut_off, Against::held_out, "Satellites cut off for minutes"});
  }
  return panels;
}

// ---- Errors over range -----------------------------------------------------------------------

Panel errors_at_range(const Box& place, const Demonstration& d, bool across) {
  const auto& sightings = eval::sightings_of(d);
  const auto bins = eval::errors_over_range(sightings, kBin, kLeast);
  Panel panel{.place = place,
              .title = across ? "Across the beam: the heading" : "Along the beam: the laser",
              .x = {"range (m)", 0.0},
              .y = {"error (m)", 0.0},
              .equal = false};
  Dots each{{}, 1.0, ink::purple.faint(0.35)};
  std::vector<double> sizes;
  const std::size_t step = std::max<std::size_t>(1, sightings.size() / 6000);
  for (std::size_t i = 0; i < sightings.size(); i += step) {
    each.at.push_back({sightings[i].range, std::abs(sightings[i].error(across ? 1 : 0))});
    sizes.push_back(each.at.back().y);
  }
  panel.y.high = std::max(0.2, 1.2 * eval::quantile(sizes, 0.99));
  Polyline whole{{}, {kEkf, 2.4}}, heading{{}, {kGraph, 2, 5}}, laser{{}, {kFix, 2}};
  for (const eval::RangeBin& bin : bins) {
    whole.points.push_back({bin.range, across ? bin.across : bin.along});
    heading.points.push_back({bin.range, bin.by_heading});
    laser.points.push_back({bin.range, bin.by_laser});
  }
  panel.marks = {each, whole};
  panel.legend = {{"each sighting", {}, ink::purple.faint(0.5)}, {"root mean square", whole.pen}};
  panel.legend_at = Corner::top_left;
  if (!across || d.truth.empty()) return panel;
  panel.marks.emplace_back(heading), panel.marks.emplace_back(laser);
  panel.legend.push_back({"of it, by the heading", heading.pen});
  panel.legend.push_back({"of it, by the laser", laser.pen});
  return panel;
}

}  // namespace

Figure demonstration_picture(const Demonstration& d) {
  Figure figure{
      .width = 1400,
      .height = 1150,
      .title = "The demonstration: where the car was, what stands there, how wrong it is"};
  const Box all = figure.whole();
  const double split = 700, right = 820;
  const Box below{0, all.top + split, all.width, all.height - split};
  figure.panels = {whole_map({0, all.top, right, split}, d),
                   detail({right, all.top, all.width - right, split}, d)};
  const ErrorPanel first = error_panels(d).front(), second = error_panels(d).back();
  const double third = all.width / 3;
  figure.panels.push_back(
      errors_of({0, below.top, third, below.height}, d, first.feed, first.against, first.title));
  const auto kind = d.truth.empty() && error_panels(d).size() > 1 ? error_panels(d)[1] : second;
  figure.panels.push_back(
      errors_of({third, below.top, third, below.height}, d, kind.feed, kind.against, kind.title));
  figure.panels.push_back(errors_at_range({2 * third, below.top, third, below.height}, d, true));
  return figure;
}

Figure errors_over_time(const Demonstration& d) {
  const auto panels = error_panels(d);
  Figure figure{.width = 1000, .height = 260.0 * double(panels.size())};
  double top = 0;
  for (const ErrorPanel& p : panels) {
    figure.panels.push_back(errors_of({0, top, figure.width, 260}, d, p.feed, p.against, p.title));
    top += 260;
  }
  return figure;
}

Figure errors_over_range(const Demonstration& d) {
  Figure figure{.width = 1000, .height = 380};
  figure.panels = {errors_at_range({0, 0, 500, 380}, d, false),
                   errors_at_range({500, 0, 500, 380}, d, true)};
  return figure;
}

Figure consistency_over_time(const Demonstration& d) {
  Figure figure{.width = 1000, .height = 300};
  const auto& localization = d.with_all().ekf.map.localization;
  const Time begin = localization.estimates.front().time;
  Panel panel{.place = figure.whole(),
              .title = "What was measured against what was expected, by degree of freedom",
              .x = {"time (min)"},
              .y = {"NIS", 0.0},
              .equal = false};
  std::map<long, std::pair<double, double>> landmarks, pose;
  for (const localize::Innovation& i : localization.innovations)
    if (std::string_view(i.sensor) == "landmarks") {
      auto& [sum, dof] = landmarks[std::lround(to_seconds(i.time - begin) / 60)];
      sum += i.nis, dof += i.dof;
    }
  Polyline line{{}, {ink::purple, 1.8}}, nees{{}, {kTruth, 1.8}};
  for (const auto& [minute, sums] : landmarks)
    line.points.push_back({double(minute), sums.first / sums.second});
  panel.marks = {line};
  panel.legend = {{"NIS of the landmarks", line.pen}};
  if (!d.truth.empty()) {
    for (const PathScore& s : d.with_all().ekf.scores)
      for (const eval::PlaceError& e : s.errors)
        if (e.nis) {
          auto& [sum, dof] = pose[std::lround(to_seconds(e.time - begin) / 60)];
          sum += *e.nis, dof += 3;
        }
    for (const auto& [minute, sums] : pose)
      nees.points.push_back({double(minute), sums.first / sums.second});
    panel.marks.emplace_back(nees);
    panel.legend.push_back({"NEES of the pose, EKF-SLAM", nees.pen});
  }
  const double minutes = to_seconds(localization.estimates.back().time - begin) / 60;
  panel.marks.emplace_back(Polyline{{{0, 1}, {minutes, 1}}, {ink::grey, 1, 4}});
  figure.panels = {panel};
  return figure;
}

Figure time_over_size(const Demonstration& d) {
  Figure figure{.width = 1000, .height = 300};
  Panel panel{.place = figure.whole(),
              .title = "Time of a scan in EKF-SLAM, over the size of the map",
              .x = {"landmarks", 0.0},
              .y = {"ms", 0.0},
              .equal = false};
  Dots each{{}, 1.0, kEkf.faint(0.3)};
  std::map<std::size_t, std::pair<double, double>> bins;
  std::vector<double> sizes;
  for (const eval::StepTime& s : d.alone().steps) {
    each.at.push_back({double(s.landmarks), 1e3 * s.seconds});
    sizes.push_back(1e3 * s.seconds);
    auto& [sum, count] = bins[s.landmarks / 10];
    sum += 1e3 * s.seconds, count += 1;
  }
  panel.y.high = std::max(0.1, 1.5 * eval::quantile(sizes, 0.99));
  Polyline mean{{}, {kTruth, 2}};
  for (const auto& [bin, sums] : bins)
    mean.points.push_back({10 * double(bin) + 5, sums.first / sums.second});
  panel.marks = {each, mean};
  panel.legend = {{"each scan", {}, kEkf}, {"their mean", mean.pen}};
  figure.panels = {panel};
  return figure;
}

}  // namespace majak::draw
