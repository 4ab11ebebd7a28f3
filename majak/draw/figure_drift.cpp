// SPDX-License-Identifier: Apache-2.0
// Figure 13 of the thesis: a robot whose wheels are not as its odometry believes.
#include <cmath>
#include <utility>

#include "majak/core/error.hpp"
#include "majak/draw/sketch.hpp"
#include "majak/draw/thesis_figures.hpp"
#include "majak/eval/ate_rpe.hpp"
#include "majak/localize/dead_reckoning.hpp"
#include "majak/motion/drive.hpp"

namespace majak::draw {
namespace {

constexpr double kTrack = 0.4, kBelievedTrack = 0.41;       // m
constexpr double kLeftScale = 1.003, kRightScale = 0.9975;  // believed way per true way

/// True and believed poses, from a common start.
using Pairs = std::vector<eval::PosePair>;

/// Three rounds of a rounded rectangle of 8 x 5 m, driven as the truth says, counted as the
/// mis-measured wheels say.
Pairs mismeasured_rounds() {
  constexpr double kStep = 0.05, kRadius = 1;
  const motion::Differential drive{kTrack}, believed{kBelievedTrack};
  Pairs pairs(1);
  const auto go = [&](double way, double turn) {
    const int steps = int(std::lround(way / kStep));
    for (int i = 0; i < steps; ++i) {
      const Vec3 twist(way / steps, 0, turn / steps);
      const auto w = drive.inverse(twist);
      const Vec3 seen = believed.forward({kLeftScale * w.left, kRightScale * w.right});
      const eval::PosePair& last = pairs.back();
      pairs.push_back({0, last.T_map_robot * exp(seen), last.T_reference_robot * exp(twist), true});
    }
  };
  for (int corner = 0; corner < 12; ++corner) {
    go(corner % 2 == 0 ? 6 : 3, 0);
    go(kRadius * kPi / 2, kPi / 2);
  }
  return pairs;
}

Pairs pairs_of(const std::vector<Event>& events) {
  const localize::Localizer localizer = localize::dead_reckoning({});
  std::vector<Truth> truth;
  eval::Trajectory reckoned;
  for (const Event& event : events) {
    if (const auto* t = std::get_if<Truth>(&event)) truth.push_back(*t);
    if (const auto e = localizer.add(event)) reckoned.push_back({e->time, e->T_map_robot});
  }
  Pairs pairs = eval::associate(reckoned, eval::truth_of(truth)).pairs;
  if (pairs.empty())
    throw Error("figure 13: the log must carry odometry and truth, as majak simulate writes them");
  const Pose2 T_map_reference =
      pairs.front().T_map_robot * pairs.front().T_reference_robot.inverse();
  for (eval::PosePair& p : pairs) p.T_reference_robot = T_map_reference * p.T_reference_robot;
  return pairs;
}

Panel paths_panel(const Box& place, const Pairs& pairs) {
  Panel panel{.place = place, .x = {"x (m)"}, .y = {"y (m)"}};
  std::vector<Point> truth, odometry;
  for (const eval::PosePair& p : pairs) {
    truth.push_back(point(p.T_reference_robot.translation()));
    odometry.push_back(point(p.T_map_robot.translation()));
  }
  const Point start = truth.front(), end = truth.back(), believed = odometry.back();
  panel.marks = {Polyline{simplify(truth, 1e-3), {ink::green, 2.4}},
                 Polyline{simplify(odometry, 1e-3), {ink::blue, 1.8}},
                 Polyline{{end, believed}, {ink::red, 1.4, 4}},
                 Dots{{start}, 5, ink::black},
                 Dots{{end}, 4.5, ink::green},
                 Dots{{believed}, 4.5, ink::blue}};
  panel.legend = {{"true trajectory", Pen{ink::green, 2.4}},
                  {"by odometry", Pen{ink::blue, 1.8}},
                  {"error at the end", Pen{ink::red, 1.4, 4}}};
  return panel;
}

Panel error_panel(const Box& place, const Pairs& pairs) {
  Panel panel{
      .place = place, .x = {"distance driven (m)", 0}, .y = {"error (m)", 0}, .equal = false};
  std::vector<Point> error;
  double way = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Vec2 here = pairs[i].T_reference_robot.translation();
    if (i > 0) way += (here - pairs[i - 1].T_reference_robot.translation()).norm();
    error.push_back({way, (pairs[i].T_map_robot.translation() - here).norm()});
  }
  panel.marks = {Polyline{simplify(error, 1e-3), {ink::red, 2.2}}};
  return panel;
}

}  // namespace

Figure figure_drift(const std::vector<Event>& events) {
  const Pairs pairs = events.empty() ? mismeasured_rounds() : pairs_of(events);
  Figure figure{.width = 900,
                .height = 900,
                .title = events.empty()
                             ? "Odometry of a mis-measured robot: its error grows with the way"
                             : "Odometry and truth: the error grows with the way"};
  const Box all = figure.whole();
  figure.panels.push_back(paths_panel({0, all.top, all.width, 580}, pairs));
  figure.panels.push_back(error_panel({0, all.top + 580, all.width, all.height - 590}, pairs));
  return figure;
}

}  // namespace majak::draw
