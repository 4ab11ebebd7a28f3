// SPDX-License-Identifier: Apache-2.0
// Expectation maximisation (Thrun, Burgard and Fox 1998, with local maps as Burgard, Fox, Jans,
// Matenar and Thrun 1999 have them; thesis p. 36). Hidden are the poses of pieces: local maps of a
// few metres, within which the front end is trusted. Given a map, the posterior of every piece's
// pose is found forward and backward along the run; given that, the map of highest likelihood; and
// so on, coarse to fine. Where a ring closes, its end is drawn upon its beginning, and the
// correction flows backwards along the chain (docs/MATH.md, "Expectation maximisation").
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "majak/core/event.hpp"
#include "majak/slam/hidden_poses.hpp"
#include "majak/slam/lu_milios.hpp"
#include "majak/slam/mapper.hpp"
#include "majak/slam/scan_chain.hpp"

namespace majak::slam {

struct ExpectationMaximizationOptions {
  int seed = 1;
  double piece_way = 4.0;  ///< m, driven within a piece
  int hypotheses = 400;    ///< of the pose of each piece
  double doubt = 1.0;      ///< standard deviations of the motion model are this many times as large
  double shrink = 0.25;    ///< of the hypotheses' spread, from level to level
  int levels = 4;          ///< each with new hypotheses about what was found and finer cells
  double coarsest = 0.5;   ///< m, cells of the first level; half as large in each further one
  double finest = 0.1;     ///< m, no smaller than this
  int rounds = 30;         ///< E- and M-steps of a level, at most
  double gain = 0.5;       ///< a round that gains less log likelihood than this ends a level
  double hits = 0.05;      ///< that a cell is thought to have had beforehand
  double misses = 0.2;     ///< the same
  double weight = 0.3;     ///< of a point: neighbours share their errors
  bool refine = true;      ///< in the end match key scans in pairs, from the poses found
  LuMiliosOptions refinement{.rounds = 3};
};

void describe(OptionFields& fields, ExpectationMaximizationOptions& options);

class ExpectationMaximization {
 public:
  ExpectationMaximization(const ScanChainOptions& chain,
                          const ExpectationMaximizationOptions& options, Threads threads);

  /// Gives no estimate: the work is done after the run.
  std::optional<Estimate> add(Event event);
  /// Throws Error for a log without odometry.
  Mapping finish();

  /// What is known so far.
  const ScanChain& chain() const { return chain_; }

 private:
  /// One level: rounds until the likelihood stands still.
  HiddenPosterior climb(const HiddenPoses& hidden, HiddenPosterior posterior, double cell,
                        Mapping& mapping) const;
  void cut_pieces();
  void see_pieces(double cell);
  HiddenPoses drawn_from_motion() const;
  HiddenPoses drawn_from(const HiddenPoses& hidden, const HiddenPosterior& posterior,
                         int level) const;
  void connect(HiddenPoses& hidden, double spread) const;
  std::vector<Pose2> most_likely_poses(Mapping& mapping);
  void hang_keys(const std::vector<Pose2>& poses);

  ExpectationMaximizationOptions options_;
  Threads threads_;
  ScanChain chain_;
  std::vector<std::size_t> anchors_;  // key scan whose pose is that of its piece
  std::vector<std::size_t> begins_;   // first key scan of each piece, and the end
  std::vector<Piece> pieces_;         // what was seen, by squares as large as cells now are
  std::vector<Mat3> steps_;   // covariance of each piece's pose seen from the one before, own axes
  std::vector<Mat3> spread_;  // of each piece's pose by the motion model alone, own axes
};

}  // namespace majak::slam
