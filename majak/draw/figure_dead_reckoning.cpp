// SPDX-License-Identifier: Apache-2.0
// Figure 5 of the thesis: the ellipses of dead reckoning along a path, and robots that drove it.
#include <fmt/format.h>
#include <Eigen/LU>

#include <cmath>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/draw/sketch.hpp"
#include "majak/draw/thesis_figures.hpp"
#include "majak/draw/trajectory_figure.hpp"
#include "majak/localize/dead_reckoning.hpp"
#include "majak/motion/wheel_noise.hpp"

namespace majak::draw {
namespace {

constexpr int kSteps = 80, kStages = 4, kRuns = 20'000, kShown = 500;
constexpr double kStep = 0.125;  // m: 10 m in all
constexpr double kChi95 = 5.991464547107979;
constexpr std::uint64_t kSeed = 5;

double bend(int step) { return step < 28 ? 0.028 : step < 52 ? -0.045 : 0.02; }  // rad a step

/// Where 95 % of the robots should be after a stage, and where some of them are.
struct Stage {
  Pose2 pose;
  Mat3 covariance;
  std::vector<Point> robots;
};

struct Drive {
  motion::Differential drive{0.4};
  motion::WheelNoise noise{.slip = 0.008};
  std::vector<Stage> stages;
  std::vector<Point> path{{0, 0}};
  double inside = 0;  ///< share of the runs whose end lies in the last region
};

/// The drive as it is believed to be, with its covariance.
void reckon(Drive& d) {
  Pose2 pose;
  motion::PathUncertainty uncertainty;
  for (int i = 0; i < kSteps; ++i) {
    const Vec3 twist(kStep, 0, bend(i));
    pose = pose * exp(twist);
    uncertainty.move(twist, motion::random_part(d.noise, d.drive, d.drive.inverse(twist)));
    d.path.push_back(point(pose.translation()));
    if ((i + 1) % (kSteps / kStages) == 0) d.stages.push_back({pose, uncertainty.covariance(), {}});
  }
}

/// Robots whose wheels slip.
void sample(Drive& d) {
  const Stage& last = d.stages.back();
  const Eigen::Matrix2d information =
      Eigen::Matrix2d(last.covariance.topLeftCorner<2, 2>()).inverse();
  int inside = 0;
  for (int run = 0; run < kRuns; ++run) {
    RandomStream random(kSeed, static_cast<std::uint64_t>(run));
    const auto roll = [&](double way) {
      return way + d.noise.slip * std::sqrt(std::abs(way)) * random.normal();
    };
    Pose2 truth;
    for (int i = 0; i < kSteps; ++i) {
      const auto w = d.drive.inverse({kStep, 0, bend(i)});
      const double left = roll(w.left);
      truth = truth * exp(d.drive.forward({left, roll(w.right)}));
      const int stage = (i + 1) / (kSteps / kStages);
      if (run < kShown && (i + 1) % (kSteps / kStages) == 0)
        d.stages[static_cast<std::size_t>(stage - 1)].robots.push_back(point(truth.translation()));
    }
    const Vec2 error = log(between(last.pose, truth)).head<2>();
    inside += error.dot(information * error) <= kChi95;
  }
  d.inside = double(inside) / kRuns;
}

Figure built_in() {
  Drive d;
  reckon(d);
  sample(d);
  Figure figure{.width = 900,
                .height = 660,
                .title = "Dead reckoning: the longer the way, the larger the ellipse"};
  Panel panel{.place = figure.whole(), .x = {"x (m)"}, .y = {"y (m)"}};
  for (const Stage& stage : d.stages)
    panel.marks.push_back(Dots{stage.robots, 1.4, ink::orange.faint(0.7)});
  panel.marks.push_back(Polyline{d.path, {ink::blue, 2.2}});
  std::vector<Point> centres;
  for (const Stage& stage : d.stages) {
    panel.marks.push_back(Polyline{
        bent_ellipse(stage.pose, stage.covariance), {ink::red, 1.8}, true, ink::red.faint(0.06)});
    const Mat3 in_map = motion::in_map_axes(stage.covariance, stage.pose.theta);
    panel.marks.push_back(covariance_ellipse(stage.pose.translation(), in_map.topLeftCorner<2, 2>(),
                                             {ink::grey, 1.2, 4}));
    centres.push_back(point(stage.pose.translation()));
  }
  panel.marks.push_back(Dots{std::move(centres), 3.5, ink::blue});
  panel.legend = {{"path by the wheels, 10 m", Pen{ink::blue, 2.2}},
                  {fmt::format("{} robots that slipped on it", kShown), {}, ink::orange},
                  {fmt::format("95 % region; holds {:.1f} % of {} ends", 100 * d.inside, kRuns),
                   Pen{ink::red, 1.8}},
                  {"the same as a plain ellipse", Pen{ink::grey, 1.2, 4}}};
  figure.panels.push_back(std::move(panel));
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
