// SPDX-License-Identifier: Apache-2.0
// A room that one can see in the test, and scans of it:
//
//   const AsciiRoom room({
//       "########",
//       "#......#",
//       "#.a.o..#",
//       "########",
//   });
//   const Scan scan = room.scan(room.pose('a', radians(30)));
//
// '#' is a solid square, 'o' a pole, '.' and ' ' are floor; any other character is floor with a
// name. Frame "map": the last line lies on y = 0, x to the right, metres.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "majak/core/event.hpp"
#include "majak/core/random.hpp"

namespace majak::fixture {

/// How a room is looked at: the field of view is centred on the laser's x axis.
struct Laser {
  int beams = 181;
  double field_of_view = kPi;  ///< rad from the first beam to the last
  double max_range = 30;       ///< m
  double noise = 0;            ///< m, sigma of a range
  int seed = 1;
  Pose2 T_robot_laser;
};

inline Laser all_around(int beams = 360) {
  return {beams, 2 * kPi * (beams - 1) / beams, 30, 0, 1, {}};
}

class AsciiRoom {
 public:
  static constexpr double kPole = 0.05;  ///< m, radius of an 'o'

  explicit AsciiRoom(std::vector<std::string> plan, double cell = 0.5)
      : plan_(std::move(plan)), cell_(cell) {
    for (std::size_t row = 0; row < plan_.size(); ++row)
      for (std::size_t column = 0; column < plan_[row].size(); ++column) {
        if (plan_[row][column] == '#') walls_.push_back(centre(row, column));
        if (plan_[row][column] == 'o') poles_.push_back(centre(row, column));
      }
  }

  /// Middle of the cell with this name.
  Vec2 place(char name) const {
    for (std::size_t row = 0; row < plan_.size(); ++row)
      if (const auto column = plan_[row].find(name); column != std::string::npos)
        return centre(row, column);
    throw std::out_of_range(std::string("no place ") + name);
  }
  Pose2 pose(char name, double theta = 0) const {
    return {place(name).x(), place(name).y(), theta};
  }

  /// Way to the nearest surface; infinite if there is none.
  double cast(const Vec2& from, double angle) const {
    const Vec2 ray(std::cos(angle), std::sin(angle));
    double nearest = std::numeric_limits<double>::infinity();
    for (const Vec2& wall : walls_) nearest = std::min(nearest, meet_square(from - wall, ray));
    for (const Vec2& pole : poles_) nearest = std::min(nearest, meet_disc(from - pole, ray));
    return nearest;
  }

  Scan scan(const Pose2& T_map_robot, const Laser& laser = {}) const {
    Scan scan;
    scan.start_angle = -laser.field_of_view / 2;
    scan.angle_step = laser.field_of_view / (laser.beams - 1);
    scan.max_range = static_cast<float>(laser.max_range);
    scan.T_robot_laser = laser.T_robot_laser;
    const Pose2 T_map_laser = T_map_robot * laser.T_robot_laser;
    RandomStream noise(static_cast<std::uint64_t>(laser.seed));
    for (int i = 0; i < laser.beams; ++i) {
      const double range = cast(T_map_laser.translation(),
                                T_map_laser.theta + scan.angle(static_cast<std::size_t>(i)));
      const double error = laser.noise * noise.normal();
      scan.ranges.push_back(range < laser.max_range ? static_cast<float>(range + error)
                                                    : kNoReturn);
    }
    return scan;
  }

 private:
  Vec2 centre(std::size_t row, std::size_t column) const {
    return cell_ * Vec2(static_cast<double>(column) + 0.5,
                        static_cast<double>(plan_.size() - 1 - row) + 0.5);
  }
  // Both are about the thing's centre.
  double meet_square(const Vec2& from, const Vec2& ray) const {
    double enter = 0, leave = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 2; ++axis) {
      const double a = (-cell_ / 2 - from[axis]) / ray[axis],
                   b = (cell_ / 2 - from[axis]) / ray[axis];
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    return enter < leave ? enter : std::numeric_limits<double>::infinity();
  }
  static double meet_disc(const Vec2& from, const Vec2& ray) {
    const double along = -from.dot(ray), aside2 = from.squaredNorm() - along * along;
    if (along < 0 || aside2 > kPole * kPole) return std::numeric_limits<double>::infinity();
    return along - std::sqrt(kPole * kPole - aside2);
  }

  std::vector<std::string> plan_;
  double cell_;
  std::vector<Vec2> walls_, poles_;
};

}  // namespace majak::fixture
