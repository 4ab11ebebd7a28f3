// SPDX-License-Identifier: Apache-2.0
// Figure 15 of the thesis: simultaneous localization and mapping as a diagram, its boxes filled
// with what a drive through a building truly gave.
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "majak/draw/mapped_drive.hpp"
#include "majak/draw/sketch.hpp"
#include "majak/draw/thesis_figures.hpp"
#include "majak/match/scan_points.hpp"
#include "majak/motion/path_uncertainty.hpp"
#include "majak/motion/wheel_noise.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/simulator.hpp"
#include "majak/sim/tour.hpp"

namespace majak::draw {
namespace {

constexpr double kWidth = 1240, kHeight = 640, kFirstLine = 30, kLine = 24, kEnlarged = 20;
constexpr Box kScan{20, 60, 320, 265}, kMotion{20, 355, 320, 265}, kMiddle{440, 205, 310, 250},
    kResult{850, 160, 370, 340};

/// A point of the sheet, whose y points down, in the panel of the boxes.
Point at(double left, double top) { return {left, kHeight - top}; }

/// A box with lines of text from its top.
void add_box(std::vector<Mark>& marks, const Box& b, const std::vector<std::string>& lines,
             const Colour& colour) {
  const double right = b.left + b.width, bottom = b.top + b.height;
  marks.emplace_back(
      Polyline{{at(b.left, b.top), at(right, b.top), at(right, bottom), at(b.left, bottom)},
               {colour, 2},
               true,
               colour.faint(0.05)});
  double top = b.top + kFirstLine;
  for (const std::string& line : lines) {
    marks.emplace_back(Label{at(b.left + b.width / 2, top), line, 0, 0, Anchor::middle});
    top += kLine;
  }
}

/// What is left of a box below so many lines.
Box below(const Box& b, int lines) {
  const double top = kFirstLine + kLine * (lines - 1);
  return {b.left, b.top + top, b.width, b.height - top};
}

Panel boxes() {
  constexpr double kMargin = 12;  // of a panel without a frame
  Panel panel{.place = {-kMargin, -kMargin, kWidth + 2 * kMargin, kHeight + 2 * kMargin},
              .x = {"", 0.0, kWidth},
              .y = {"", 0.0, kHeight},
              .framed = false};
  add_box(panel.marks, kScan, {"Observation z: what the laser saw"}, ink::orange);
  add_box(panel.marks, kMotion,
          {"Motion u: what the wheels counted", "(95 % ellipses of wheels that slip)"},
          ink::purple);
  add_box(panel.marks, kMiddle,
          {"Which path x and which map m,", "taken together,", "explain all z and all u best?", "",
           "observation model  p(z | x, m)", "motion model  p(x' | x, u)", "", "p(x, m | z, u)",
           "= c · p(z | x, m) · p(x | u) · p(m)"},
          ink::black);
  add_box(panel.marks, kResult,
          {"Path and map, one estimate", "(95 % ellipses, 20 times as large)"}, ink::blue);
  const double scan_out = kScan.left + kScan.width, result_in = kResult.left;
  const double middle_in = kMiddle.left, middle_out = kMiddle.left + kMiddle.width;
  const Pen pen{ink::black, 2.4};
  panel.marks.emplace_back(Arrow{at(scan_out + 6, 215), at(middle_in - 6, 275), pen});
  panel.marks.emplace_back(Arrow{at(scan_out + 6, 465), at(middle_in - 6, 385), pen});
  panel.marks.emplace_back(Arrow{at(middle_out + 6, 330), at(result_in - 6, 330), pen});
  // The way back.
  const double down = kResult.left + kResult.width / 2, up = kMiddle.left + kMiddle.width / 2;
  panel.marks.emplace_back(
      Polyline{{at(down, kResult.top + kResult.height + 6), at(down, 590), at(up, 590)}, pen});
  panel.marks.emplace_back(Arrow{at(up, 590), at(up, kMiddle.top + kMiddle.height + 6), pen});
  panel.marks.emplace_back(Label{at((up + down) / 2, 616),
                                 "the place is found in the map, the map is drawn from the place",
                                 0, 0, Anchor::middle});
  return panel;
}

Panel picture(const Box& box, int lines, std::vector<Mark> marks) {
  return {.place = below(box, lines), .framed = false, .marks = std::move(marks)};
}

/// The robot looks up the sheet.
std::vector<Mark> scan_marks(const Scan& scan) {
  const auto points = match::scan_points(scan, {.max_range = 15}, false);
  Dots returns{{}, 1.8, ink::orange};
  std::vector<Mark> marks;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Point p = point(kLooksUp * Vec2(points.x[i], points.y[i]));
    marks.emplace_back(Polyline{{{0, 0}, p}, {ink::orange.faint(0.3), 0.7}});
    returns.at.push_back(p);
  }
  marks.emplace_back(std::move(returns));
  marks.emplace_back(Dots{{{0, 0}}, 5, ink::black});
  return marks;
}

/// Three metres round a bend by two wheels that slip, with where the robot may be by then.
std::vector<Mark> motion_marks() {
  constexpr int kSteps = 30;
  const motion::Differential drive{0.4};
  const auto wheels = drive.inverse({0.1, 0, -0.035});
  const Vec3 twist = drive.forward(wheels);
  motion::PathUncertainty uncertainty;
  const Pose2 start{0, 0, radians(30)};
  Pose2 pose = start;
  std::vector<Mark> marks;
  for (int i = 1; i <= kSteps; ++i) {
    pose = pose * exp(twist);
    uncertainty.move(twist, motion::random_part({.slip = 0.02}, drive, wheels));
    if (i % (kSteps / 3) == 0)
      marks.emplace_back(Polyline{bent_ellipse(pose, uncertainty.covariance()),
                                  {ink::purple, 1.6},
                                  true,
                                  ink::purple.faint(0.1)});
  }
  marks.emplace_back(Polyline{way_of({0, 0}, start, kSteps * twist), {ink::black, 1.8}});
  for (const Pose2& robot : {start, pose})
    for (const double side : {0.2, -0.2})
      marks.emplace_back(wheel(robot * Pose2{0, side, 0}, ink::purple));
  return marks;
}

std::vector<Mark> result_marks(const MappedDrive& drive) {
  constexpr double kChi95 = 5.991464547107979;
  std::vector<Mark> marks{
      Dots{map_cells(drive, drive.closed, 0, drive.truth.size(), 0.1), 0.8, ink::blue},
      Polyline{way_through(drive.closed), {ink::red, 1.6}}};
  constexpr std::size_t kEvery = 100;
  for (std::size_t i = kEvery; i < drive.closed.size(); i += kEvery) {
    const Estimate& estimate = drive.site.scans[i].estimate;
    Ellipse ellipse =
        covariance_ellipse(drive.closed[i].translation(), estimate.covariance.topLeftCorner<2, 2>(),
                           {ink::red, 1.2}, kChi95 * kEnlarged * kEnlarged);
    ellipse.angle += (drive.closed[i] * estimate.T_map_robot.inverse()).theta;
    ellipse.fill = ink::red.faint(0.12);
    marks.emplace_back(ellipse);
  }
  return marks;
}

/// In the hall, where there is something to see.
const Scan& telling_scan(const MappedDrive& drive) {
  const Vec2 hall(17, 12.4);
  const auto nearest =
      std::min_element(drive.truth.begin(), drive.truth.end(), [&](const Pose2& a, const Pose2& b) {
        return (a.translation() - hall).norm() < (b.translation() - hall).norm();
      });
  return drive.site.scans[static_cast<std::size_t>(nearest - drive.truth.begin())].scan;
}

}  // namespace

Figure figure_slam(const std::vector<Event>&) {
  const sim::World world(sim::building());
  const MappedDrive drive =
      map_drive(sim::simulate(world, sim::plan_tour(world, {.short_tour = true}), {}), {});
  Figure figure{.width = kWidth,
                .height = kHeight,
                .title = "SLAM: where the robot was, and what the place looks like, at once"};
  figure.panels = {boxes(), picture(kScan, 1, scan_marks(telling_scan(drive))),
                   picture(kMotion, 2, motion_marks()), picture(kResult, 2, result_marks(drive))};
  return figure;
}

}  // namespace majak::draw
