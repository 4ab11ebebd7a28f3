// SPDX-License-Identifier: Apache-2.0
#include "majak/sim/floor_plans.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/sim/tour.hpp"

namespace majak::sim {
namespace {

// A tour's grid has its lines at 0.1 + 0.2 k from the lowest corner; doors there can be as narrow
// as the robot allows.
constexpr double kTourCell = 0.2;                   // m
constexpr double kRobot = 0.34;                     // m, half of what it needs
constexpr double kNarrowest = 0.72, kWidest = 1.2;  // m, single doors
constexpr double kClearAhead = 1.25;                // m, before a door
constexpr double kLane = 0.85;                      // m, between things

enum class Side { bottom, top, left, right };

/// A strip of rooms with the corridor along one side.
struct Block {
  Rectangle area;
  Side corridor;
};

/// What two places share: a piece of a grid line.
struct SharedWall {
  bool upright;  ///< along y
  double at;     ///< the line's x or y
  double low, high;
  int a, b;  ///< places left and right of it, or below and above
};

double snapped(double value) { return 0.1 + kTourCell * std::round((value - 0.1) / kTourCell); }

class Planner {
 public:
  Planner(std::uint64_t seed, std::uint64_t attempt) : random_(seed, 0x0ff1ce, attempt) {
    b_.scene.name = "office-" + std::to_string(seed);
  }

  GeneratedBuilding plan() {
    lay_out();
    split_into_grid();
    shared_ = shared_walls();
    place_doors();
    build_walls();
    for (std::size_t i = 0; i < b_.doors.size(); ++i) hang_leaves(b_.doors[i]);
    for (int place = 0; place < static_cast<int>(b_.places.size()); ++place) furnish(place);
    make_tour();
    return std::move(b_);
  }

 private:
  // --- The plan ---------------------------------------------------------------------------------

  struct Painted {
    Rectangle area;
    int place;
  };

  double uniform(double low, double high) { return random_.uniform(low, high); }
  bool chance(double p) { return random_.uniform() < p; }
  /// A line of the plan, to whole centimetres.
  double line(double value) const { return std::round(value * 100) / 100; }

  int add_place(TruePlaceKind kind) {
    b_.places.push_back(kind);
    bounds_.push_back({});
    return static_cast<int>(b_.places.size()) - 1;
  }
  void paint(const Rectangle& area, int place) {
    painted_.push_back({area, place});
    if (place >= 0 && bounds_[place].high == bounds_[place].low) bounds_[place] = area;
  }

  void lay_out() {
    b_.wall = line(uniform(0.1, 0.25));
    low_ = b_.wall / 2;
    width_ = low_ + line(uniform(22, 44));
    height_ = low_ + line(uniform(13, 24));
    corridor_width_ = line(uniform(1.25, 2.6));
    const int corridor = add_place(TruePlaceKind::corridor);
    switch (random_.below(5)) {
      case 0:
        straight();
        break;
      case 1:
        bent();
        break;
      case 2:
        crossed();
        break;
      case 3:
        ring(false);
        break;
      default:
        ring(true);
    }
    for (const Rectangle& part : corridor_) paint(part, corridor);
    bounds_[corridor] = {{low_, low_}, {width_, height_}};
    dents();
  }

  void straight() {
    const double y0 = line(height_ * uniform(0.38, 0.55)), y1 = y0 + corridor_width_;
    double end = width_;
    if (chance(0.5)) {  // a room at its end
      end = line(width_ - uniform(3, 6));
      split({{{end, low_}, {width_, height_}}, Side::left});
    }
    corridor_ = {{{low_, y0}, {end, y1}}};
    split({{{low_, low_}, {end, y0}}, Side::top});
    split({{{low_, y1}, {end, height_}}, Side::bottom});
  }

  void bent() {
    const double y0 = line(uniform(4, 6.5)), y1 = y0 + corridor_width_;
    const double x0 = line(width_ * uniform(0.55, 0.75)), x1 = x0 + corridor_width_;
    const double inner = std::min(height_, line(y1 + uniform(4, 6)));
    corridor_ = {{{low_, y0}, {x1, y1}}, {{x0, y0}, {x1, height_}}};
    split({{{low_, low_}, {x1, y0}}, Side::top});
    split({{{x1, low_}, {width_, height_}}, Side::left});
    if (height_ - inner < 3) {
      split({{{low_, y1}, {x0, height_}}, Side::bottom});
    } else {
      split({{{low_, y1}, {x0, inner}}, Side::bottom});
      split({{{line(x0 - uniform(4, 6)), inner}, {x0, height_}}, Side::right});
    }
  }

  void crossed() {
    const double y0 = line(uniform(4, 6.5)), y1 = y0 + corridor_width_;
    const double x0 = line(width_ * uniform(0.35, 0.6)), x1 = x0 + line(uniform(1.25, 2.4));
    corridor_ = {{{low_, y0}, {width_, y1}}, {{x0, y0}, {x1, height_}}};
    split({{{low_, low_}, {width_, y0}}, Side::top});
    split({{{low_, y1}, {x0, height_}}, chance(0.5) ? Side::bottom : Side::right});
    split({{{x1, y1}, {width_, height_}}, chance(0.5) ? Side::bottom : Side::left});
  }

  void ring(bool around_hall) {
    width_ = std::max(width_, low_ + 30);
    height_ = std::max(height_, low_ + 20);
    const double a = line(uniform(3.4, 5)), w = std::min(corridor_width_, 2.2);
    const double x0 = a, x1 = width_ - a, y0 = a, y1 = height_ - a;
    corridor_ = {{{x0, y0}, {x1, y0 + w}},
                 {{x0, y1 - w}, {x1, y1}},
                 {{x0, y0}, {x0 + w, y1}},
                 {{x1 - w, y0}, {x1, y1}}};
    split({{{low_, low_}, {width_, y0}}, Side::top});
    split({{{low_, y1}, {width_, height_}}, Side::bottom});
    split({{{low_, y0}, {x0, y1}}, Side::right});
    split({{{x1, y0}, {width_, y1}}, Side::left});
    const Rectangle core{{x0 + w, y0 + w}, {x1 - w, y1 - w}};
    if (around_hall) {
      paint(core, add_place(TruePlaceKind::hall));
      return;
    }
    const double middle = line(core.low.y() + (core.high.y() - core.low.y()) * uniform(0.4, 0.6));
    split({{core.low, {core.high.x(), middle}}, Side::bottom});
    split({{{core.low.x(), middle}, core.high}, Side::top});
  }

  /// Rooms side by side along the corridor; now and then one hall; now and then one behind another.
  void split(const Block& block) {
    const bool along_x = block.corridor == Side::bottom || block.corridor == Side::top;
    const int axis = along_x ? 0 : 1;
    double at = block.area.low[axis];
    const double end = block.area.high[axis];
    while (at < end - 1e-9) {
      double size = chance(0.15)   ? uniform(6.5, 10)
                    : chance(0.25) ? uniform(2, 2.8)
                                   : uniform(2.8, 6);
      size = line(size);
      if (end - at - size < 2.2) size = end - at;
      Rectangle room = block.area;
      room.low[axis] = at;
      room.high[axis] = at + size;
      at += size;
      add_room(room, block.corridor);
    }
  }

  void add_room(Rectangle room, Side corridor) {
    const int across = corridor == Side::bottom || corridor == Side::top ? 1 : 0;
    const double depth = room.high[across] - room.low[across];
    const Vec2 size = room.high - room.low;
    if (depth > 6 && size.minCoeff() > 2.5 && chance(0.6)) {  // an inner room behind it
      const double cut = line(depth * uniform(0.4, 0.6));
      Rectangle back = room;
      if (corridor == Side::bottom || corridor == Side::left) {
        back.low[across] = room.high[across] = room.low[across] + cut;
      } else {
        back.high[across] = room.low[across] = room.high[across] - cut;
      }
      paint(back, add_place(TruePlaceKind::room));
    }
    const Vec2 left = room.high - room.low;
    const bool hall = left.minCoeff() > 5 && left.prod() > 45;
    paint(room, add_place(hall ? TruePlaceKind::hall : TruePlaceKind::room));
  }

  /// Niches of the corridor and shafts in the corners of rooms.
  void dents() {
    const std::size_t n = painted_.size();
    for (std::size_t i = 0; i < n; ++i) {
      const auto [area, place] = painted_[i];
      if (place <= 0 || (area.high - area.low).minCoeff() < 3.2 || !chance(0.2)) continue;
      const Vec2 size(line(uniform(0.5, 1.1)), line(uniform(0.5, 1.1)));
      const bool left = chance(0.5), low = chance(0.5);
      const Vec2 corner(left ? area.low.x() : area.high.x() - size.x(),
                        low ? area.low.y() : area.high.y() - size.y());
      paint({corner, corner + size}, chance(0.3) ? 0 : -1);
    }
  }

  // --- The grid of walls ------------------------------------------------------------------------

  void split_into_grid() {
    for (const Painted& p : painted_)
      for (const Vec2& v : {p.area.low, p.area.high}) {
        b_.xs.push_back(v.x());
        b_.ys.push_back(v.y());
      }
    for (auto* lines : {&b_.xs, &b_.ys}) {
      std::sort(lines->begin(), lines->end());
      lines->erase(std::unique(lines->begin(), lines->end(),
                               [](double a, double b) { return b - a < 1e-6; }),
                   lines->end());
    }
    b_.owner.assign((b_.xs.size() - 1) * (b_.ys.size() - 1), -1);
    for (std::size_t iy = 0; iy + 1 < b_.ys.size(); ++iy)
      for (std::size_t ix = 0; ix + 1 < b_.xs.size(); ++ix) {
        const Vec2 middle(0.5 * (b_.xs[ix] + b_.xs[ix + 1]), 0.5 * (b_.ys[iy] + b_.ys[iy + 1]));
        for (const Painted& p : painted_)
          if (p.area.contains(middle)) b_.owner[iy * (b_.xs.size() - 1) + ix] = p.place;
      }
  }

  int owner(int ix, int iy) const {
    const int nx = static_cast<int>(b_.xs.size()) - 1, ny = static_cast<int>(b_.ys.size()) - 1;
    return ix < 0 || iy < 0 || ix >= nx || iy >= ny ? -1 : b_.owner[iy * nx + ix];
  }

  /// Both sides of every piece of every line: visit(upright, line, low, high, a, b).
  template <class Visit>
  void for_each_piece(const Visit& visit) const {
    const int nx = static_cast<int>(b_.xs.size()), ny = static_cast<int>(b_.ys.size());
    for (int ix = 0; ix < nx; ++ix)
      for (int iy = 0; iy + 1 < ny; ++iy)
        visit(true, b_.xs[ix], b_.ys[iy], b_.ys[iy + 1], owner(ix - 1, iy), owner(ix, iy));
    for (int iy = 0; iy < ny; ++iy)
      for (int ix = 0; ix + 1 < nx; ++ix)
        visit(false, b_.ys[iy], b_.xs[ix], b_.xs[ix + 1], owner(ix, iy - 1), owner(ix, iy));
  }

  std::vector<SharedWall> shared_walls() const {
    std::vector<SharedWall> walls;
    for_each_piece([&](bool upright, double at, double low, double high, int a, int b) {
      if (a == b) return;
      if (!walls.empty()) {
        SharedWall& last = walls.back();
        if (last.upright == upright && last.at == at && last.high == low && last.a == a &&
            last.b == b) {
          last.high = high;
          return;
        }
      }
      walls.push_back({upright, at, low, high, a, b});
    });
    return walls;
  }

  // --- Doors ------------------------------------------------------------------------------------

  void place_doors() {
    std::vector<bool> joined(b_.places.size(), false);
    joined[0] = true;
    for (bool more = true; more;) {
      more = false;
      for (int place = 1; place < static_cast<int>(joined.size()); ++place) {
        if (joined[place] || !join(place, joined)) continue;
        joined[place] = more = true;
      }
    }
    for (const SharedWall& wall : shared_)  // doors from room to room
      if (wall.a > 0 && wall.b > 0 && chance(0.08)) add_door(wall, kNarrowest, kWidest, false);
    for (const SharedWall& wall : shared_) {  // halls have more than one, and openings
      const bool hall =
          wall.a >= 0 && wall.b >= 0 &&
          (b_.places[wall.a] == TruePlaceKind::hall) != (b_.places[wall.b] == TruePlaceKind::hall);
      if (!hall || std::min(wall.a, wall.b) != 0) continue;
      if (chance(0.3)) add_door(wall, 1.4, 1.9, false);
      if (chance(0.15)) add_door(wall, 2.4, 3.5, true);
    }
  }

  /// A door to somewhere that is joined already, to the corridor if it can be.
  bool join(int place, const std::vector<bool>& joined) {
    std::vector<SharedWall> choice;
    for (const bool corridor : {true, false}) {
      for (const SharedWall& wall : shared_) {
        const int other = wall.a == place ? wall.b : wall.b == place ? wall.a : -1;
        if (other < 0 || !joined[other] || (other == 0) != corridor) continue;
        if (wall.high - wall.low > 1.6) choice.push_back(wall);
      }
      if (!choice.empty()) break;
    }
    const bool wide = b_.places[place] == TruePlaceKind::hall ? chance(0.5) : chance(0.06);
    while (!choice.empty()) {
      const std::size_t k = random_.below(choice.size());
      if (wide && add_door(choice[k], 1.4, 1.9, false)) return true;
      if (add_door(choice[k], kNarrowest, kWidest, false)) return true;
      choice.erase(choice.begin() + static_cast<std::ptrdiff_t>(k));
    }
    return false;
  }

  bool add_door(const SharedWall& wall, double narrowest, double widest, bool opening) {
    const double width = line(uniform(narrowest, widest));
    const double margin = width / 2 + b_.wall / 2 + 0.1;
    const double low = wall.low + margin, high = wall.high - margin;
    if (high < low) return false;
    double at = snapped(uniform(low, high));
    if (at < low) at += kTourCell;
    if (at > high) at -= kTourCell;
    if (at < low) return false;
    TrueDoor door;
    door.along = wall.upright ? Vec2(0, 1) : Vec2(1, 0);
    door.centre = wall.upright ? Vec2(wall.at, at) : Vec2(at, wall.at);
    door.width = width;
    door.from = wall.a;
    door.to = wall.b;
    door.opening = opening;
    for (const TrueDoor& other : b_.doors)
      if ((other.centre - door.centre).norm() < 0.5 * (other.width + width) + 0.8) return false;
    b_.doors.push_back(door);
    return true;
  }

  // --- Walls and what stands about --------------------------------------------------------------

  void box(const Rectangle& r, double reflectivity) {
    const Vec2 p[4] = {r.low, {r.high.x(), r.low.y()}, r.high, {r.low.x(), r.high.y()}};
    for (int i = 0; i < 4; ++i) b_.scene.segments.push_back({p[i], p[(i + 1) % 4], reflectivity});
  }

  void build_walls() {
    struct Run {
      bool upright;
      double at, low, high;
    };
    std::vector<Run> runs;
    for (const SharedWall& w : shared_) {
      const bool on = !runs.empty() && runs.back().upright == w.upright && runs.back().at == w.at &&
                      runs.back().high == w.low;
      if (on)
        runs.back().high = w.high;
      else
        runs.push_back({w.upright, w.at, w.low, w.high});
    }
    const double half = b_.wall / 2;
    for (const Run& run : runs) {
      const int axis = run.upright ? 1 : 0;
      std::vector<std::pair<double, double>> gaps;
      for (const TrueDoor& d : b_.doors)
        if (d.along[axis] == 1 && d.centre[1 - axis] == run.at && d.centre[axis] > run.low &&
            d.centre[axis] < run.high)
          gaps.emplace_back(d.centre[axis] - d.width / 2, d.centre[axis] + d.width / 2);
      std::sort(gaps.begin(), gaps.end());
      gaps.emplace_back(run.high + half, 0);
      double from = run.low - half;
      for (const auto& [low, high] : gaps) {
        Rectangle r;
        r.low[axis] = from;
        r.high[axis] = low;
        r.low[1 - axis] = run.at - half;
        r.high[1 - axis] = run.at + half;
        box(r, 0.6);
        from = high;
      }
    }
  }

  /// A thin box from the hinge, `angle` away from the closed door.
  void leaf(const Vec2& hinge, const Vec2& closed, const Vec2& into, double length, double angle) {
    const Vec2 way = closed * std::cos(angle) + into * std::sin(angle);
    const Vec2 side = 0.02 * Vec2(-way.y(), way.x());
    const Vec2 p[4] = {hinge + side, hinge - side, hinge + length * way - side,
                       hinge + length * way + side};
    for (int i = 0; i < 4; ++i) b_.scene.segments.push_back({p[i], p[(i + 1) % 4], 0.5});
  }

  void hang_leaves(const TrueDoor& door) {
    if (door.opening || chance(0.4)) return;  // taken out, or pushed into a pocket
    const bool pair = door.width > 1.3;
    const double length = (pair ? door.width / 2 : door.width) - 0.04;
    Vec2 into(door.along.y(), door.along.x());
    if (door.to == 0 || (door.from != 0 && chance(0.5))) into = -into;  // into the room
    // The robot passes on one of its grid's lines.
    double line_at = door.width / 2;
    while (line_at + kTourCell <= door.width - kRobot) line_at += kTourCell;
    const double least =
        std::max(radians(40), std::acos(std::clamp((line_at - kRobot - 0.02) / length, 0.0, 1.0)));
    const double angle = std::max(least, uniform(least, radians(100)));
    const double end = chance(0.5) ? 1 : -1;
    const Vec2 face = door.centre + into * (b_.wall / 2);
    leaf(face + end * door.along * (door.width / 2 - 0.02), -end * door.along, into, length, angle);
    if (pair)
      leaf(face - end * door.along * (door.width / 2 - 0.02), end * door.along, into, length,
           radians(92));
  }

  bool clear(const Rectangle& r, int place) const {
    for (double fx = 0; fx <= 1; fx += 0.25)
      for (double fy = 0; fy <= 1; fy += 0.25) {
        const Vec2 p = r.low + Vec2(fx, fy).cwiseProduct(r.high - r.low);
        if (b_.place_at(p) != place) return false;
      }
    for (const TrueDoor& d : b_.doors) {
      const Vec2 across(d.along.y(), d.along.x());
      const Vec2 half = d.along * (d.width / 2 + 0.4) + across * kClearAhead;
      if (overlap(r, {d.centre - half, d.centre + half})) return false;
    }
    return std::none_of(things_.begin(), things_.end(),
                        [&](const Rectangle& other) { return overlap(grown(r, kLane), other); });
  }
  static Rectangle grown(const Rectangle& r, double by) {
    return {r.low - Vec2::Constant(by), r.high + Vec2::Constant(by)};
  }
  static bool overlap(const Rectangle& a, const Rectangle& b) {
    return (a.low.array() < b.high.array()).all() && (b.low.array() < a.high.array()).all();
  }

  /// Against the wall on a side of the room: `length` along it, `depth` out of it.
  void against_wall(int place, double length, double depth) {
    const double gap = chance(0.5) ? 0.005 : uniform(0.01, 0.12);
    const Rectangle in = grown(bounds_[place], -(b_.wall / 2 + gap));
    const int axis = chance(0.5) ? 0 : 1;  // along which it stands
    const double room = in.high[axis] - in.low[axis];
    if (room < length || in.high[1 - axis] - in.low[1 - axis] < depth + 1.2) return;
    Rectangle r;
    r.low[axis] = in.low[axis] + (chance(0.4) ? 0 : uniform(0, room - length));
    r.high[axis] = r.low[axis] + length;
    if (chance(0.5)) {
      r.low[1 - axis] = in.low[1 - axis];
      r.high[1 - axis] = r.low[1 - axis] + depth;
    } else {
      r.high[1 - axis] = in.high[1 - axis];
      r.low[1 - axis] = r.high[1 - axis] - depth;
    }
    if (!clear(r, place)) return;
    box(r, 0.35);
    things_.push_back(r);
  }

  void legs(const Rectangle& r) {
    const Vec2 p[4] = {r.low, {r.high.x(), r.low.y()}, r.high, {r.low.x(), r.high.y()}};
    for (const Vec2& leg : p) b_.scene.discs.push_back({leg, 0.03, 0.4});
  }

  void free_standing(int place, const Vec2& size, bool on_legs) {
    const Rectangle& in = bounds_[place];
    const Vec2 room = in.high - in.low - size - Vec2::Constant(2.2);
    if (room.minCoeff() <= 0) return;
    const Vec2 at = in.low + Vec2::Constant(1.1) + Vec2(uniform(0, room.x()), uniform(0, room.y()));
    const Rectangle r{at, at + size};
    if (!clear(r, place)) return;
    if (on_legs)
      legs(r);
    else
      box(r, 0.35);
    things_.push_back(r);
  }

  void round_thing(int place, double radius) {
    const Rectangle& in = bounds_[place];
    const Vec2 p(uniform(in.low.x(), in.high.x()), uniform(in.low.y(), in.high.y()));
    const Rectangle r{p - Vec2::Constant(radius), p + Vec2::Constant(radius)};
    if (!clear(r, place)) return;
    b_.scene.discs.push_back({p, radius, 0.4});
    things_.push_back(r);
  }

  void furnish(int place) {
    const Vec2 size = bounds_[place].high - bounds_[place].low;
    const auto tries = [&](double a_square_metre) {
      return static_cast<int>(1 + size.prod() * a_square_metre);
    };
    switch (b_.places[place]) {
      case TruePlaceKind::corridor:
        if (corridor_width_ < 1.9) break;
        for (const Rectangle& part : corridor_) {
          bounds_[place] = part;
          for (int i = 0; i < 4; ++i) against_wall(place, uniform(0.4, 1.6), uniform(0.2, 0.4));
        }
        break;
      case TruePlaceKind::hall:
        for (int i = tries(0.08); i > 0; --i) free_standing(place, {1.6, 1.6}, chance(0.3));
        for (int i = tries(0.02); i > 0; --i) round_thing(place, uniform(0.15, 0.25));
        for (int i = tries(0.05); i > 0; --i)
          against_wall(place, uniform(0.8, 2.4), uniform(0.3, 0.8));
        break;
      case TruePlaceKind::room:
        for (int i = tries(0.3); i > 0; --i) {
          const bool peninsula = chance(0.15);
          if (peninsula)
            against_wall(place, uniform(0.7, 0.8), uniform(1.2, 1.6));
          else
            against_wall(place, uniform(0.6, 2), uniform(0.3, 0.8));
        }
        if (chance(0.5)) free_standing(place, {uniform(0.8, 1.6), uniform(0.8, 1.6)}, chance(0.5));
        for (int i = tries(0.05); i > 0; --i) round_thing(place, uniform(0.15, 0.25));
        break;
    }
  }

  // --- The tour ---------------------------------------------------------------------------------

  double free_around(const Vec2& p, int place) const {
    if (b_.place_at(p) != place) return -1;
    double least = 1.5;
    for (const Segment& s : b_.scene.segments) least = std::min(least, distance_to(s, p));
    for (const Disc& d : b_.scene.discs) least = std::min(least, (p - d.centre).norm() - d.radius);
    for (const Rectangle& r : things_)
      if (r.contains(p)) return -1;
    return least;
  }

  /// The spot of an area with most room around it, near its middle if there are several.
  Vec2 widest_spot(const Rectangle& area, int place) const {
    Vec2 best = 0.5 * (area.low + area.high);
    const Vec2 middle = best;
    double most = -1;
    for (double x = snapped(area.low.x()); x < area.high.x(); x += kTourCell)
      for (double y = snapped(area.low.y()); y < area.high.y(); y += kTourCell) {
        const double score = free_around({x, y}, place) - 0.02 * (Vec2(x, y) - middle).norm();
        if (score > most) {
          most = score;
          best = {x, y};
        }
      }
    return best;
  }

  /// Spots of a place: one, or, where it is large, one for each part of about 5 m.
  std::vector<Vec2> spots(int place) const {
    std::vector<Rectangle> parts = place == 0 ? corridor_ : std::vector{bounds_[place]};
    std::vector<Vec2> found;
    for (const Rectangle& part : parts) {
      const Vec2 size = part.high - part.low;
      const int nx = std::max(1, static_cast<int>(size.x() / 5)),
                ny = std::max(1, static_cast<int>(size.y() / 5));
      for (int ix = 0; ix < nx; ++ix)
        for (int iy = 0; iy < ny; ++iy) {
          const Vec2 step(size.x() / nx, size.y() / ny);
          const Vec2 low = part.low + Vec2(ix * step.x(), iy * step.y());
          const Vec2 spot = widest_spot({low, low + step}, place);
          if (free_around(spot, place) > kRobot + 0.1) found.push_back(spot);
        }
    }
    return found;
  }

  /// All spots of a place, the nearest next, and the rooms behind its doors when it comes by.
  void visit(int place, Vec2 here, std::vector<bool>& seen) {
    seen[place] = true;
    std::vector<Vec2> left = spots(place);
    const auto nearest = [&](const auto& list, const auto& where) {
      std::size_t best = 0;
      for (std::size_t i = 1; i < list.size(); ++i)
        if ((where(list[i]) - here).norm() < (where(list[best]) - here).norm()) best = i;
      return best;
    };
    for (;;) {
      std::vector<TrueDoor> doors;
      for (const TrueDoor& d : b_.doors)
        if ((d.from == place && !seen[d.to]) || (d.to == place && !seen[d.from]))
          doors.push_back(d);
      if (doors.empty() && left.empty()) return;
      const std::size_t s = nearest(left, [](const Vec2& p) { return p; });
      const std::size_t d = nearest(doors, [](const TrueDoor& t) { return t.centre; });
      const bool spot_first =
          doors.empty() ||
          (!left.empty() && (left[s] - here).norm() < (doors[d].centre - here).norm());
      if (spot_first) {
        here = left[s];
        left.erase(left.begin() + static_cast<std::ptrdiff_t>(s));
        b_.scene.tour.push_back(here);
      } else {
        here = doors[d].centre;
        visit(doors[d].from == place ? doors[d].to : doors[d].from, here, seen);
        b_.scene.tour.push_back(here);  // out by the same door
      }
    }
  }

  void make_tour() {
    const std::vector<Vec2> corridor = spots(0);
    const Vec2 start = corridor.empty() ? widest_spot(corridor_[0], 0) : corridor[0];
    b_.scene.start = {start.x(), start.y(), 0};
    std::vector<bool> seen(b_.places.size(), false);
    visit(0, start, seen);
    b_.scene.tour.push_back(start);
  }

  RandomStream random_;
  GeneratedBuilding b_;
  double low_ = 0, width_ = 0, height_ = 0, corridor_width_ = 0;
  std::vector<Painted> painted_;
  std::vector<Rectangle> bounds_;    ///< by place
  std::vector<Rectangle> corridor_;  ///< its parts
  std::vector<SharedWall> shared_;
  std::vector<Rectangle> things_;
};

/// Does the tour lead into every place?
bool drivable(const GeneratedBuilding& building) {
  Path path;
  try {
    path = plan_tour(World(building.scene));
  } catch (const Error&) {  // a room is furnished too densely
    return false;
  }
  std::set<int> visited;
  for (const Vec2& p : path.points) visited.insert(building.place_at(p));
  visited.erase(-1);
  return visited.size() == building.places.size();
}

}  // namespace

int GeneratedBuilding::place_at(const Vec2& p) const {
  const auto field = [&](double x, double y) {
    const auto ix = std::upper_bound(xs.begin(), xs.end(), x) - xs.begin() - 1;
    const auto iy = std::upper_bound(ys.begin(), ys.end(), y) - ys.begin() - 1;
    const auto nx = static_cast<std::ptrdiff_t>(xs.size()) - 1;
    const auto ny = static_cast<std::ptrdiff_t>(ys.size()) - 1;
    return ix < 0 || iy < 0 || ix >= nx || iy >= ny ? -1
                                                    : owner[static_cast<std::size_t>(iy * nx + ix)];
  };
  const int here = field(p.x(), p.y());
  for (const double dx : {-wall / 2, 0.0, wall / 2})
    for (const double dy : {-wall / 2, 0.0, wall / 2})
      if (field(p.x() + dx, p.y() + dy) != here) return -1;
  return here;
}

GeneratedBuilding generated_building(std::uint64_t seed) {
  for (std::uint64_t attempt = 0;; ++attempt) {
    GeneratedBuilding building = Planner(seed, attempt).plan();
    if (drivable(building)) return building;
  }
}

}  // namespace majak::sim
