// SPDX-License-Identifier: Apache-2.0
// OdometryModel: what the wheels say about a motion, distrusted. It compares the odometry with the
// laser's own motion as the log goes by and learns the odometry's lag, scale and direction of
// travel, and where the laser sits; predictions are made with what was learnt.
//
//   laser motion = D^-1 * mended wheel motion(t + lag) * D,   D = (x, y, theta) of the laser's true
//   mounting against the nominal one (hand-eye relation, docs/MATH.md "Odometry").
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "majak/core/event.hpp"
#include "majak/core/site.hpp"
#include "majak/motion/drive_correction.hpp"
#include "majak/motion/odometry_fit.hpp"

namespace majak::motion {

struct OdometryModelOptions {
  double floor_translation = 0.02;          ///< m, least sigma of a predicted motion
  double floor_rotation = 0.02;             ///< rad
  double learnt_floor_translation = 0.004;  ///< m, the same once the noise is learnt
  double learnt_floor_rotation = 0.006;     ///< rad
  double share = 0.2;       ///< sigma per unit of predicted motion before anything is learnt
  double max_lag = 0.30;    ///< s, searched on both sides
  double lag_step = 0.05;   ///< s, of that search; then by Newton steps
  double wheelbase = 2.83;  ///< m, of a car that reports speed and steering
};

/// With the wheelbase that a calibration was made with, if there is one.
inline OdometryModelOptions with_wheelbase(OdometryModelOptions options,
                                           const DriveCorrection& drive) {
  if (drive.wheelbase > 0) options.wheelbase = drive.wheelbase;
  return options;
}

/// A predicted motion of the robot between two scans.
struct PredictedMotion {
  Pose2 T_previous_robot;
  double sigma_translation = 0;  ///< m
  double sigma_rotation = 0;     ///< rad
};

class OdometryModel {
 public:
  explicit OdometryModel(const OdometryModelOptions& options = {}) : options_(options) {}

  void add(const Odometry& odometry);
  /// Speed and steering, added up to such poses. A log has either; the first to come counts.
  void add(const WheelMotion& wheels);
  /// A scan arrives; its own odometry record, if it has one, is kept with it.
  void add(const Scan& scan);

  /// Is all odometry there that a prediction up to scan number `scan` wants?
  bool ready(std::size_t scan) const;
  /// Motion between scan - 1 and scan (numbers in order of add); nothing without odometry.
  std::optional<PredictedMotion> predict(std::size_t scan) const;
  /// The odometry's own path at a scan, mended, in the odometry's frame.
  std::optional<Pose2> pose(std::size_t scan) const;

  /// Tells how the robot moved from scan - 1 to scan by the laser; `trusted` if the match was good.
  void observe(std::size_t scan, const Pose2& T_previous_robot, bool trusted);

  const OdometryFindings& findings() const { return findings_; }

 private:
  struct Sample {
    Time time;
    Pose2 raw, mended;
    double speed;  ///< m/s, 0 if the log does not say; of a scan's record the stream's
  };
  /// One chain of odometry poses. `records`: the poses in the scans' own records.
  struct Stream {
    std::vector<Sample> samples;
    std::vector<Time> latest;  ///< running maximum of the stamps: what is searched
    std::vector<Time> jumps;   ///< of the samples that no robot could reach from the one before
    void push(Time time, const Pose2& pose, double speed, bool reversed);
    double speed(Time time) const;  ///< as last stated by then
    bool jumped(Time from, Time to) const;
    /// `hint`: where the last call found it; times that follow each other are found at once.
    std::optional<Pose2> at(Time time, std::size_t& hint) const;
  };
  struct Choice {
    bool records = true;
    Duration lag = 0;
    bool operator==(const Choice&) const = default;
  };
  struct Observed {
    Pose2 motion;
    bool trusted = false;
  };

  std::optional<Pose2> pose(const Choice& choice, std::size_t scan, std::size_t& hint) const;
  std::optional<Pose2> pose(const Choice& choice, std::size_t scan) const;
  std::optional<Pose2> wheel_motion(const Choice& choice, std::size_t scan) const;
  Pose2 foretold(const Pose2& wheels) const;
  double disagreement(const Choice& choice, std::size_t first, std::size_t stride = 1) const;
  std::vector<ComparedStep> compare(const Choice& choice, bool timed, std::size_t first) const;
  void count_jumps();
  void learn(std::size_t newest);
  void learn_direction(std::size_t first);
  bool stamps_tell(const Choice& choice, std::size_t first) const;
  Choice search_lag(std::size_t first) const;
  void learn_faults(std::size_t first);
  void choose_lag(const Choice& found, const OdometryFit& fit, std::size_t first);
  void take_findings(const OdometryFit& fit);
  void learn_noise(std::size_t first);

  OdometryModelOptions options_;
  Stream records_, stream_;
  std::optional<WheelMotion> wheels_;
  std::vector<Time> scan_times_;
  std::vector<std::size_t> record_of_;  ///< sample of records_ that came with a scan
  std::vector<Observed> observed_;
  Choice choice_;
  bool reversed_ = false;  ///< a negative stated speed goes with a positive step
  double scale_ = 1, turn_scale_ = 1;
  Pose2 offset_;  ///< D
  std::size_t next_learning_ = 300;
  OdometryFindings findings_;
};

}  // namespace majak::motion
