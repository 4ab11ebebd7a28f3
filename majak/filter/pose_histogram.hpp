// SPDX-License-Identifier: Apache-2.0
// PoseHistogram: the histogram filter over (x, y, heading). Only where there is something is there
// memory: cells lie in tiles of 8 x 8 with all headings, and tiles without mass are left out. A
// motion is separable: for each heading its own shift and blur along x and along y, then one along
// the headings, which are cyclic.
//
//   P(l | a, l') = kx(x - x'; heading') ky(y - y'; heading') kh(heading - heading')
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "majak/core/parallel.hpp"
#include "majak/core/pose2.hpp"
#include "majak/filter/histogram.hpp"

namespace majak::filter {

/// The cells there are, and which of them the robot can be in.
struct PoseLattice {
  static constexpr int kSide = 8, kSlice = kSide * kSide;  // of a tile, in one heading

  double x0 = 0, y0 = 0;            ///< m, the corner with the least x and y
  double cell = 0.1;                ///< m
  int tiles_x = 0, tiles_y = 0;     ///< of 8 x 8 cells
  int headings = 180;               ///< cells of a whole turn; the middle of the first is 0
  std::vector<std::uint64_t> open;  ///< one a tile, row by row; bit 8 row + column

  /// With all cells closed.
  PoseLattice(double x0, double y0, double cell, int width, int height, int headings);

  double turn() const { return 2 * kPi / headings; }  ///< rad, of one cell
  double heading(int h) const { return wrap_angle(h * turn()); }
  std::size_t tiles() const { return open.size(); }
  std::size_t tile(int ix, int iy) const {
    return static_cast<std::size_t>(iy / kSide) * static_cast<std::size_t>(tiles_x) +
           static_cast<std::size_t>(ix / kSide);
  }
  bool inside(int ix, int iy) const {
    return ix >= 0 && iy >= 0 && ix < tiles_x * kSide && iy < tiles_y * kSide;
  }
  void set_open(int ix, int iy);
  std::size_t open_cells() const;  ///< in one heading
  /// The middle of a tile's cell (0, 0).
  Vec2 corner(std::size_t tile) const;
};

struct PoseMotion {
  Pose2 T_from_to;
  Mat3 covariance = Mat3::Zero();  ///< of log(T_from_to^-1 * truth); m, rad

  /// First this, then another.
  PoseMotion then(const PoseMotion& next) const;
};

class PoseHistogram {
 public:
  /// Nothing anywhere.
  explicit PoseHistogram(std::shared_ptr<const PoseLattice> lattice);

  const PoseLattice& lattice() const { return *lattice_; }
  /// Bel-: of each heading's translation the axes' correlation is left out. What would end in a
  /// closed cell is lost, so that the mass shrinks; scale() it afterwards.
  void move(const PoseMotion& motion, Threads threads = {});
  void add_uniform(double mass);
  void add(const PoseHistogram& other, double factor);
  void scale(double factor);

  double mass() const;
  double entropy() const;  ///< nat, of the mass scaled to 1
  float at(int ix, int iy, int heading) const;

  /// Tiles that hold something, in order; and what is in them: 64 cells a heading, row by row.
  std::vector<std::size_t> held() const;
  std::vector<float>& tile(std::size_t i) { return tiles_[i]; }
  const std::vector<float>& tile(std::size_t i) const { return tiles_[i]; }
  std::size_t bytes() const;

 private:
  struct Shifts;
  void gather(std::size_t heading, int x, int y, int width, int height, float* patch) const;
  std::vector<float> moved_into(std::size_t tile, const Shifts& shifts) const;

  std::shared_ptr<const PoseLattice> lattice_;
  std::vector<std::vector<float>> tiles_;  // empty: nothing there
};

}  // namespace majak::filter
