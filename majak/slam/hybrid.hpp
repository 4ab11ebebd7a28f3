// SPDX-License-Identifier: Apache-2.0
// Hybrid of incremental maximum likelihood and a particle set (Thrun, Burgard and Fox 2000; Gutmann
// and Konolige 1999; thesis p. 36). One map, grown scan by scan, and beside it samples of where the
// robot may really be by now. Where they meet ground that was mapped long ago, the newest scans
// weigh them; when they agree on one place, the robot is put there and the error is shared out
// backwards along the loop. What later scans speak against is taken back (docs/MATH.md, "The
// hybrid").
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "majak/core/event.hpp"
#include "majak/map/surfel_map.hpp"
#include "majak/match/point_to_line.hpp"
#include "majak/slam/drift.hpp"
#include "majak/slam/mapper.hpp"
#include "majak/slam/scan_chain.hpp"

namespace majak::slam {

struct HybridOptions {
  int seed = 1;
  int particles = 400;
  double old_way = 12;          ///< m driven since: such ground is old, and on the map
  int local_map_keys = 14;      ///< of the newest key scans, held together against the old ground
  double look_every = 0.75;     ///< m, between two looks whether the ground is old
  double narrow = 0.12;         ///< m, a spread below which the robot is tracked on old ground
  double old_share = 0.6;       ///< share of returns on the map that makes the ground old
  double through_share = 0.35;  ///< at most: of beams that pass through a wall of the map
  double agreed = 0.15;         ///< m, particles agree when they are matched to within this
  int witnesses = 2;            ///< looks in a row that must tell the same correction
  double probation = 30;        ///< m, for which a correction can be taken back
  double fall = 0.25;           ///< of the fit, by which it must fall for that
  double quiet = 20;            ///< m, for which a place is not tried again then
  bool keep_loops = true;       ///< a loop within a loop stays as it is and moves as a whole
  int latency_keys = 0;         ///< key scans that may be moved or drawn anew per scan; 0: all
  double way_sigma = 0.02;      ///< m, of the front end's step from key scan to key scan
  double turn_sigma = 0.01;     ///< rad
  DriftOptions drift;
  match::AlignOptions align;
  map::SurfelMapOptions map;
  /// For tests and benchmarks: a closure that is made, right or wrong: key scan `at` is put where
  /// key scan `onto` is.
  struct Forced {
    std::size_t at = 0, onto = 0;
  };
  std::optional<Forced> forced;
};

void describe(OptionFields& fields, HybridOptions& options);

class Hybrid {
 public:
  Hybrid(const ScanChainOptions& chain, const HybridOptions& options, Threads threads);

  std::optional<Estimate> add(Event event);
  Mapping finish();

  /// Where the robot may be at the newest key scan, T_map_robot.
  const std::vector<Pose2>& particles() const { return particles_; }
  /// Standard deviation of their places in the direction in which they are spread most, m.
  double widest() const;
  /// Closures so far.
  const std::vector<LoopCorrection>& corrections() const { return corrections_; }
  /// Key scans of the last add() that were moved or drawn anew.
  std::size_t touched() const { return touched_; }

  /// What is known so far.
  const ScanChain& chain() const { return chain_; }

 private:
  /// How returns lie on the old ground.
  struct Fit {
    double on = 0;       ///< share on a surface
    double through = 0;  ///< share whose beam passed through one
    double agreement() const { return on + through > 0 ? on / (on + through) : 1; }
  };
  /// A place that the particles agree on.
  struct Place {
    Pose2 T_map_robot;
    Mat3 information = Mat3::Zero();  ///< own axes
  };
  /// A correction at work: poses first, from the newest back, then the map from its beginning.
  struct Move {
    std::size_t first = 0, at = 0;  ///< key scans that are moved: [first, at]
    std::vector<Pose2> targets;
    std::size_t unmoved = 0;  ///< of the targets
    bool refine = true;       ///< on old ground
    std::size_t drawn = 0, next = 0;
    map::SurfelMap map;
  };
  /// What is needed to take a correction back.
  struct Snapshot {
    std::size_t first = 0, at = 0;
    std::vector<Pose2> poses;  ///< of key scans [first, at]
    std::vector<Pose2> particles;
    std::size_t ground = 0;  ///< key scan that the doubt was on
    double before = 1;       ///< agreement on the way to the closure
    double since = 1;        ///< agreement since, running mean
  };

  std::optional<Estimate> take_scans();
  void take_key();
  void begin();
  void spread(std::size_t key);
  Mat3 ground_doubt() const;
  void stand_on(std::size_t visit);
  std::vector<Pose2> tries() const;
  void draw_old();
  bool hold(std::size_t key, const map::SurfelMap& map, double reach);
  void narrow(const Pose2& T_map_robot, const Mat3& covariance);
  void begin_anew(const Place& place);
  Fit fit_of(const match::ScanPoints& points, const Pose2& T_map_robot) const;
  Fit newest_fit(const Pose2& T_map_robot) const;
  match::ScanPoints local_map() const;
  void look();
  std::vector<match::Match> matches_of_particles(const match::ScanPoints& points) const;
  std::optional<Place> place_agreed_on() const;
  bool told_before(const Pose2& T_map_robot);
  bool is_quiet(const Pose2& T_map_robot) const;
  std::size_t visit_at(const Pose2& T_map_robot) const;
  std::size_t error_begin(std::size_t visit, std::vector<Mat3>& steps) const;
  void close(std::size_t visit, const Place& place);
  void judge();
  void take_back();
  void start_move(std::size_t first, std::vector<Pose2> targets, bool refine);
  void work(std::size_t budget);
  void rework(std::size_t key);
  double driven() const { return way_.back(); }

  HybridOptions options_;
  Threads threads_;
  ScanChain chain_;
  map::SurfelMap map_;                ///< of the old ground
  std::size_t drawn_ = 0;             ///< key scans on it
  std::vector<double> way_;           ///< m driven up to each key scan
  std::vector<Mat3> steps_;           ///< covariance of the step to each, own axes
  std::vector<char> held_;            ///< each: by old ground
  std::vector<std::size_t> anchors_;  ///< each: older key scan it is as good as fixed to, or itself
  std::vector<Pose2> particles_;
  /// Of the ground on which the particles were last narrowed: how far that may be off itself
  /// against the map's beginning. Own axes of key scan `on`.
  struct Doubt {
    Mat3 covariance = Mat3::Zero();
    std::size_t on = 0;
  };
  Doubt doubt_;
  std::vector<Mat3> spreads_;    ///< of each key scan against the map's beginning, own axes
  std::vector<double> scales_;   ///< of each particle: error of the way that only the wheels count
  double looked_ = 0;            ///< m driven at the last look
  double agreement_ = 1;         ///< running mean over the looks
  std::optional<Pose2> rumour_;  ///< T_map_map, the correction that the last look told
  int told_ = 0;                 ///< looks in a row that told it
  std::optional<Move> move_;
  std::optional<Snapshot> snapshot_;
  std::optional<std::pair<Vec2, double>> quiet_;  ///< a place not to be tried until so many m
  std::vector<LoopCorrection> corrections_;
  std::size_t touched_ = 0;
  std::size_t most_bytes_ = 0;
};

}  // namespace majak::slam
