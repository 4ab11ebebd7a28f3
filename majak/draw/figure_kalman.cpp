// SPDX-License-Identifier: Apache-2.0
// Figure 8 of the thesis: a robot predicts its pose from its wheels and corrects it by fixes; and
// the filter of one number, whose gain settles at a tenth.
#include <cmath>
#include <vector>

#include "majak/core/random.hpp"
#include "majak/draw/sketch.hpp"
#include "majak/draw/thesis_figures.hpp"
#include "majak/filter/pose_filter.hpp"
#include "majak/filter/scalar_kalman.hpp"
#include "majak/motion/path_uncertainty.hpp"

namespace majak::draw {
namespace {

constexpr int kSteps = 96, kEvery = 4;  // a fix at every fourth step: k = 4
constexpr double kStep = 0.25;          // m
constexpr double kFixSigma = 0.25;      // m
constexpr double kTrueScale = 1.06;     // way per counted way, which the filter finds out
constexpr std::uint64_t kSeed = 8;

using Belief = filter::PoseBelief<1>;

struct Drive {
  std::vector<Point> truth, wheels, estimate, fixes;
  std::vector<Mark> ellipses;
};

/// Relative information: a step of the wheels, whose way is to be scaled by the extra number.
filter::RelativeInput<1> step_of(const Vec3& counted, const Belief& belief) {
  filter::RelativeInput<1> step;
  step.at = belief.nominal.extra;
  const Vec3 twist(step.at(0) * counted.x(), 0, counted.z());
  step.T_from_to = exp(twist);
  step.by_extra = right_jacobian(twist) * Vec3(counted.x(), 0, 0);
  step.noise = Vec3(0.02 * 0.02, 0.01 * 0.01, 0.03 * 0.03).asDiagonal();
  return step;
}

/// Absolute information: where the robot is.
filter::AbsoluteInput<1, 2> fix_of(const Vec2& p_map, const Belief& belief) {
  filter::AbsoluteInput<1, 2> z;
  const Pose2& pose = belief.nominal.T_map_robot;
  z.residual = p_map - pose.translation();
  z.H.setZero();
  const double c = std::cos(pose.theta), s = std::sin(pose.theta);
  z.H.leftCols<2>() << c, -s, s, c;
  z.noise = kFixSigma * kFixSigma * Eigen::Matrix2d::Identity();
  return z;
}

Drive drive() {
  RandomStream random(kSeed);
  Belief belief;
  belief.nominal.extra(0) = 1;
  belief.covariance = Eigen::Vector4d(0.01, 0.01, 0.02, 0.01).asDiagonal();
  const Pose2 start{0, 0, -1.15};
  Pose2 truth = start, wheels = start;
  belief.nominal.T_map_robot = start;
  Drive d;
  d.truth = d.wheels = d.estimate = {{0, 0}};
  for (int k = 1; k <= kSteps; ++k) {
    const Vec3 counted(kStep, 0, 0.11 * std::sin(0.085 * k + 0.4));
    wheels = wheels * exp(counted);
    truth = truth * exp({kTrueScale * kStep + 0.02 * random.normal(), 0.01 * random.normal(),
                         counted.z() + 0.03 * random.normal()});
    belief.predict(step_of(counted, belief));
    if (k % kEvery == 0) {
      const Vec2 fix = truth.translation() + kFixSigma * Vec2(random.normal(), random.normal());
      belief.correct(fix_of(fix, belief), 9);
      belief.settle();
      d.fixes.push_back(point(fix));
    }
    const Pose2& pose = belief.nominal.T_map_robot;
    if (k % (4 * kEvery) == kEvery - 1 || k % (4 * kEvery) == kEvery) {
      const Mat3 p = belief.covariance.topLeftCorner<3, 3>();
      const Mat3 in_map = motion::in_map_axes(p, pose.theta);
      Ellipse ellipse =
          covariance_ellipse(pose.translation(), in_map.topLeftCorner<2, 2>(), {ink::green, 1.3});
      ellipse.fill = ink::green.faint(0.08);
      d.ellipses.push_back(ellipse);
    }
    d.truth.push_back(point(truth.translation()));
    d.wheels.push_back(point(wheels.translation()));
    d.estimate.push_back(point(pose.translation()));
  }
  return d;
}

Panel plane(const Box& place) {
  const Drive d = drive();
  Panel panel{.place = place,
              .title = "wheels predict at every step, a fix corrects at every fourth",
              .x = {"x (m)"},
              .y = {"y (m)"}};
  panel.marks.push_back(Polyline{d.wheels, {ink::grey, 1.6, 5}});
  panel.marks.insert(panel.marks.end(), d.ellipses.begin(), d.ellipses.end());
  panel.marks.push_back(Dots{d.fixes, 3.5, ink::orange});
  panel.marks.push_back(Polyline{d.truth, {ink::red, 2.4}});
  panel.marks.push_back(Polyline{d.estimate, {ink::green, 2.2}});
  panel.legend = {{"truth", Pen{ink::red, 2.4}},
                  {"estimate, with 95 % ellipses", Pen{ink::green, 2.2}},
                  {"wheels alone", Pen{ink::grey, 1.6, 5}},
                  {"fixes, sigma 0.25 m", {}, ink::orange}};
  return panel;
}

/// One number that wanders with Q = 0.1 and is measured with R = 9.
struct Number {
  std::vector<Point> truth, estimate, measured, gain;
};

Number number() {
  constexpr int kMeasured = 80;
  RandomStream random(kSeed, 1);
  filter::ScalarKalman k{.mean = 0, .variance = 20};
  double truth = 4;
  Number n;
  for (int i = 1; i <= kMeasured; ++i) {
    truth += std::sqrt(0.1) * random.normal();
    const double y = truth + 3 * random.normal();
    k.predict(0.1);
    n.gain.push_back({double(i), k.correct(y, 9)});
    n.truth.push_back({double(i), truth});
    n.estimate.push_back({double(i), k.mean});
    n.measured.push_back({double(i), y});
  }
  return n;
}

}  // namespace

Figure figure_kalman(const std::vector<Event>&) {
  Figure figure{.width = 1250,
                .height = 640,
                .title = "Kalman filter: relative information predicts, absolute corrects"};
  const Box whole = figure.whole();
  const double split = 790, half = whole.height / 2;
  figure.panels.push_back(plane({0, whole.top, split, whole.height}));
  const Number n = number();
  Panel value{.place = {split, whole.top, whole.width - split, half},
              .title = "one number, Q = 0.1, R = 9",
              .x = {"step", 0, 80},
              .y = {"value"},
              .equal = false};
  value.marks = {Dots{n.measured, 2.2, ink::orange}, Polyline{n.truth, {ink::red, 2}},
                 Polyline{n.estimate, {ink::green, 2}}};
  Panel gain{.place = {split, whole.top + half, whole.width - split, half},
             .title = "its gain settles at 0.1",
             .x = {"step", 0, 80},
             .y = {"gain K", 0, 1},
             .equal = false};
  gain.marks = {Polyline{{{0, 0.1}, {80, 0.1}}, {ink::grey, 1.4, 5}},
                Polyline{n.gain, {ink::blue, 2.2}}};
  figure.panels.push_back(value);
  figure.panels.push_back(gain);
  return figure;
}

}  // namespace majak::draw
