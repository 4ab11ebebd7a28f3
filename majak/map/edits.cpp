// SPDX-License-Identifier: Apache-2.0
#include "majak/map/edits.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "majak/core/error.hpp"
#include "majak/map/ray.hpp"
#include "majak/map/scan_choice.hpp"
#include "majak/map/scan_window.hpp"

namespace majak::map {
namespace {

constexpr double kFarthest = 1000;  // m, of a point from the scan that it hangs on
constexpr double kOffTheMap = 1e6;  // m; a scan placed there has no place
constexpr float kCertain = 6;       // log-odds of a wall that a person drew

/// Of a polygon or of a line.
std::size_t least_points(EditKind kind) { return kind == EditKind::wall ? 2 : 3; }

/// A scan that points may hang on.
struct Place {
  std::size_t scan;
  Vec2 at;
};

std::vector<Place> places(const Site& site) {
  const bool keys =
      std::any_of(site.scans.begin(), site.scans.end(), [](const PosedScan& s) { return s.key; });
  std::vector<Place> places;
  for (std::size_t i = 0; i < site.scans.size(); ++i)
    if (!keys || site.scans[i].key)
      places.push_back({i, site.scans[i].estimate.T_map_robot.translation()});
  return places;
}

AnchoredPoint anchored_point(const Site& site, const std::vector<Place>& places,
                             const Vec2& p_map) {
  AnchoredPoint nearest;
  double least = std::numeric_limits<double>::infinity();
  for (const Place& place : places) {
    const double d2 = (place.at - p_map).squaredNorm();
    if (d2 < least) least = d2, nearest.scan = place.scan;
  }
  if (!(least <= kFarthest * kFarthest))
    throw Error("a point lies more than 1000 m from all scans, or is no number");
  nearest.p_robot = site.scans[nearest.scan].estimate.T_map_robot.inverse() * p_map;
  return nearest;
}

bool crosses_ray(const Vec2& a, const Vec2& b, const Vec2& p) {
  return (a.y() > p.y()) != (b.y() > p.y()) &&
         p.x() < (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()) + a.x();
}

/// A polygon that is asked for millions of points: its sides by strips of y.
class Area {
 public:
  explicit Area(std::vector<Vec2> corners) : polygon(std::move(corners)) {
    low = high = polygon.front();
    for (const Vec2& p : polygon) low = low.cwiseMin(p), high = high.cwiseMax(p);
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Vec2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
      const std::size_t last = strip(std::max(a.y(), b.y()));
      for (std::size_t k = strip(std::min(a.y(), b.y())); k <= last; ++k)
        strips_[k].emplace_back(a, b);
    }
  }
  bool holds(const Vec2& p) const {
    if (p.x() < low.x() || p.x() > high.x() || p.y() < low.y() || p.y() > high.y()) return false;
    bool in = false;
    for (const auto& [a, b] : strips_[strip(p.y())]) in ^= crosses_ray(a, b, p);
    return in;
  }

  std::vector<Vec2> polygon;
  Vec2 low, high;

 private:
  static constexpr std::size_t kStrips = 128;
  std::size_t strip(double y) const {
    const double height = std::max(high.y() - low.y(), 1e-9);
    return std::min(static_cast<std::size_t>((y - low.y()) / height * kStrips), kStrips - 1);
  }
  std::array<std::vector<std::pair<Vec2, Vec2>>, kStrips> strips_;
};

std::vector<Area> areas(const Site& site, EditKind kind) {
  std::vector<Area> areas;
  for (std::vector<Vec2>& polygon : shapes_in_map(site, kind))
    areas.emplace_back(std::move(polygon));
  return areas;
}

void turn(Site& site, double by) {
  const Pose2 T{0, 0, by};
  const double c = std::cos(by), s = std::sin(by);
  Mat3 r;
  r << c, -s, 0, s, c, 0, 0, 0, 1;
  for (PosedScan& posed : site.scans) {
    Estimate& e = posed.estimate;
    e.T_map_robot = T * e.T_map_robot;
    posed.T_map_robot_front_end = T * posed.T_map_robot_front_end;
    const Mat3 covariance = r * e.covariance * r.transpose();
    e.covariance = 0.5 * (covariance + covariance.transpose());
    e.weak_direction = T * e.weak_direction;
  }
}

void erase_returns(Site& site) {
  const std::vector<Area> erases = areas(site, EditKind::erase),
                          crops = areas(site, EditKind::crop);
  if (erases.empty() && crops.empty()) return;
  const auto counts = [&](const Vec2& p) {
    const auto holds = [&](const Area& area) { return area.holds(p); };
    return std::none_of(erases.begin(), erases.end(), holds) &&
           std::all_of(crops.begin(), crops.end(), holds);
  };
  BeamTable table;
  for (PosedScan& posed : site.scans) {
    const Pose2 T_map_laser = posed.estimate.T_map_robot * posed.scan.T_robot_laser;
    const Vec2 ahead(std::cos(T_map_laser.theta), std::sin(T_map_laser.theta));
    const std::vector<Vec2>& directions = table.of(posed.scan);
    for (std::size_t i = 0; i < directions.size(); ++i) {
      float& range = posed.scan.ranges[i];
      if (!(range > 0 && range < kNoReturn)) continue;
      const Vec2 p = range * directions[i];
      if (!counts(T_map_laser.translation() + p.x() * ahead + p.y() * Segment::left_of(ahead)))
        range = erased(range);
    }
  }
}

template <class Visit>
void cells_along(const Vec2& a, const Vec2& b, double resolution, const Visit& visit) {
  constexpr double kLongest = 1000;  // cells at a time
  constexpr std::ptrdiff_t kPitch = std::ptrdiff_t{1} << 32;
  const int pieces = 1 + static_cast<int>((b - a).norm() / (kLongest * resolution));
  const auto point = [&](int i) {
    const Vec2 p = (a + (b - a) * i / pieces) / resolution;
    return SubCellPoint{to_sub_cells(p.x()), to_sub_cells(p.y())};
  };
  for (int i = 0; i < pieces; ++i)
    for_each_cell(point(i), point(i + 1), kPitch, [&](std::ptrdiff_t offset) {
      const std::ptrdiff_t iy = (offset + kPitch / 2) >> 32;
      visit(static_cast<int>(offset - iy * kPitch), static_cast<int>(iy));
    });
}

// ---- The main direction -------------------------------------------------------------------------

constexpr double kQuarter = kPi / 2;
constexpr int kBins = 180;  // of half a degree

struct Heading {
  double angle, weight;  // rad; m^2
};

std::vector<Heading> headings_of_walls(const Site& site) {
  std::vector<Heading> headings;
  for_spaced_scans(site, 0.5, 0.5, [&](const PosedScan& posed) {
    const double turned = posed.estimate.T_map_robot.theta;
    for (const Segment& s : extract_segments(posed.scan)) {
      const Vec2 d = s.b - s.a;
      headings.push_back({turned + std::atan2(d.y(), d.x()), d.squaredNorm()});
    }
  });
  return headings;
}

/// Modulo a quarter turn, in [-pi/4, pi/4).
double within_quarter(double angle) {
  return angle - kQuarter * std::floor(angle / kQuarter + 0.5);
}

/// The bin that with its neighbours weighs most.
double peak_of(const std::vector<Heading>& headings) {
  constexpr int kAround = 3;
  std::array<double, kBins> bins{};
  for (const Heading& h : headings) {
    const double at = (within_quarter(h.angle) / kQuarter + 0.5) * kBins;
    bins[static_cast<std::size_t>(std::clamp(static_cast<int>(at), 0, kBins - 1))] += h.weight;
  }
  int best = 0;
  double most = -1;
  for (int i = 0; i < kBins; ++i) {
    double sum = 0;
    for (int k = -kAround; k <= kAround; ++k)
      sum += (kAround + 1 - std::abs(k)) * bins[static_cast<std::size_t>((i + k + kBins) % kBins)];
    if (sum > most) most = sum, best = i;
  }
  return ((best + 0.5) / kBins - 0.5) * kQuarter;
}

}  // namespace

bool inside(std::span<const Vec2> polygon, const Vec2& p) {
  bool in = false;
  for (std::size_t i = 0; i < polygon.size(); ++i)
    in ^= crosses_ray(polygon[i], polygon[(i + 1) % polygon.size()], p);
  return in;
}

Edit anchored(const Site& site, EditKind kind, std::span<const Vec2> points) {
  const std::size_t least = least_points(kind);
  if (points.size() < least)
    throw Error(std::string(name_of(kind)) + " takes " + (least == 3 ? "three" : "two") +
                " points or more");
  const std::vector<Place> near = places(site);
  Edit edit;
  edit.kind = kind;
  for (const Vec2& p : points) edit.points.push_back(anchored_point(site, near, p));
  return edit;
}

std::vector<Vec2> points_in_map(const Site& site, const Edit& edit) {
  std::vector<Vec2> points;
  for (const AnchoredPoint& p : edit.points)
    points.push_back(site.scans[p.scan].estimate.T_map_robot * p.p_robot);
  return points;
}

std::vector<std::vector<Vec2>> shapes_in_map(const Site& site, EditKind kind) {
  std::vector<std::vector<Vec2>> shapes;
  for (const Edit& edit : site.edits) {
    if (edit.kind != kind) continue;
    std::vector<Vec2> points = points_in_map(site, edit);
    const bool whole = points.size() >= least_points(kind) &&
                       std::all_of(points.begin(), points.end(), [](const Vec2& p) {
                         return p.cwiseAbs().maxCoeff() < kOffTheMap;  // false for no number
                       });
    if (whole) shapes.push_back(std::move(points));
  }
  return shapes;
}

void add_edit(Site& site, Edit edit) {
  if (!std::isfinite(edit.radians)) throw Error("a turn by what is no number");
  if (edit.kind == EditKind::closure_off) {
    const std::string name = std::to_string(edit.from) + "-" + std::to_string(edit.to);
    const auto is_it = [&](const auto& c) { return c.from == edit.from && c.to == edit.to; };
    if (std::none_of(site.constraints.begin(), site.constraints.end(), [&](const Constraint& c) {
          return c.kind == ConstraintKind::closure && is_it(c);
        }))
      throw Error("no closure joins the scans " + name + "; the report lists them");
    if (std::any_of(site.edits.begin(), site.edits.end(),
                    [&](const Edit& e) { return e.kind == EditKind::closure_off && is_it(e); }))
      throw Error("the closure " + name + " is switched off already");
  }
  edit.id = site.edits.empty() ? 1 : site.edits.back().id + 1;
  site.edits.push_back(std::move(edit));
}

void switch_closure(Site& site, std::size_t from, std::size_t to, bool on) {
  if (!on) {
    Edit edit;
    edit.kind = EditKind::closure_off;
    edit.from = from, edit.to = to;
    return add_edit(site, std::move(edit));
  }
  const auto gone = std::erase_if(site.edits, [&](const Edit& edit) {
    return edit.kind == EditKind::closure_off && edit.from == from && edit.to == to;
  });
  if (gone == 0)
    throw Error("the closure " + std::to_string(from) + "-" + std::to_string(to) +
                " is not switched off");
}

std::optional<Edit> undo_edit(Site& site) {
  if (site.edits.empty()) return std::nullopt;
  Edit last = std::move(site.edits.back());
  site.edits.pop_back();
  return last;
}

double turn_of(const Site& site) {
  double sum = 0;
  for (const Edit& edit : site.edits)
    if (edit.kind == EditKind::turn) sum += edit.radians;
  return wrap_angle(sum);
}

Site with_edits(Site site) {
  if (site.edits_applied || site.edits.empty()) return site;
  const double angle = turn_of(site);
  if (angle != 0) turn(site, angle);
  site.edits_applied = true;
  erase_returns(site);
  return site;
}

void draw_edits(OccupancyGrid& grid, const Site& site) {
  const std::vector<Area> crops = areas(site, EditKind::crop);
  const double cell = grid.resolution();
  if (!crops.empty()) {
    std::vector<std::pair<int, int>> outside;
    grid.for_each([&](int ix, int iy, float) {
      const Vec2 centre((ix + 0.5) * cell, (iy + 0.5) * cell);
      if (!std::all_of(crops.begin(), crops.end(), [&](const Area& a) { return a.holds(centre); }))
        outside.emplace_back(ix, iy);
    });
    for (const auto& [ix, iy] : outside) grid.forget(ix, iy);
  }
  for (const std::vector<Vec2>& wall : shapes_in_map(site, EditKind::wall))
    for (std::size_t i = 1; i < wall.size(); ++i)
      cells_along(wall[i - 1], wall[i], cell,
                  [&](int ix, int iy) { grid.set_log_odds(ix, iy, kCertain); });
}

std::vector<Segment> drawn_walls(const Site& site, std::size_t scans) {
  std::vector<Segment> segments;
  for (const std::vector<Vec2>& wall : shapes_in_map(site, EditKind::wall))
    for (std::size_t i = 1; i < wall.size(); ++i) {
      Segment s;
      s.a = wall[i - 1], s.b = wall[i];
      s.scans = scans;
      if (s.length() > 0) segments.push_back(s);
    }
  return segments;
}

void forbid(KnownMap& known, const Site& site, CellState as) {
  const auto forget = [&](int ix, int iy) {
    if (known.inside(ix, iy)) known.cells[known.index(ix, iy)] = as;
  };
  for (const Area& zone : areas(site, EditKind::forbidden)) {
    const int x1 = known.column(zone.high.x()), y1 = known.row(zone.high.y());
    for (int iy = std::max(0, known.row(zone.low.y())); iy <= std::min(y1, known.height - 1); ++iy)
      for (int ix = std::max(0, known.column(zone.low.x())); ix <= std::min(x1, known.width - 1);
           ++ix)
        if (zone.holds(known.centre(ix, iy))) forget(ix, iy);
    const Vec2 corner(known.x0, known.y0);
    for (std::size_t i = 0; i < zone.polygon.size(); ++i)  // and what a side only touches
      cells_along(zone.polygon[i] - corner, zone.polygon[(i + 1) % zone.polygon.size()] - corner,
                  known.resolution, forget);
  }
}

std::optional<double> main_direction(const Site& site) {
  const std::vector<Heading> headings = headings_of_walls(site);
  if (headings.empty()) return std::nullopt;
  double direction = peak_of(headings);
  for (const double reach : {3.0, 2.0, 1.0, 1.0}) {  // degrees
    double sum = 0, weight = 0;
    for (const Heading& h : headings) {
      const double off = within_quarter(h.angle - direction);
      if (std::abs(off) > radians(reach)) continue;
      sum += h.weight * off, weight += h.weight;
    }
    if (weight > 0) direction += sum / weight;
  }
  return within_quarter(direction);
}

}  // namespace majak::map
