// SPDX-License-Identifier: Apache-2.0
#include "majak/sim/park.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "majak/core/random.hpp"

namespace majak::sim {

namespace {

constexpr double kWidth = 250, kHeight = 200;         // m
constexpr double kVerge = 3.2;                        // m, free beside a way's middle
constexpr double kCornerRadius = 9, kBowRadius = 30;  // m
constexpr double kBark = 0.35, kLeaves = 0.3, kPlaster = 0.6, kPaint = 0.4;  // reflectivity
constexpr std::uint64_t kSeed = 2026;                                        // of the planting
constexpr std::uint64_t kBows = 1, kRows = 2, kGroves = 3, kLone = 4, kBushes = 5;

//  I----J----K----L    The crossings. Every way between two neighbours bends once, to the side
//  |    |    |    |    and as far as its own draw says.
//  E----F----G----H
//  |    |    |    |
//  A----B----C----D
const Vec2 kCrossings[] = {{25, 30},   {95, 22},  {165, 35}, {228, 28}, {18, 105},  {88, 98},
                           {158, 108}, {232, 95}, {30, 172}, {98, 180}, {170, 168}, {225, 175}};
constexpr std::string_view kTour = "FGCBFEIJFGHLKGFBAEIJKLHDCBFG";
constexpr std::string_view kShortTour = "FGC";

Vec2 crossing(char name) { return kCrossings[name - 'A']; }

/// The middle of the way between two crossings, the same from either end.
Vec2 bow(char from, char to) {
  const auto [a, b] = std::minmax(from, to);
  RandomStream random(kSeed, kBows, static_cast<std::uint64_t>(a) << 8 | static_cast<unsigned>(b));
  const double side = random.uniform() < 0.5 ? -1 : 1;
  const Vec2 along = (crossing(b) - crossing(a)).normalized();
  return (crossing(a) + crossing(b)) / 2 +
         side * random.uniform(2, 5) * Vec2(-along.y(), along.x());
}

/// The corner between two straight lines, cut by an arc.
void add_arc(std::vector<Vec2>& way, const Vec2& before, const Vec2& corner, const Vec2& after,
             double radius) {
  const Vec2 in = (corner - before).normalized(), out = (after - corner).normalized();
  const double turn = std::atan2(in.x() * out.y() - in.y() * out.x(), in.dot(out));
  const Vec2 begin = corner - radius * std::tan(std::abs(turn) / 2) * in;
  const double side = turn < 0 ? -1 : 1;
  const Vec2 left(-in.y(), in.x());
  const int parts = std::max(1, static_cast<int>(std::ceil(std::abs(turn) * radius)));  // of 1 m
  for (int i = 0; i <= parts; ++i) {
    const double a = std::abs(turn) * i / parts;
    way.push_back(begin + radius * (std::sin(a) * in + side * (1 - std::cos(a)) * left));
  }
}

/// From a point on the first way to the like point on the last.
std::vector<Vec2> way_along(std::string_view names) {
  const auto middle = [&](std::size_t i) { return bow(names[i], names[i + 1]); };
  const auto place = [&](std::size_t i) {
    return Vec2(0.75 * middle(i) + 0.25 * crossing(names[i + 1]));
  };
  std::vector<Vec2> way{place(0)};
  for (std::size_t i = 1; i + 1 < names.size(); ++i) {
    const Vec2 here = crossing(names[i]);
    add_arc(way, middle(i - 1), here, middle(i), kCornerRadius);
    add_arc(way, here, middle(i), crossing(names[i + 1]), kBowRadius);
  }
  way.push_back(place(names.size() - 2));
  return way;
}

class Gardener {
 public:
  explicit Gardener(Scene& scene) : scene_(scene) {
    for (std::size_t i = 1; i < scene.tour.size(); ++i)
      ways_.push_back({scene.tour[i - 1], scene.tour[i], 0});
  }

  /// A closed line of n corners about its centre.
  void hedge(const Pose2& T_world_thing, const std::vector<Vec2>& corners, double reflectivity) {
    for (std::size_t i = 0; i < corners.size(); ++i)
      scene_.segments.push_back({T_world_thing * corners[i],
                                 T_world_thing * corners[(i + 1) % corners.size()], reflectivity});
  }
  void box(const Pose2& T_world_box, double length, double width, double reflectivity) {
    const double l = length / 2, w = width / 2;
    hedge(T_world_box, {{-l, -w}, {l, -w}, {l, w}, {-l, w}}, reflectivity);
  }

  void bush(RandomStream& random) {
    const Vec2 centre = anywhere(random);
    const double size = random.uniform(0.5, 1.2);
    if (!is_room(centre, size)) return;
    std::vector<Vec2> corners;
    for (int i = 0; i < 7; ++i) {
      const double a = 2 * kPi * i / 7, r = size * random.uniform(0.7, 1);
      corners.push_back(r * Vec2(std::cos(a), std::sin(a)));
    }
    hedge({centre.x(), centre.y(), 0}, corners, kLeaves);
  }

  /// Most trunks are thin. Nothing where there is no room.
  void trunk(const Vec2& centre, RandomStream& random) {
    const double thick = random.uniform(), radius = 0.1 + 0.4 * thick * thick;
    if (is_room(centre, radius)) scene_.discs.push_back({centre, radius, kBark});
  }

  void row(char from, char to, double side, RandomStream& random) {
    constexpr double kStep = 8, kAside = 4.4;  // m
    const Vec2 corners[] = {crossing(from), bow(from, to), crossing(to)};
    for (int leg = 0; leg < 2; ++leg) {
      const Vec2 way = corners[leg + 1] - corners[leg], along = way.normalized();
      for (double at = kStep / 2; at < way.norm(); at += kStep)
        trunk(corners[leg] + (at + random.uniform(-0.7, 0.7)) * along +
                  side * (kAside + random.uniform(-0.4, 0.4)) * Vec2(-along.y(), along.x()),
              random);
    }
  }

  void grove(int trunks, RandomStream& random) {
    const Vec2 centre = anywhere(random);
    for (int i = 0; i < trunks; ++i)
      trunk(centre + 7 * Vec2(random.normal(), random.normal()), random);
  }

  static Vec2 anywhere(RandomStream& random) {
    const double x = random.uniform(2, kWidth - 2);
    return {x, random.uniform(2, kHeight - 2)};
  }

 private:
  bool is_room(const Vec2& centre, double radius) const {
    constexpr double kApart = 1.2;  // m, between surfaces
    const auto off = [&](const auto& segments, double space) {
      return std::all_of(segments.begin(), segments.end(),
                         [&](const Segment& s) { return distance_to(s, centre) > radius + space; });
    };
    const bool in_park =
        centre.x() > 1 && centre.y() > 1 && centre.x() < kWidth - 1 && centre.y() < kHeight - 1;
    return in_park && off(ways_, kVerge) && off(scene_.segments, kApart) &&
           std::all_of(scene_.discs.begin(), scene_.discs.end(), [&](const Disc& d) {
             return (d.centre - centre).norm() > radius + d.radius + kApart;
           });
  }

  Scene& scene_;
  std::vector<Segment> ways_;
};

void plant(Gardener& gardener) {
  RandomStream bushes(kSeed, kBushes), rows(kSeed, kRows), lone(kSeed, kLone);
  for (int i = 0; i < 16; ++i) gardener.bush(bushes);
  constexpr std::tuple<char, char, double> kPlanted[] = {
      {'E', 'I', 1}, {'E', 'I', -1}, {'B', 'C', -1}, {'G', 'H', 1}, {'H', 'L', -1},
      {'J', 'K', 1}, {'A', 'B', 1},  {'B', 'F', 1},  {'F', 'G', 1}, {'F', 'J', -1}};
  for (const auto& [from, to, side] : kPlanted) gardener.row(from, to, side, rows);
  for (int i = 0; i < 9; ++i) {
    RandomStream grove(kSeed, kGroves, static_cast<std::uint64_t>(i));
    gardener.grove(13, grove);
  }
  for (int i = 0; i < 60; ++i) gardener.trunk(Gardener::anywhere(lone), lone);
}

}  // namespace

Scene park() {
  Scene scene;
  scene.name = "park";
  scene.straight = true;
  scene.tour = way_along(kTour);
  scene.short_tour = way_along(kShortTour);
  const Vec2 ahead = scene.tour[1] - scene.tour[0];
  scene.start = {scene.tour[0].x(), scene.tour[0].y(), std::atan2(ahead.y(), ahead.x())};
  Gardener gardener(scene);
  gardener.box({124, 62, 0.1}, 9, 6, kPlaster);
  gardener.box({56, 62, 0.4}, 16, 0.4, kPlaster);
  for (int i = 0; i < 5; ++i) gardener.box({186 + 3.1 * i, 134, 1.5 + 0.03 * i}, 4.4, 1.8, kPaint);
  plant(gardener);
  return scene;
}

}  // namespace majak::sim
