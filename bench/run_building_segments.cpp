// SPDX-License-Identifier: Apache-2.0
// Segments of the simulated building, whose walls are known.
//   run_building_segments [--seeds N] [--first N] [--noise M] [--pose-sigma M] [--list] [NAME=VALUE
//   ...]
// Each seed is a drive through the turned building with ranges' noise, and, where asked for, poses
// drawn with the covariance that they state. A wall is seen whole when 98 % of its steps of 5 cm
// were hit; a step, and an end, is seen where three returns came from it.
#include <fmt/core.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/io/options_file.hpp"
#include "majak/map/segment_map.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/tour.hpp"

namespace {

using namespace majak;

constexpr int kBeams = 361;
constexpr double kStep = 0.05;  // m
constexpr int kSeen = 3;        // returns, for a step of a wall to count as seen

struct Setting {
  int seeds = 10;
  int first = 0;
  double noise = 0.01;      // m, of a range
  double pose_sigma = 0.0;  // m, of each pose; of its heading a fifth of it in rad
  bool list = false;
  map::SegmentMapOptions options;
};

sim::Scene turned(sim::Scene scene, const Pose2& T) {
  for (sim::Segment& s : scene.segments) s.a = T * s.a, s.b = T * s.b;
  for (sim::Disc& d : scene.discs) d.centre = T * d.centre;
  for (Vec2& p : scene.tour) p = T * p;
  for (Vec2& p : scene.short_tour) p = T * p;
  scene.start = T * scene.start;
  return scene;
}

struct Drive {
  Site site;
  std::vector<std::vector<int>> hit;  // returns from each wall, by steps
};

Drive drive(const sim::World& world, const sim::Path& path, const Setting& setting, int seed) {
  Drive drive;
  const auto& scene = world.scene().segments;
  drive.hit.resize(scene.size());
  RandomStream random(3, static_cast<std::uint64_t>(seed));
  for (std::size_t i = static_cast<std::size_t>(seed) % 3; i + 3 < path.points.size(); i += 3) {
    const Vec2 p = path.points[i], way = path.points[i + 3] - p;
    PosedScan posed;
    posed.scan.start_angle = -kPi / 2;
    posed.scan.angle_step = kPi / (kBeams - 1);
    posed.scan.max_range = 30;
    const Pose2 pose{p.x(), p.y(), std::atan2(way.y(), way.x())};
    for (std::size_t k = 0; k < kBeams; ++k) {
      const sim::Hit at = world.cast(p, pose.theta + posed.scan.angle(k), 30);
      posed.scan.ranges.push_back(
          std::isfinite(at.range) ? static_cast<float>(at.range + setting.noise * random.normal())
                                  : kNoReturn);
      if (at.object < 0 || at.object >= static_cast<int>(scene.size())) continue;
      const auto object = static_cast<std::size_t>(at.object);
      const double angle = pose.theta + posed.scan.angle(k);
      const Vec2 end = p + at.range * Vec2(std::cos(angle), std::sin(angle));
      auto& hit = drive.hit[object];
      hit.resize(
          static_cast<std::size_t>(std::ceil((scene[object].b - scene[object].a).norm() / kStep)));
      ++hit[std::min(hit.size() - 1,
                     static_cast<std::size_t>((end - scene[object].a).norm() / kStep))];
    }
    const double s = setting.pose_sigma;
    posed.estimate.T_map_robot = {pose.x + s * random.normal(), pose.y + s * random.normal(),
                                  wrap_angle(pose.theta + s / 5 * random.normal())};
    posed.estimate.covariance.diagonal() << s * s, s * s, s * s / 25;
    drive.site.scans.push_back(posed);
  }
  return drive;
}

/// The map's segments that are of this wall: near and along it, for a tenth of it.
std::vector<map::Segment> of_wall(const std::vector<map::Segment>& map, const sim::Segment& wall) {
  std::vector<map::Segment> found;
  const Vec2 t = (wall.b - wall.a).normalized();
  const double length = (wall.b - wall.a).norm();
  for (const map::Segment& s : map) {
    const double a = t.dot(s.a - wall.a), b = t.dot(s.b - wall.a);
    const double common = std::min(length, std::max(a, b)) - std::max(0.0, std::min(a, b));
    const double aside = std::abs(map::Segment::left_of(t).dot(s.middle() - wall.a));
    if (std::abs(t.dot(s.direction())) > std::cos(0.1) && aside < 0.04 && common > 0.1 * length)
      found.push_back(s);
  }
  return found;
}

struct Sums {
  int whole = 0, once = 0, ends = 0, within_2_cm = 0, inside = 0, segments = 0;
  double worst = 0, squares = 0, seen = 0, mapped = 0, length = 0, right = 0;
};

void add_end(Sums& sums, const Vec2& error, const Eigen::Matrix2d& covariance) {
  ++sums.ends;
  sums.within_2_cm += error.norm() <= 0.02;
  sums.inside += error.dot(covariance.inverse() * error) <= 5.991;
  sums.worst = std::max(sums.worst, error.norm());
  sums.squares += error.squaredNorm();
}

/// A pillar may stand in a corner.
bool shows(const sim::World& world, const Vec2& corner) {
  const auto& discs = world.scene().discs;
  return std::none_of(discs.begin(), discs.end(), [&](const sim::Disc& d) {
    return (d.centre - corner).norm() < d.radius + 0.02;
  });
}

void compare(Sums& sums, const sim::World& world, const Drive& drive,
             const std::vector<map::Segment>& walls, bool list) {
  const auto& scene = world.scene().segments;
  sums.segments += static_cast<int>(walls.size());
  for (std::size_t k = 0; k < scene.size(); ++k) {
    const auto& hit = drive.hit[k];
    const Vec2 t = (scene[k].b - scene[k].a).normalized();
    for (std::size_t i = 0; i < hit.size(); ++i) {
      if (hit[i] < kSeen) continue;
      const Vec2 p = scene[k].a + (static_cast<double>(i) + 0.5) * kStep * t;
      sums.seen += kStep;
      sums.mapped += kStep * std::any_of(walls.begin(), walls.end(), [&](const map::Segment& s) {
                       return distance_to(s, p) < 0.02;
                     });
    }
    const double share =
        static_cast<double>(std::count_if(hit.begin(), hit.end(), [](int n) { return n > 0; })) /
        std::max(1.0, static_cast<double>(hit.size()));
    if ((scene[k].b - scene[k].a).norm() < 1 || share < 0.98) continue;
    const auto found = of_wall(walls, scene[k]);
    ++sums.whole;
    sums.once += found.size() == 1;
    if (found.size() != 1) continue;
    const map::Segment& s = found[0];
    const bool same_way = s.direction().dot(t) > 0;
    const Vec2 a = s.a - (same_way ? scene[k].a : scene[k].b),
               b = s.b - (same_way ? scene[k].b : scene[k].a);
    const bool a_shows = (same_way ? hit.front() : hit.back()) >= kSeen &&
                         shows(world, same_way ? scene[k].a : scene[k].b);
    const bool b_shows = (same_way ? hit.back() : hit.front()) >= kSeen &&
                         shows(world, same_way ? scene[k].b : scene[k].a);
    if (a_shows) add_end(sums, a, covariance_of_a(s));
    if (b_shows) add_end(sums, b, covariance_of_b(s));
    if (list)
      for (const auto& [e, c, shown] : {std::tuple(a, covariance_of_a(s), a_shows),
                                        std::tuple(b, covariance_of_b(s), b_shows)}) {
        if (!shown) continue;
        fmt::print(
            "{:7.4f} m along ({:.4f} stated), {:7.4f} across ({:.4f}); {:.2f} m, {} returns "
            "({:.2f} {:.2f})\n",
            s.direction().dot(e), std::sqrt(s.direction().dot(c * s.direction())),
            s.normal().dot(e), std::sqrt(s.normal().dot(c * s.normal())), s.length(), s.points,
            s.a.x(), s.a.y());
      }
  }
  for (const map::Segment& s : walls)
    for (double u = kStep / 2; u < s.length(); u += kStep) {
      sums.length += kStep;
      sums.right += kStep * (world.clearance(s.a + u * s.direction()) < 0.02);
    }
}

void measure(const Setting& setting) {
  Sums sums;
  const sim::Path plain = sim::plan_tour(sim::World(sim::building()));
  for (int seed = setting.first; seed < setting.first + setting.seeds; ++seed) {
    const Pose2 T{0.37 * seed, -0.23 * seed, 0.31 * seed};
    const sim::World world(turned(sim::building(), T));
    sim::Path path = plain;
    for (Vec2& p : path.points) p = T * p;
    const Drive drive = ::drive(world, path, setting, seed);
    compare(sums, world, drive, map::build_segments(drive.site, setting.options).walls(),
            setting.list);
  }
  const double ends = std::max(1, sums.ends);
  fmt::print("segments            {:.1f} a drive, {} drives\n",
             static_cast<double>(sums.segments) / setting.seeds, setting.seeds);
  fmt::print("walls seen whole    {}, of them one segment {}\n", sums.whole, sums.once);
  fmt::print("ends within 2 cm    {:.1f} % of {}, rms {:.1f} mm, worst {:.1f} mm\n",
             100 * sums.within_2_cm / ends, sums.ends, 1e3 * std::sqrt(sums.squares / ends),
             1e3 * sums.worst);
  fmt::print("95 % ellipses hold  {:.1f} % of the corners\n", 100 * sums.inside / ends);
  fmt::print("precision, recall   {:.2f} %, {:.2f} %\n", 100 * sums.right / sums.length,
             100 * sums.mapped / sums.seen);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    Setting setting;
    OptionFields fields;
    describe(fields, setting.options);
    for (int i = 1; i < argc; ++i) {
      const std::string_view word = argv[i];
      const auto value = [&] { return i + 1 < argc ? std::stod(argv[++i]) : 0.0; };
      if (word == "--seeds")
        setting.seeds = static_cast<int>(value());
      else if (word == "--first")
        setting.first = static_cast<int>(value());
      else if (word == "--noise")
        setting.noise = value();
      else if (word == "--pose-sigma")
        setting.pose_sigma = value();
      else if (word == "--list")
        setting.list = true;
      else
        io::apply_option(fields, argv[i]);
    }
    measure(setting);
    return 0;
  } catch (const Error& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  }
}
