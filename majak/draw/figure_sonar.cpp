// SPDX-License-Identifier: Apache-2.0
// Figure 16 of the thesis: an underwater vehicle maps fourteen features by sonar. What it errs goes
// into the map, farther on ever more; when it comes back to where it began, all ellipses shrink.
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "majak/draw/sketch.hpp"
#include "majak/draw/sonar_drive.hpp"
#include "majak/draw/thesis_figures.hpp"

namespace majak::draw {
namespace {

constexpr std::uint64_t kSeed = 1;
constexpr int kAfter = 30;  // steps shown after the loop has closed
const Colour kFeature = ink::blue, kTruth = ink::red, kEstimate = ink::green, kSonar = ink::orange;

using Ways = std::vector<std::vector<Point>>;

/// The drive up to now; ways: true, estimated, dead reckoned.
struct Log {
  SonarDrive drive{kSeed};
  Ways ways = Ways(3, {{0, 0}});
  Ways half_axes = Ways(kSonarFeatures);  ///< of each feature's ellipse over the steps
  void step() {
    drive.step();
    const Pose2 poses[] = {drive.truth(), drive.estimate(), drive.dead_reckoned()};
    for (std::size_t k = 0; k < 3; ++k) ways[k].push_back(point(poses[k].translation()));
    for (int i = 0; i < kSonarFeatures; ++i)
      if (const auto f = drive.feature(i))
        half_axes[static_cast<std::size_t>(i)].push_back(
            {drive.steps() * kSonarStep, covariance_ellipse(f->p_map, f->covariance, {}).rx});
  }
};

Ellipse shaded(Ellipse ellipse) {
  ellipse.fill = ellipse.pen.colour.faint(0.12);
  return ellipse;
}

/// The vehicle, where its sonar reaches, and what answered.
void add_vehicle(std::vector<Mark>& marks, const SonarDrive& drive) {
  const Pose2& at = drive.truth();
  const Point here = point(at.translation());
  marks.emplace_back(circle(here, kSonarReach, {kSonar.faint(0.7), 1.2, 5}));
  for (const int i : drive.heard())
    marks.emplace_back(Polyline{{here, point(sonar_features()[static_cast<std::size_t>(i)])},
                                {kSonar.faint(0.7), 1.2}});
  marks.emplace_back(Ellipse{here, 2.2, 0.75, at.theta, {kSonar, 1.2}, kSonar});
  marks.emplace_back(
      Polyline{{point(at * Vec2(-2, 0)), point(at * Vec2(-3.2, 1)), point(at * Vec2(-3.2, -1))},
               {kSonar, 1.2},
               true,
               kSonar});
}

Panel plane(const Box& place, const Log& log, std::string title) {
  const SonarDrive& drive = log.drive;
  Panel panel{.place = place,
              .title = std::move(title),
              .x = {"x (m)", -42.0, 46.0},
              .y = {"y (m)", -14.0, 52.0}};
  add_vehicle(panel.marks, drive);
  panel.marks.emplace_back(Polyline{log.ways[2], {ink::grey, 1.4, 5}});
  panel.marks.emplace_back(Polyline{log.ways[0], {kTruth, 2}});
  panel.marks.emplace_back(Polyline{log.ways[1], {kEstimate, 2}});
  panel.marks.emplace_back(shaded(
      covariance_ellipse(drive.estimate().translation(), drive.covariance(), {kEstimate, 1.4})));
  Dots estimates{{}, 2.6, kFeature}, truths{{}, 2.6, kTruth};
  for (int i = 0; i < kSonarFeatures; ++i) {
    const auto f = drive.feature(i);
    if (!f) continue;
    panel.marks.emplace_back(shaded(covariance_ellipse(f->p_map, f->covariance, {kFeature, 1.4})));
    estimates.at.push_back(point(f->p_map));
    truths.at.push_back(point(sonar_features()[static_cast<std::size_t>(i)]));
  }
  panel.marks.emplace_back(std::move(estimates));
  panel.marks.emplace_back(std::move(truths));
  return panel;
}

std::vector<LegendEntry> legend() {
  return {{"true way", Pen{kTruth, 2}},
          {"estimated way", Pen{kEstimate, 2}},
          {"dead reckoning", Pen{ink::grey, 1.4, 5}},
          {"true feature", {}, kTruth},
          {"estimated, 95 %", Pen{kFeature, 1.4}, kFeature},
          {"sonar's reach", Pen{kSonar, 1.2, 5}}};
}

/// Longer half axes of all ellipses over the way.
Panel sizes(const Box& place, const Log& log, int closed) {
  Panel panel{.place = place,
              .title = "Each feature's ellipse: how long its longer half axis is",
              .x = {"way (m)", 0.0, log.drive.steps() * kSonarStep},
              .y = {"half axis (m)", 0.0, {}},
              .equal = false};
  double longest = 0;
  for (const auto& line : log.half_axes) {
    for (const Point& p : line) longest = std::max(longest, p.y);
    panel.marks.emplace_back(Polyline{line, {kFeature, 1.5}});
  }
  panel.y.high = 1.25 * longest;
  const double at = (closed - 0.5) * kSonarStep;
  panel.marks.emplace_back(Polyline{{{at, 0}, {at, *panel.y.high}}, {kSonar, 2, 5}});
  panel.marks.emplace_back(Label{{at, 1.12 * longest},
                                 "a feature from the beginning is heard again",
                                 -10,
                                 0,
                                 Anchor::end,
                                 15,
                                 ink::black});
  return panel;
}

}  // namespace

Figure figure_sonar(const std::vector<Event>&) {
  Log now;
  Log before = now;
  while (!now.drive.loop_closes()) before = now, now.step();
  const int closed = now.drive.steps();
  for (int k = 0; k < kAfter; ++k) now.step();
  Figure figure{
      .width = 1300,
      .height = 940,
      .title = "EKF-SLAM: fourteen features by sonar, with their 95 % ellipses in true size"};
  const Box all = figure.whole();
  const double half = all.width / 2, split = 570;
  const auto at = [](const char* when, const Log& log) {
    return fmt::format("{}: after {:.0f} m", when, log.drive.steps() * kSonarStep);
  };
  figure.panels = {plane({0, all.top, half, split}, before, at("Before the loop closes", before)),
                   plane({half, all.top, half, split}, now, at("It has closed", now)),
                   sizes({0, all.top + split, all.width, all.height - split}, now, closed)};
  figure.panels[2].legend = legend();  // where there is room
  figure.panels[2].legend_at = Corner::top_left;
  return figure;
}

}  // namespace majak::draw
