// SPDX-License-Identifier: Apache-2.0
// Monte Carlo localization (thesis p. 22; Thrun, Burgard, Fox 2005, 8.3): the belief is a cloud of
// poses, each with a weight. They move as the wheels say, each with an error of its own; they weigh
// what the laser says where they are; the light ones die, the heavy ones multiply. Begins anywhere
// on the map, and recovers when it is carried away: places that fit the scan join the cloud when
// the cloud itself fits no longer (docs/MATH.md "Monte Carlo localization"). The cloud tells where
// the robot is, each scan then how exactly: a tracker runs within the heaviest cluster.
//
//   MonteCarlo filter(place, {});
//   while (const auto scan = feed.next()) estimate = filter.add(*scan);
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "majak/core/estimate.hpp"
#include "majak/core/normal_table.hpp"
#include "majak/core/options.hpp"
#include "majak/core/parallel.hpp"
#include "majak/localize/global_localization.hpp"
#include "majak/localize/localizer.hpp"
#include "majak/localize/place.hpp"
#include "majak/localize/plausibility.hpp"
#include "majak/localize/pose_bins.hpp"
#include "majak/localize/scan_feed.hpp"
#include "majak/localize/tracking.hpp"
#include "majak/match/beam_model.hpp"
#include "majak/match/likelihood_field.hpp"

namespace majak::localize {

struct MonteCarloOptions {
  int seed = 1;
  int particles = 5000;     ///< at most
  int least = 500;          ///< at least
  int beams = 180;          ///< of a scan that are looked at
  bool beam_model = false;  ///< weigh by `model`, not by the place's likelihood field
  match::BeamModel model{};
  double effective = 25;    ///< as how many independent beams they count; neighbours err together
  double step = 0.2;        ///< m driven between two updates
  double step_turn = 0.2;   ///< rad turned, likewise
  double start_sigma = 0;   ///< m, how well the start is known; 0: not at all
  double start_turn = 0.2;  ///< rad, the same
  double spread = 0.01;     ///< m, added to each motion so that copies part
  double spread_turn = 0.005;  ///< rad, the same
  double kld_error = 0.05;     ///< nat, between the cloud and the belief it stands for
  double kld_quantile = 2.33;  ///< 1, standard normal, of how surely
  double alpha_slow = 0.02;    ///< of the mean misfit of many updates
  double alpha_fast = 0.4;     ///< of that of the last few
  double doubt = 0.6;          ///< nat a beam by which the fast mean is suspiciously worse
  double lost = 1.2;           ///< nat a beam from which on the robot is lost
  bool proposals = true;       ///< places that fit the scan are among the new particles
  double carried = 8;          ///< nat, against having been carried away in one update
  double slip = 0.5;           ///< m, how far the wheels may have slipped where the fit is in doubt
  double slip_turn = 0.2;      ///< rad, the same
  double sure = 0.8;           ///< weight of one cluster from which on the place is found
  double off_floor = 1;        ///< nat an update, against standing where no floor is known
};
void describe(OptionFields& fields, MonteCarloOptions& options);

class MonteCarlo {
 public:
  /// start: T_map_robot at the first scan, looked at if options.start_sigma > 0. The result is the
  /// same for any number of threads.
  MonteCarlo(PlacePtr place, const MonteCarloOptions& options, const Pose2& start = {},
             Threads threads = {});

  /// The pose is that of the tracker within the heaviest cluster, the covariance the cluster's.
  Estimate add(const FedScan& scan);

  /// Between two scans: what another sense says, P(s | l) of each pose (the floor's colour, see
  /// match/cell_attributes.hpp). Returns the evidence; where that is 0 nothing is changed.
  double see(const std::function<double(const Pose2&)>& likelihood);

  // State, for figures and tests.
  const match::PoseArrays& poses() const { return poses_; }
  const std::vector<double>& weights() const {
    return weights_;
  }  ///< of these, sum 1; equal after resampling
  /// Particles that stand together; the heaviest first, until a twentieth is left.
  const std::vector<Hypothesis>& clusters() const { return clusters_; }
  std::size_t bytes() const;  ///< of the belief: four floats a pose, and a weight
  int updates() const { return updates_; }
  bool updated() const { return updated_; }  ///< by the last scan, or moved on only
  /// nat a beam below a perfect fit, where the particles are believed to be: at the last update, in
  /// the mean of the last few, and of many.
  double misfit() const { return misfit_; }
  double misfit_fast() const { return fast_; }
  double misfit_slow() const { return slow_; }

 private:
  bool due(const FedScan& scan);
  Estimate update(const FedScan& scan);
  void begin(const Scan& scan);
  void move();
  void weigh(const Scan& scan);
  void cost(std::size_t first, std::size_t last);
  void watch();
  void find_clusters();
  Hypothesis take_cluster(std::size_t seed);
  bool found() const { return clusters_.front().probability >= options_.sure; }
  bool fits(double worse) const { return slow_mass_ == 0 || fast_ <= slow_ + worse; }
  Estimate estimate() const;
  Estimate refined(const FedScan& scan, Estimate cloud);
  void track_from(const FedScan& scan, const Estimate& cloud);
  std::size_t fresh_wanted() const;
  void resample(std::size_t fresh);
  std::size_t wanted_size();
  void draw_fresh(const Scan& scan, std::size_t first);
  Pose2 draw_anywhere(RandomStream& random) const;
  Pose2 draw_near(const Pose2& mean, const Mat3& root, RandomStream& random) const;
  void resize(std::size_t n);
  template <class Body>
  void for_blocks(const Body& body) const;

  PlacePtr place_;
  MonteCarloOptions options_;
  Pose2 start_;
  Threads threads_;
  GlobalLocalization global_;
  NormalTable normal_;
  std::vector<std::uint32_t> floor_;  // cells where a robot may be

  match::PoseArrays poses_, drawn_;
  std::vector<double> log_weights_, weights_, left_;
  std::vector<std::uint32_t> costs_, chosen_;
  PoseBins bins_;
  match::Beams beams_;
  std::size_t counted_ = 0;  // beams that say something
  std::vector<Hypothesis> clusters_;
  std::optional<Tracker> tracker_;  // within the heaviest
  Estimate tracked_;

  Pose2 T_update_robot_;  // moved since the last update, and how surely
  Mat3 moved_covariance_ = Mat3::Zero();
  Pose2 moved_;  // the motion of the last update
  Time time_ = 0;
  int updates_ = 0;
  bool updated_ = false;
  bool leapt_ = false;  // the last update found the robot elsewhere
  double misfit_ = 0, slow_ = 0, fast_ = 0, slow_mass_ = 0, fast_mass_ = 0;
};

/// As the registry wants it.
Localizer monte_carlo(const PlacePtr& place, const MonteCarloOptions& options, const Pose2& start,
                      const PlausibilityOptions& plausibility = {}, Threads threads = {});

}  // namespace majak::localize
