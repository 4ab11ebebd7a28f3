// SPDX-License-Identifier: Apache-2.0
// Figure 5 of the thesis: the ellipses of dead reckoning along a path, and robots that drove it.
#include <fmt/format.h>
#include <Eigen/LU>

#include <cmath>
#include <functional>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/draw/sketch.hpp"
#include "majak/draw/thesis_figures.hpp"
#include "majak/draw/trajectory_figure.hpp"
#include "majak/localize/dead_reckoning.hpp"
#include "majak/motion/wheel_noise.hpp"

namespace majak::draw {
namespace {

constexpr int kSteps = 40, kStages = 4, kRuns = 100'000, kShown = 400;
constexpr double kStep = 0.25;  // m: 10 m in all
constexpr double kChi95 = 5.991464547107979;
constexpr std::uint64_t kSeed = 5;

double bend(int step) { return step < 14 ? 0.055 : step < 26 ? -0.09 : 0.04; }  // rad a step

/// Where 95 % of the robots should be after a stage, and where some of them are.
struct Stage {
  Pose2 pose;
  Mat3 covariance;
  std::vector<Point> robots{};
};

/// A drive along the path of bend().
struct Course {
  const char* name;
  std::function<Vec3(int)> twist;                   ///< of a step, as the wheels report it
  std::function<Mat3(int)> noise;                   ///< its covariance
  std::function<Vec3(int, RandomStream&)> slipped;  ///< the same of a robot that slips
};

/// What a wheel rolls where it should roll `way`.
double roll(double way, const motion::WheelNoise& noise, RandomStream& random) {
  return way + noise.slip * std::sqrt(std::abs(way)) * random.normal();
}

Course differential() {
  const motion::Differential drive{0.4};
  const motion::WheelNoise noise{.slip = 0.008};
  const auto wheels = [=](int i) { return drive.inverse({kStep, 0, bend(i)}); };
  return {"differential", [=](int i) { return drive.forward(wheels(i)); },
          [=](int i) { return motion::random_part(noise, drive, wheels(i)); },
          [=](int i, RandomStream& r) {
            auto w = wheels(i);
            w.left = roll(w.left, noise, r);
            w.right = roll(w.right, noise, r);
            return drive.forward(w);
          }};
}

Course ackermann() {
  const motion::Ackermann drive{0.5};
  const motion::WheelNoise noise{.slip = 0.02, .steering = 0.04};
  const auto wheels = [=](int i) { return drive.inverse({kStep, 0, bend(i)}); };
  return {"Ackermann", [=](int i) { return drive.forward(wheels(i)); },
          [=](int i) { return motion::random_part(noise, drive, wheels(i)); },
          [=](int i, RandomStream& r) {
            auto w = wheels(i);
            w.way = roll(w.way, noise, r);
            w.steering += noise.steering * r.normal();
            return drive.forward(w);
          }};
}

/// The same path without looking where it goes: the robot keeps half aside.
Course omnidirectional() {
  const motion::Omnidirectional drive{0.25};
  const motion::WheelNoise noise{.slip = 0.016};
  const Vec2 ahead = kStep * Vec2(std::cos(0.8), -std::sin(0.8));
  const auto wheels = [=](int i) { return drive.inverse({ahead.x(), ahead.y(), bend(i)}); };
  return {"omnidirectional", [=](int i) { return drive.forward(wheels(i)); },
          [=](int i) { return motion::random_part(noise, drive, wheels(i)); },
          [=](int i, RandomStream& r) {
            auto w = wheels(i);
            for (double& way : w) way = roll(way, noise, r);
            return drive.forward(w);
          }};
}

bool ends_a_stage(int step) { return (step + 1) % (kSteps / kStages) == 0; }

/// The drive as it is believed to be, with its covariance.
std::vector<Stage> reckon(const Course& course, const Pose2& start, std::vector<Point>& path) {
  Pose2 pose = start;
  motion::PathUncertainty uncertainty;
  std::vector<Stage> stages;
  for (int i = 0; i < kSteps; ++i) {
    const Vec3 twist = course.twist(i);
    const std::vector<Point> way = way_of({0, 0}, pose, twist);
    path.insert(path.end(), way.begin(), way.end());
    pose = pose * exp(twist);
    uncertainty.move(twist, course.noise(i));
    if (ends_a_stage(i)) stages.push_back({pose, uncertainty.covariance()});
  }
  return stages;
}

/// Drives robots whose wheels slip; the share of them that ends in the last region.
double sample(const Course& course, const Pose2& start, std::vector<Stage>& stages) {
  const Stage& last = stages.back();
  const Eigen::Matrix2d information =
      Eigen::Matrix2d(last.covariance.topLeftCorner<2, 2>()).inverse();
  int inside = 0;
  for (int run = 0; run < kRuns; ++run) {
    RandomStream random(kSeed, static_cast<std::uint64_t>(run));
    Pose2 truth = start;
    for (int i = 0; i < kSteps; ++i) {
      truth = truth * exp(course.slipped(i, random));
      if (run < kShown && ends_a_stage(i))
        stages[static_cast<std::size_t>(i / (kSteps / kStages))].robots.push_back(
            point(truth.translation()));
    }
    const Vec2 error = log(between(last.pose, truth)).head<2>();
    inside += error.dot(information * error) <= kChi95;
  }
  return double(inside) / kRuns;
}

Panel course_panel(const Box& place, const Course& course) {
  // All set out along x, whichever way they look.
  const Vec3 first = course.twist(0);
  const Pose2 start{0, 0, -std::atan2(first.y(), first.x())};
  std::vector<Point> path, centres;
  std::vector<Stage> stages = reckon(course, start, path);
  const double inside = sample(course, start, stages);
  Panel panel{.place = place,
              .title = fmt::format("{}: the 95 % region after 10 m holds {:.1f} % of {} robots",
                                   course.name, 100 * inside, kRuns),
              .x = {"x (m)"},
              .y = {"y (m)", -0.3, 3.7}};
  for (const Stage& stage : stages)
    panel.marks.push_back(Dots{stage.robots, 1.3, ink::orange.faint(0.7)});
  panel.marks.push_back(Polyline{std::move(path), {ink::blue, 2.2}});
  for (const Stage& stage : stages) {
    panel.marks.push_back(Polyline{
        bent_ellipse(stage.pose, stage.covariance), {ink::red, 1.8}, true, ink::red.faint(0.06)});
    const Mat3 in_map = motion::in_map_axes(stage.covariance, stage.pose.theta);
    panel.marks.push_back(covariance_ellipse(stage.pose.translation(), in_map.topLeftCorner<2, 2>(),
                                             {ink::grey, 1.2, 4}));
    centres.push_back(point(stage.pose.translation()));
  }
  panel.marks.push_back(Dots{std::move(centres), 3.5, ink::blue});
  return panel;
}

Figure built_in() {
  Figure figure{.width = 900,
                .height = 1230,
                .title = "Dead reckoning: the longer the way, the larger the ellipse"};
  const double height = (figure.whole().height - 10) / 3;
  double top = figure.whole().top;
  for (const Course& course : {differential(), ackermann(), omnidirectional()}) {
    figure.panels.push_back(course_panel({0, top, figure.width, height}, course));
    top += height;
  }
  figure.panels[0].legend = {{"path by the wheels", Pen{ink::blue, 2.2}},
                             {fmt::format("{} robots that slipped", kShown), {}, ink::orange},
                             {"95 % region, bent", Pen{ink::red, 1.8}},
                             {"plain 95 % ellipse", Pen{ink::grey, 1.2, 4}}};
  return figure;
}

Figure of_log(const std::vector<Event>& events) {
  const localize::Localizer localizer = localize::dead_reckoning({});
  for (const Event& event : events) localizer.add(event);
  PathPicture picture;
  picture.title = "Dead reckoning: the longer the way, the larger the ellipse";
  picture.path_name = "dead reckoning";
  picture.estimates = localizer.finish().estimates;
  if (picture.estimates.empty())
    throw Error("figure 5: there is neither odometry nor wheel speed in this log");
  return path_picture(picture);
}

}  // namespace

Figure figure_dead_reckoning(const std::vector<Event>& events) {
  return events.empty() ? built_in() : of_log(events);
}

}  // namespace majak::draw
