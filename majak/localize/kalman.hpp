// SPDX-License-Identifier: Apache-2.0
// Kalman: the extended Kalman filter over wheels, satellites and beacons, and at the end of a log
// its fixed-interval smoother, repeated until the equations are linear where the result is
// (Bell and Cathey 1993). Relative information (wheels) predicts, absolute (fixes, beacons)
// corrects; what the wheels count wrongly, where the antenna sits and how the satellites err now is
// estimated beside the pose (docs/MATH.md "Kalman filter").
//
//   localize::Kalman kalman({});
//   while (auto event = source->next()) kalman.add(*event);
//   const Localization result = kalman.finish();
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <vector>

#include "majak/beacon/beacon_map.hpp"
#include "majak/beacon/reflectors.hpp"
#include "majak/core/event.hpp"
#include "majak/core/options.hpp"
#include "majak/filter/pose_filter.hpp"
#include "majak/localize/gps_pieces.hpp"
#include "majak/localize/localizer.hpp"
#include "majak/motion/wheel_step.hpp"

namespace majak::localize {

struct KalmanOptions {
  // Random errors of the wheels.
  double way_noise = 0.02;    ///< m per sqrt(m), along
  double side_noise = 0.02;   ///< m per sqrt(m), across
  double turn_noise = 0.007;  ///< rad per sqrt(m)
  double spin_noise = 0.05;   ///< rad per sqrt(rad)
  double idle_noise = 1;      ///< m per sqrt(s), where nothing tells of the motion
  // Systematic ones, one sigma; learnt on the way.
  double scale_sigma = 0.03;          ///< of the way
  double turn_scale_sigma = 0.05;     ///< of turns; of the steering angle
  double turn_offset_sigma = 0.02;    ///< rad per m straight ahead, of two wheels
  double steering_sigma = 0.01;       ///< rad, straight ahead of a car's steering
  double steering_curve_sigma = 0.3;  ///< 1/rad^2, of the angle's cube in what a car steers
  double wheelbase = 2.83;            ///< m, Ackermann

  // Satellites: a slow error that is drawn anew with each piece, and a fast one.
  double gps_sigma = 0.35;       ///< m, where the receiver does not say
  double gps_fast_share = 0.15;  ///< of it, from fix to fix
  double gps_memory = 200;       ///< s, of the slow part
  double antenna_sigma = 1;      ///< m, its place on the robot, ahead and to the side
  GpsPiecesOptions pieces;

  beacon::ReflectorOptions reflectors;

  double gate = 9;          ///< NIS beyond which a measurement is believed less
  double find_heading = 8;  ///< m driven between fixes before the heading is taken from them
  int rounds = 20;          ///< of smoothing, at most
};
void describe(OptionFields& fields, KalmanOptions& options);

class Kalman {
 public:
  /// `start`: T_map_robot at the first event; found by itself where there are fixes or beacons.
  explicit Kalman(const KalmanOptions& options, const Pose2& start = {},
                  const beacon::BeaconMap& beacons = {});

  /// The next event, in the log's order. An estimate for every scan, fix and sighting, or for
  /// the wheels' own records where there is no scan.
  std::optional<Estimate> add(const Event& event);
  /// What the laser says of the motion from the scan before to the one that is added next:
  /// information of log(T_from_to^-1 * truth), in the axes of the second.
  void matched(const Pose2& T_from_to, const Mat3& information) {
    match_ = {T_from_to, information};
  }
  Localization finish();

 private:
  /// Beside the pose: four numbers of the wheels (scale, turn scale, turn per way, cube of the
  /// steering), the antenna on the robot (ahead, left), the satellites' slow error (east, north).
  static constexpr int kExtra = 8;
  static constexpr int kScale = motion::WheelStep::kScale,
                       kTurnScale = motion::WheelStep::kTurnScale,
                       kTurnOffset = motion::WheelStep::kTurnOffset,
                       kCurve = motion::WheelStep::kCurve, kAntenna = 4, kSlow = kAntenna + 2;
  using State = filter::PoseState<kExtra>;
  using Belief = filter::PoseBelief<kExtra>;
  using Motion = filter::RelativeInput<kExtra>;
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  struct ScanMatch {
    Pose2 T_from_to;
    Mat3 information = Mat3::Zero();
  };

  /// A time at which something is measured or asked for.
  struct Node {
    Time time = 0;
    Motion motion;  ///< since the node before
    /// Share of what the wheels say that the scan match left to them, in the axes at the end.
    Mat3 by_wheels = Mat3::Identity();
    bool scan = false;
    std::size_t fix = kNone;
    std::vector<BeaconSighting> seen;  ///< with the numbers of the map
    bool wanted = true;                ///< gives an estimate
    bool new_piece = false;            ///< the satellites' slow error is drawn anew here
    Belief predicted, filtered, smoothed;
  };

  /// What makes a node; it may wait for the odometry to come by.
  struct Measured {
    Time time;
    std::size_t fix;
    bool wanted;
    std::vector<BeaconSighting> seen;
    std::optional<ScanMatch> match;
    bool scan = false;
  };

  std::optional<Estimate> at_once(Measured measured);
  std::optional<Estimate> take_waiting(Time until);
  void drive(const WheelMotion& wheels);
  std::optional<Estimate> drive(Time time, const Pose2& T_odom_robot);
  void drift(double seconds);
  double sigma_of(const GpsFix& fix) const;
  void roll(const motion::WheelStep& wheels, double seconds);
  Motion motion_to(std::size_t k, bool linear) const;
  Belief beginning() const;
  void move_to(Time time);
  void fuse(const ScanMatch& match, Node& node) const;
  void recognise(std::vector<BeaconSighting> seen);
  bool orient(double least_way);
  bool find_heading(double least_way);
  filter::AbsoluteInput<kExtra, 2> see(const GpsFix& fix, double weight, const State& at) const;
  void see(const BeaconSighting& sighting, double gate, Belief& belief,
           std::vector<Innovation>* innovations) const;
  void filter_node(std::size_t k, bool linear, double gate, std::size_t& piece,
                   std::vector<Innovation>* innovations);
  double round();
  void extend(std::size_t from, double bend);
  double converge();
  void weigh();
  double slow_weight(std::size_t piece) const;
  void settle();
  Estimate estimate(const Node& node, const Belief& belief) const;
  std::vector<LearntValue> learnt(const Belief& belief) const;

  KalmanOptions options_;
  beacon::BeaconMap beacons_;
  GpsPieces pieces_;
  std::vector<Node> nodes_;
  std::vector<GpsFix> fixes_;
  std::vector<FixVerdict> verdicts_;
  std::vector<double> weights_;       ///< of the fixes, Student's
  std::vector<double> slow_weights_;  ///< of the pieces
  std::size_t piece_ = kNone;         ///< of the newest fix that was believed
  Motion pending_;                    ///< since the newest node
  std::optional<WheelMotion> wheels_;
  std::optional<Odometry> odometry_;
  std::optional<ScanMatch> match_;
  std::deque<Measured> waiting_;  ///< for the odometry to come by
  double way_ = 0, turned_ = 0;   ///< m, rad, either way
  Time clock_ = 0;                ///< up to which the motion is integrated
  std::size_t settled_ = 0;       ///< nodes whose equations are linear at the smoothed path
  double settled_way_ = 0, cost_ = 0;
  bool begun_ = false, scans_ = false, oriented_ = false;
  Pose2 T_map_begin_;
  std::vector<Innovation> innovations_;
  Report report_;
};

/// The same as the registry wants it.
Localizer kalman(const KalmanOptions& options, const Pose2& start,
                 const beacon::BeaconMap& beacons);

}  // namespace majak::localize
