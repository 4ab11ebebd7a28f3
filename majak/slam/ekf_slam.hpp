// SPDX-License-Identifier: Apache-2.0
// EKF-SLAM: where the robot is and where the landmarks are, in one Kalman filter (thesis p. 34;
// Smith, Self and Cheeseman 1990; Thrun, Burgard and Fox, table 10.1). Satellites, where there are
// any, are an absolute measurement like any other.
//
//   slam::EkfSlam slam;
//   while (auto event = source->next()) slam.add(*event);
//   const slam::LandmarkMap map = slam.finish();
#pragma once

#include <optional>
#include <vector>

#include "majak/beacon/trunks.hpp"
#include "majak/core/estimate.hpp"
#include "majak/core/event.hpp"
#include "majak/core/options.hpp"
#include "majak/filter/landmark_filter.hpp"
#include "majak/localize/gps_pieces.hpp"
#include "majak/localize/localizer.hpp"
#include "majak/slam/corners.hpp"
#include "majak/slam/joint_compatibility.hpp"
#include "majak/slam/motion_input.hpp"

namespace majak::slam {

struct EkfSlamOptions {
  motion::WheelRandom wheels;
  double wheelbase = 2.83;  ///< m, of a car
  double idle_noise = 1;    ///< m, rad per sqrt(s), until the wheels tell something
  // What the wheels count wrongly, one sigma.
  double scale_sigma = 0.03;
  double turn_scale_sigma = 0.05;
  double turn_offset_sigma = 0.004;    ///< rad/m
  double steering_curve_sigma = 0.3;   ///< 1/rad^2
  double steering_square_sigma = 0.1;  ///< 1/rad

  beacon::TrunkOptions trunks;
  bool see_corners = false;  ///< of walls, too
  CornerOptions corners;
  double mirror_turn = 1.0 / 75;  ///< s, see match::beam_time; 0: the robot stands still in a scan
  double point_sigma = 0.03;      ///< m, by which a landmark is not the same from scan to scan
  double alike_sigma = 0.1;       ///< m, by which all its sightings err alike ...
  double alike_way = 1;           ///< m, ... that are made on so much way
  double diameter_sigma = 0.06;   ///< m, by which its diameter is not
  JointCompatibilityOptions association;
  double apart = 0.9999;     ///< probability with which a sighting that becomes a new landmark is
                             ///< none of the others
  double least_apart = 1.0;  ///< m, nor nearer than this to any of them
  double recent = 4;         ///< s, after which a landmark that is seen again is doubted at first
  int witnesses = 3;    ///< such landmarks in one scan, or scans in a row with one, that are enough
  int confirmed = 3;    ///< sightings before a landmark is more than a guess
  double stands = 0.8;  ///< s, for which it stands in one place until then
  double guess_gate = 0.5;  ///< m, between these sightings
  int gone = 10;            ///< scans in a row that look through it, before it is given up
  double near = 75;         ///< m, what is kept up to date
  double look_around = 25;  ///< m driven between two looks around

  double crab_sigma = 0.02;   ///< rad, between the laser's and the axle's direction
  double crab_wander = 1e-3;  ///< rad per sqrt(m), how that changes with the ground
  double lag_sigma = 0.05;    ///< s, of the wheels behind the laser

  double blind = 10;  ///< m driven without a landmark before the pose is called degraded
  double sure = 1;    ///< m, one sigma of a position that is not
  int misfits = 5;    ///< scans without those landmarks that there should be, before it is lost

  double mistrusted_noise = 0.5;  ///< m, rad per sqrt(s), of wheels that the landmarks contradict
  double mistrust = 2;            ///< s, for which they are taken to err
  double stuck = 1;               ///< m with the same steering before it may be stuck

  bool use_gps = true;
  double gps_sigma = 0.35;       ///< m, of what errs alike in a piece
  double gps_fast_sigma = 0.08;  ///< m, from fix to fix
  double gps_memory = 200;       ///< s, of the former
  double antenna_sigma = 3;      ///< m
  double gps_gate = 16;          ///< NIS beyond which a fix is believed less
  double gps_refused = 100;      ///< NIS beyond which it is not believed at all ...
  double gps_patience = 120;     ///< s, ... unless all are for so long
  double find_heading = 20;      ///< m between fixes before the heading is taken from them
  localize::GpsPiecesOptions pieces;
};
void describe(OptionFields& fields, EkfSlamOptions& options);

/// A landmark of the finished map.
struct MappedLandmark {
  Vec2 p_map = Vec2::Zero();
  /// m^2, map axes; of one that is gone as it was known then.
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  double diameter = 0;  ///< m; 0 of a corner
  int sightings = 0;
  bool gone = false;  ///< was looked through later
};

/// That a landmark was seen, as the graph wants it.
struct LandmarkObservation {
  std::size_t scan = 0;                             ///< index into the estimates
  int landmark = 0;                                 ///< index into the landmarks
  Vec2 q_robot = Vec2::Zero();                      ///< m, at the scan's stamp
  Eigen::Matrix2d noise = Eigen::Matrix2d::Zero();  ///< of it
};

/// A fix, as the graph wants it.
struct FixObservation {
  std::size_t scan = 0;   ///< newest estimate at that time
  Pose2 T_scan_robot;     ///< motion since, by the wheels
  Vec2 z = Vec2::Zero();  ///< m, east and north
  std::size_t piece = 0;  ///< of fixes that err alike
};

struct LandmarkMap {
  localize::Localization localization;  ///< estimates: one a scan, as known then
  std::vector<MappedLandmark> landmarks;
  std::vector<LandmarkObservation> observations;
  std::vector<MotionInput::Motion> steps;  ///< [k]: by the wheels from scan k - 1 to scan k
  std::vector<FixObservation> fixes;       ///< of sound pieces
  filter::LandmarkFilter::Extra numbers;   ///< what the wheels count wrongly, the antenna; at last
};

class EkfSlam {
 public:
  /// `start`: T_map_robot at the first event; where fixes come, the map is turned to them.
  explicit EkfSlam(const EkfSlamOptions& options = {}, const Pose2& start = {});

  /// The next event, in the log's order; an estimate for each scan.
  std::optional<Estimate> add(const Event& event);
  LandmarkMap finish();

  const filter::LandmarkFilter& filter() const { return filter_; }

 private:
  // Among the extra numbers, after those of MotionInput: the antenna, and how the satellites err
  // now.
  static constexpr int kAntenna = MotionInput::kNumbers, kSlow = kAntenna + 2;
  static constexpr double kCorner = -2;           ///< m, instead of a diameter
  static constexpr int kNew = -1, kDoubted = -2;  ///< choices that are no pairing

  /// A sighting; `noise` is that of its bark.
  struct Seen {
    Vec2 q_robot;      ///< its centre, if its diameter is as it looks
    Vec2 by_diameter;  ///< derivative of the former
    Eigen::Matrix2d noise;
    double diameter, diameter_variance;  ///< as it looks
  };
  struct Centre {
    Vec2 q_robot;
    Eigen::Matrix2d noise;
  };
  struct Known {
    void measure(const Seen& seen);  ///< its diameter

    Time last = 0, returned = 0;
    int returns = 0;
    int sightings = 0, missed = 0;
    double diameter = 0, diameter_variance = 0;  ///< m, m^2
    // Of one that is gone, as it was known then.
    bool gone = false;
    Vec2 p_map = Vec2::Zero();
    Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  };
  struct Sighting {
    std::size_t scan;
    int landmark;
    Seen seen;
  };

  /// Seen, but not often enough yet.
  struct Guess {
    Vec2 p_map;
    Time first, last;
    int sightings;
  };

  /// Which landmarks a scan's sightings may be of, and which of them they are taken for.
  struct Matching {
    std::vector<std::vector<Pairing>> allowed;
    std::vector<int> choice;
    int followed = 0;  ///< of those seen in the scan before

    const Pairing* pairing(std::size_t sighting) const;
  };

  /// The antenna where it was by the wheels and by the satellites.
  struct EarlyFix {
    Vec2 driven, fixed;
    std::size_t piece;
  };

  void predict(Time time);
  Estimate see(const Scan& scan);
  void correct(const std::vector<Seen>& seen, const Matching& matching);
  double alike() const;
  void initialise(const std::vector<Seen>& seen, const std::vector<int>& choice);
  bool confirmed(const Seen& seen);
  void drop_guesses();
  void forget(const Scan& scan);
  bool looked_through(const Scan& scan, int id) const;
  Eigen::Matrix2d covariance_of(int id) const;
  Estimate estimate(Time time);
  Estimate as_known_now(Estimate e) const;
  void doubt_if_vague(Estimate& e) const;

  // ekf_slam_matching.cpp
  std::vector<Seen> look(const Scan& scan) const;
  void look_for_corners(const Scan& scan, std::vector<Seen>& seen) const;
  static Centre centre(const Seen& seen, double diameter, double variance);
  Centre centre(const Seen& seen, int id) const;
  void remember(const Seen& seen, int id);
  Pairing pair(const Seen& seen, int id, const Eigen::MatrixXd& covariance) const;
  std::vector<Pairing> candidates(const Seen& seen, const Eigen::MatrixXd& covariance) const;
  Matching match(const std::vector<Seen>& seen, const Eigen::MatrixXd& covariance) const;
  bool followed(int id) const;
  bool mistrusted(Time time);
  Mat3 told_nothing(double seconds) const;
  void match_without_wheels(const std::vector<Seen>& seen, Matching& matching);
  void doubt(Time time, Matching& matching);

  // ekf_slam_satellites.cpp
  void see(const GpsFix& fix);
  void err_anew(std::size_t piece);
  bool refused(double nis, Time time);
  void keep(const GpsFix& fix, std::size_t piece);
  void find_heading(const GpsFix& fix, std::size_t piece);
  void drop_early_fixes();

  EkfSlamOptions options_;
  filter::LandmarkFilter filter_;
  MotionInput motion_;
  localize::GpsPieces pieces_;
  std::vector<Known> known_;  ///< by the filter's number
  std::vector<Guess> guesses_;
  std::vector<Sighting> sightings_;
  std::vector<MotionInput::Motion> steps_;
  std::vector<FixObservation> fixes_;
  MotionInput::Motion since_scan_;
  std::vector<Estimate> estimates_;
  std::vector<localize::Innovation> innovations_;
  Report report_;
  Vec2 looked_from_ = Vec2::Zero();
  std::size_t piece_ = static_cast<std::size_t>(-1);
  Time clock_ = 0;
  Time mistrusted_until_ = 0;
  bool stuck_ = false;
  double held_at_ = 0;  ///< m, way at which landmarks held the pose last
  int misfits_ = 0;
  bool begun_ = false, oriented_ = false;
  std::vector<EarlyFix> before_;                 ///< until the heading is known
  std::int64_t fixes_seen_ = 0, frameless_ = 0;  ///< fixes; scans before the heading was known
  std::optional<Time> contradicted_since_;
};

/// As the registry wants it: the path, without the map.
localize::Localizer ekf_slam(const EkfSlamOptions& options, const Pose2& start);

}  // namespace majak::slam
