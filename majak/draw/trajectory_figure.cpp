// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/trajectory_figure.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace majak::draw {
namespace {

constexpr double kWallStep = 0.08;          // m
constexpr double kPath = 1.8, kThin = 0.3;  // points; m between points of a line that is drawn

/// The estimates at equal steps along the way, the last one for certain.
std::vector<std::size_t> along_the_way(const std::vector<Estimate>& estimates, int wanted) {
  std::vector<double> way(estimates.size(), 0.0);
  for (std::size_t i = 1; i < way.size(); ++i)
    way[i] = way[i - 1] +
             (estimates[i].T_map_robot.translation() - estimates[i - 1].T_map_robot.translation())
                 .norm();
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < way.size(); ++i)
    if (way[i] > 0 && way[i] >= way.back() * double(chosen.size() + 1) / wanted)
      chosen.push_back(i);
  return chosen;
}

/// One point a square of kWallStep.
std::vector<Point> thinned(const std::vector<Vec2>& walls) {
  std::set<std::pair<long, long>> seen;
  std::vector<Point> kept;
  for (const Vec2& p : walls)
    if (seen.insert({std::lround(p.x() / kWallStep), std::lround(p.y() / kWallStep)}).second)
      kept.push_back({p.x(), p.y()});
  return kept;
}

/// Where the method did not know it.
std::vector<Point> lost_places(const std::vector<Estimate>& estimates) {
  std::vector<Point> places;
  for (const Estimate& e : estimates)
    if (e.health == Health::lost) places.push_back({e.T_map_robot.x, e.T_map_robot.y});
  return places;
}

/// The diagonal of the path's box.
double extent(const std::vector<Point>& path) {
  Point low{1e300, 1e300}, high{-1e300, -1e300};
  for (const Point& p : path) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
  return std::hypot(high.x - low.x, high.y - low.y);
}

/// Those larger than the path itself would hide it, and say nothing more.
void add_ellipses(Panel& panel, const std::vector<Estimate>& estimates, int wanted,
                  double largest) {
  std::vector<Point> centres;
  bool all = true;
  for (const std::size_t i : along_the_way(estimates, wanted)) {
    const Estimate& e = estimates[i];
    Ellipse ellipse = covariance_ellipse(e.T_map_robot.translation(),
                                         e.covariance.topLeftCorner<2, 2>(), {ink::red, 1.3});
    all = all && ellipse.rx <= largest;
    if (ellipse.rx > largest) continue;
    ellipse.fill = ink::red.faint(0.07);
    panel.marks.push_back(ellipse);
    centres.push_back({e.T_map_robot.x, e.T_map_robot.y});
  }
  if (centres.empty()) return;
  panel.marks.push_back(Dots{std::move(centres), 2.6, ink::red});
  panel.legend.push_back(
      {all ? "95 % ellipse" : "95 % ellipse, while smaller than the path", Pen{ink::red, 1.3}});
}

}  // namespace

Figure path_picture(const PathPicture& picture) {
  std::vector<Estimate> estimates;
  std::vector<Point> path, truth, fixes;
  for (const Estimate& e : picture.estimates) {
    if (!e.T_map_robot.finite() || !e.covariance.allFinite()) continue;
    estimates.push_back(e);
    path.push_back({e.T_map_robot.x, e.T_map_robot.y});
  }
  for (const Pose2& pose : picture.truth) truth.push_back({pose.x, pose.y});
  for (const GpsFix& fix : picture.fixes) fixes.push_back({fix.east, fix.north});

  Figure figure{.width = 900, .height = 720, .title = picture.title};
  Panel panel{.place = figure.whole(), .x = {"x (m)"}, .y = {"y (m)"}};
  if (!picture.walls.empty()) {
    panel.marks.push_back(Dots{thinned(picture.walls), 0.8, ink::grey});
    panel.legend.push_back({"the map", {}, ink::grey});
  }
  if (!fixes.empty()) {
    panel.marks.push_back(Dots{fixes, 1.8, ink::orange});
    panel.legend.push_back({"satellite fixes", {}, ink::orange});
  }
  if (!truth.empty()) {
    panel.marks.push_back(Polyline{simplify(truth, kThin / 10), {ink::green, kPath, 6}});
    panel.legend.push_back({"truth", Pen{ink::green, kPath, 6}});
  }
  panel.marks.push_back(Polyline{simplify(path, kThin / 10), {ink::blue, kPath}});
  panel.legend.push_back({picture.path_name, Pen{ink::blue, kPath}});
  if (auto lost = lost_places(estimates); !lost.empty()) {
    panel.marks.push_back(Dots{std::move(lost), 2.2, ink::purple});
    panel.legend.push_back({"not sure of its place", {}, ink::purple});
  }
  add_ellipses(panel, estimates, picture.ellipses, 0.5 * extent(path));
  figure.panels.push_back(std::move(panel));
  return figure;
}

}  // namespace majak::draw
