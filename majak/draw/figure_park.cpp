// SPDX-License-Identifier: Apache-2.0
// Figure 22b of the thesis, its demonstration: a car maps the trunks of a park with laser, wheels
// and satellites. Route and objects, true and as seen, and why far objects are seen worse: not the
// laser, but the heading with which it looks.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "majak/draw/sketch.hpp"
#include "majak/draw/thesis_figures.hpp"
#include "majak/eval/landmarks.hpp"
#include "majak/sim/park.hpp"
#include "majak/sim/simulator.hpp"
#include "majak/sim/tour.hpp"
#include "majak/slam/ekf_slam.hpp"

namespace majak::draw {
namespace {

constexpr double kWay = 620;                 // m of the tour: it crosses itself twice
constexpr double kMagnified = 2;             // ellipses on the whole map
constexpr double kBin = 5;                   // m of range
constexpr std::size_t kLeast = 30;           // sightings in a bin that is shown
constexpr Box kDetail{111.6, 96.4, 26, 36};  // m; top: its lower edge
const Colour kTruth = ink::red, kEstimate = ink::green, kTrunk = ink::blue, kSeen = ink::purple;

struct Demonstration {
  sim::World world{sim::park()};
  std::vector<Point> truth, estimate, wheels;
  std::vector<slam::MappedLandmark> trunks;
  std::vector<Point> seen;  ///< trunks as single scans showed them, with the pose of that time
  std::vector<eval::SightingError> sightings;
  double place_error = 0, trunk_error = 0;  ///< m, means
  double heading_error = 0;                 ///< rad, root of the mean square
};

sim::SimulationOptions car() {
  sim::SimulationOptions options;
  sim::make_car(options);
  options.seed = 10;  // its errors are about the median of the first ten
  options.robot.speed = 5;
  options.beams = 361, options.scan_rate = 2.5;
  options.satellites.on = true;
  return options;
}

/// The trunk that each landmark is, by where the car truly was; null: none.
std::vector<const sim::Disc*> trunks_of(const slam::LandmarkMap& map, const sim::World& world,
                                        const std::map<Time, Pose2>& truth) {
  constexpr double kNear = 0.5;  // m
  std::vector<Vec2> sum(map.landmarks.size(), Vec2::Zero());
  for (const slam::LandmarkObservation& o : map.observations)
    sum[static_cast<std::size_t>(o.landmark)] +=
        truth.at(map.localization.estimates[o.scan].time) * o.q_robot;
  std::vector<const sim::Disc*> trunks(map.landmarks.size(), nullptr);
  for (std::size_t i = 0; i < sum.size(); ++i)
    for (const sim::Disc& disc : world.scene().discs)
      if ((sum[i] / map.landmarks[i].sightings - disc.centre).norm() < kNear) trunks[i] = &disc;
  return trunks;
}

void compare_route(Demonstration& d, const std::vector<Estimate>& estimates,
                   const std::map<Time, Pose2>& truth) {
  const auto count = double(estimates.size());
  for (const Estimate& e : estimates) {
    const Pose2& truly = truth.at(e.time);
    d.truth.push_back(point(truly.translation()));
    d.estimate.push_back(point(e.T_map_robot.translation()));
    const Pose2 T_truth_estimate = between(truly, e.T_map_robot);
    d.place_error += T_truth_estimate.translation().norm() / count;
    d.heading_error += T_truth_estimate.theta * T_truth_estimate.theta / count;
  }
  d.heading_error = std::sqrt(d.heading_error);
}

void compare_trunks(Demonstration& d, const slam::LandmarkMap& map,
                    const std::map<Time, Pose2>& truth, const Pose2& T_robot_laser) {
  const std::vector<const sim::Disc*> trunks = trunks_of(map, d.world, truth);
  for (std::size_t i = 0; i < trunks.size(); ++i)
    if (trunks[i] != nullptr && !map.landmarks[i].gone) {
      d.trunks.push_back(map.landmarks[i]);
      d.trunk_error += (map.landmarks[i].p_map - trunks[i]->centre).norm();
    }
  d.trunk_error /= std::max(1.0, double(d.trunks.size()));
  for (const slam::LandmarkObservation& o : map.observations) {
    const Estimate& e = map.localization.estimates[o.scan];
    const sim::Disc* trunk = trunks[static_cast<std::size_t>(o.landmark)];
    if (trunk == nullptr) continue;
    d.seen.push_back(point(e.T_map_robot * o.q_robot));
    d.sightings.push_back(eval::sighting_error(o.q_robot, e.T_map_robot, truth.at(e.time),
                                               trunk->centre, T_robot_laser));
  }
}

Demonstration demonstrate() {
  Demonstration d;
  const sim::SimulationOptions options = car();
  sim::Path path = sim::plan_tour(d.world);
  path.points.resize(std::min(path.points.size(), std::size_t(kWay / sim::kPathStep)));
  slam::EkfSlamOptions slam_options;
  slam_options.wheelbase = options.robot.wheelbase;
  slam::EkfSlam slam(slam_options, path.start);
  std::map<Time, Pose2> truth;
  for (const Event& event : sim::simulate(d.world, path, options)) {
    if (const auto* t = std::get_if<Truth>(&event)) truth[t->time] = t->T_world_robot;
    if (const auto* o = std::get_if<Odometry>(&event))
      d.wheels.push_back(point((path.start * o->T_odom_robot).translation()));
    slam.add(event);
  }
  const slam::LandmarkMap map = slam.finish();
  compare_route(d, map.localization.estimates, truth);
  compare_trunks(d, map, truth, {options.mounting_x, options.mounting_y, options.mounting_theta});
  return d;
}

// ---- The map ---------------------------------------------------------------------------------

void add_map(std::vector<Mark>& marks, const Demonstration& d, double dot, double magnified) {
  for (const sim::Segment& s : d.world.scene().segments)
    marks.emplace_back(Polyline{{point(s.a), point(s.b)}, {ink::grey, 1.2}});
  marks.emplace_back(Polyline{d.wheels, {ink::grey.faint(0.6), 1.4, 5}});
  for (const sim::Disc& disc : d.world.scene().discs)
    marks.emplace_back(circle(point(disc.centre), disc.radius, {kTruth, 1.4}, kTruth.faint(0.25)));
  for (const slam::MappedLandmark& t : d.trunks) {
    const Eigen::Matrix2d covariance = magnified * magnified * t.covariance;
    marks.emplace_back(covariance_ellipse(t.p_map, covariance, {kTrunk, 1.3}));
  }
  marks.emplace_back(Dots{d.seen, dot, kSeen.faint(0.6)});
  marks.emplace_back(Polyline{d.truth, {kTruth, 2}});
  marks.emplace_back(Polyline{d.estimate, {kEstimate, 1.8}});
}

Panel whole_map(const Box& place, const Demonstration& d) {
  Panel panel{.place = place,
              .title = fmt::format("Mean error: the car's place {:.2f} m, trunks {:.2f} m",
                                   d.place_error, d.trunk_error),
              .x = {"x (m)", -70.0, 252.0},
              .y = {"y (m)", -22.0, 207.0}};
  add_map(panel.marks, d, 1.0, kMagnified);
  const Box& b = kDetail;
  panel.marks.emplace_back(Polyline{{{b.left, b.top},
                                     {b.left + b.width, b.top},
                                     {b.left + b.width, b.top + b.height},
                                     {b.left, b.top + b.height}},
                                    {ink::black, 1.2},
                                    true});
  panel.legend = {{"true route", Pen{kTruth, 2}},
                  {"estimated route", Pen{kEstimate, 1.8}},
                  {"dead reckoning", Pen{ink::grey.faint(0.6), 1.4, 5}},
                  {"true trunk", {}, kTruth.faint(0.5)},
                  {fmt::format("estimated, 95 % x {:.0f}", kMagnified), Pen{kTrunk, 1.3}},
                  {"sighting", {}, kSeen.faint(0.6)}};
  panel.legend_at = Corner::bottom_left;
  return panel;
}

Panel detail(const Box& place, const Demonstration& d) {
  Panel panel{.place = place,
              .title = "The part in the frame, ellipses in true size",
              .x = {"x (m)", kDetail.left, kDetail.left + kDetail.width},
              .y = {"y (m)", kDetail.top, kDetail.top + kDetail.height}};
  add_map(panel.marks, d, 1.8, 1);
  return panel;
}

// ---- Errors over range -----------------------------------------------------------------------

std::vector<Point> rms_over_range(const Demonstration& d, double eval::RangeBin::*error) {
  std::vector<Point> line;
  for (const eval::RangeBin& bin : eval::errors_over_range(d.sightings, kBin, kLeast))
    line.push_back({bin.range, bin.*error});
  return line;
}

Panel errors(const Box& place, const Demonstration& d, int axis, std::string title) {
  Panel panel{.place = place,
              .title = std::move(title),
              .x = {"range (m)", 0.0, 50.0},
              .y = {"error (m)", 0.0, 1.2},
              .equal = false};
  Dots each{{}, 1.1, kSeen.faint(0.5)};
  for (const eval::SightingError& s : d.sightings)
    each.at.push_back({s.range, std::abs(s.error(axis))});
  panel.marks.emplace_back(std::move(each));
  const Pen whole{kTrunk, 2.4};
  using Bin = eval::RangeBin;
  panel.marks.emplace_back(
      Polyline{rms_over_range(d, axis == 0 ? &Bin::along : &Bin::across), whole});
  panel.legend = {{"each sighting", {}, kSeen.faint(0.6)}, {"root of their mean square", whole}};
  panel.legend_at = Corner::top_left;
  if (axis == 0) return panel;
  const Pen heading{kEstimate, 2, 5}, laser{ink::orange, 2};
  panel.marks.emplace_back(Polyline{rms_over_range(d, &Bin::by_heading), heading});
  panel.marks.emplace_back(Polyline{rms_over_range(d, &Bin::by_laser), laser});
  panel.legend.push_back({"of it, by the heading", heading});
  panel.legend.push_back({"of it, by the laser", laser});
  return panel;
}

}  // namespace

Figure figure_park(const std::vector<Event>&) {
  const Demonstration d = demonstrate();
  Figure figure{.width = 1300,
                .height = 1060,
                .title = "The demonstration: route and trunks of a park, true and as seen"};
  const Box all = figure.whole();
  const double right = 830, half = all.width / 2, split = 620;
  const Box below{0, all.top + split, half, all.height - split};
  figure.panels = {
      whole_map({0, all.top, right, split}, d),
      detail({right, all.top, all.width - right, split}, d),
      errors(below, d, 0, "Along the beam: the laser"),
      errors({half, below.top, half, below.height}, d, 1,
             fmt::format("Across it: the heading, wrong by {:.2f}° (1° at 30 m is 0.52 m)",
                         degrees(d.heading_error)))};
  return figure;
}

}  // namespace majak::draw
