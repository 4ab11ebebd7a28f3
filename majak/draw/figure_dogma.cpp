// SPDX-License-Identifier: Apache-2.0
// Figure 21 of the thesis, after Biswas, Limketkai, Sanner and Thrun (2002): nine grids of a room
// over time, what stays, and the objects that moved; and a tenth visit in which one has moved
// again.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "majak/draw/sketch.hpp"
#include "majak/draw/thesis_figures.hpp"
#include "majak/map/objects.hpp"
#include "majak/sim/furnished_room.hpp"

namespace majak::draw {
namespace {

constexpr std::uint64_t kSeed = 7;
constexpr std::size_t kVisits = 9, kMoved = 0;  // the box moves before the tenth
constexpr double kAbsent = 0.1;
constexpr Colour kColours[] = {ink::blue, ink::red, ink::green, ink::orange, ink::purple, ink::sky};

Colour colour_of(std::size_t object) { return kColours[object % std::size(kColours)]; }

map::KnownMap snapshot(const sim::Furnishing& furnishing, std::uint64_t visit) {
  return map::known_map(
      map::build_occupancy_grid(sim::visit_room(furnishing, 100 * kSeed + visit)));
}

void set(io::Image& image, int x, int y, const Colour& c) {
  std::uint8_t* pixel = image.row(image.height - 1 - y) + static_cast<std::ptrdiff_t>(3) * x;
  pixel[0] = c.r, pixel[1] = c.g, pixel[2] = c.b;
}

Picture grid(const map::KnownMap& map) {
  Picture picture{io::Image(map.width, map.height, 3), {map.x0, map.y0}, map.resolution};
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x)
      set(picture.image, x, y,
          map.at(x, y) == map::CellState::occupied ? ink::black
          : map.at(x, y) == map::CellState::free   ? ink::white
                                                   : ink::light);
  return picture;
}

void paint(Picture& picture, const map::KnownMap& map, const map::Piece& piece, const Colour& c) {
  for (const Vec2& p : piece.points) set(picture.image, map.column(p.x()), map.row(p.y()), c);
}

/// White where it is free or unseen, the object's colour where it is occupied.
Picture looks(const map::ObjectShape& shape, const Colour& c) {
  const int half = shape.half(), side = 2 * half + 1;
  const double low = -(half + 0.5) * shape.resolution();
  Picture picture{io::Image(side, side, 3), {low, low}, shape.resolution()};
  for (int y = -half; y <= half; ++y)
    for (int x = -half; x <= half; ++x) {
      const double p = std::clamp((shape.chance(x, y) - 0.15) / 0.6, 0.0, 1.0);
      const auto mix = [p](std::uint8_t v) {
        return static_cast<std::uint8_t>(std::lround(255 + p * (v - 255)));
      };
      set(picture.image, x + half, y + half, {mix(c.r), mix(c.g), mix(c.b)});
    }
  return picture;
}

Panel sketch(const Box& place, const std::string& title, Picture picture) {
  Panel panel{.place = place, .title = title, .framed = false};
  panel.marks = {std::move(picture)};
  return panel;
}

}  // namespace

Figure figure_dogma(const std::vector<Event>& /*events*/) {
  std::vector<sim::Furnishing> furnishings;
  std::vector<map::KnownMap> snapshots;
  for (std::size_t t = 0; t < kVisits; ++t) {
    furnishings.push_back(sim::furnish(kSeed, t, kAbsent));
    snapshots.push_back(snapshot(furnishings[t], t));
  }
  const map::ObjectMap found = map::find_objects(snapshots);
  const map::KnownMap after = snapshot(sim::moved_one(furnishings.back(), kMoved, kSeed), kVisits);
  const map::Recognition seen = map::recognize(found, after);

  Figure figure{.width = 1500,
                .height = 860,
                .title = "Nine visits to a room: what stays, and " +
                         std::to_string(found.objects.size()) + " objects that move"};
  const Box all = figure.whole();
  const double third = all.height / 3, wide = 270;
  for (std::size_t t = 0; t < kVisits; ++t) {
    Picture picture = grid(snapshots[t]);
    for (const map::ObjectSighting& s : found.sightings)
      if (const map::Piece& piece = found.pieces[s.piece]; piece.snapshot == t)
        paint(picture, snapshots[t], piece, colour_of(s.object));
    const auto column = static_cast<double>(t % 3), row = static_cast<double>(t / 3);
    figure.panels.push_back(sketch({column * wide, all.top + row * third, wide, third},
                                   "visit " + std::to_string(t + 1), std::move(picture)));
  }
  const double left = 3 * wide + 20, middle = 380;
  figure.panels.push_back(
      sketch({left, all.top, middle, all.height / 2}, "what stays", grid(found.still)));
  Picture tenth = grid(after);
  Panel moved = sketch({left, all.top + all.height / 2, middle, all.height / 2},
                       "a tenth visit: what stands where", {});
  for (const map::ObjectSighting& s : seen.sightings)
    paint(tenth, after, seen.pieces[s.piece], colour_of(s.object));
  moved.marks = {std::move(tenth)};
  for (const map::ObjectSighting& s : seen.sightings) {
    const Vec2 middle_of = s.T_map_object * found.objects[s.object].middle();
    moved.marks.emplace_back(Label{.at = point(middle_of),
                                   .text = std::to_string(s.object + 1),
                                   .dy = -5,
                                   .anchor = Anchor::middle,
                                   .colour = colour_of(s.object)});
  }
  figure.panels.push_back(std::move(moved));
  const double right = left + middle + 20;
  const double tall =
      all.height / static_cast<double>(std::max<std::size_t>(found.objects.size(), 1));
  for (std::size_t n = 0; n < found.objects.size(); ++n) {
    const auto times = std::count_if(found.sightings.begin(), found.sightings.end(),
                                     [&](const auto& s) { return s.object == n; });
    figure.panels.push_back(
        sketch({right, all.top + static_cast<double>(n) * tall, all.width - right, tall},
               "object " + std::to_string(n + 1) + ", seen " + std::to_string(times) + " times",
               looks(found.objects[n], colour_of(n))));
  }
  return figure;
}

}  // namespace majak::draw
