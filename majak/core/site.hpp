// SPDX-License-Identifier: Apache-2.0
// Site: what is left after a mapping run: scans, poses with covariances, constraints with their
// evidence, what was learnt about the robot, and the options used. Faces are built from it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "majak/core/edit.hpp"
#include "majak/core/estimate.hpp"
#include "majak/core/event.hpp"
#include "majak/core/report.hpp"

namespace majak {

/// A scan and what is known of where it was taken, in log order.
struct PosedScan {
  Scan scan;
  Estimate estimate;                  ///< final pose of the robot at the scan, covariance, health
  Pose2 T_map_robot_front_end;        ///< the pose before loop closing
  std::optional<Pose2> T_odom_robot;  ///< odometry at the scan's time, mended
  bool key = false;                   ///< a node of the graph; the others hang on their key scan
  float match_score = 0;              ///< share of beams that fit the map, 0 ... 1
};

enum class ConstraintKind : std::uint8_t { odometry, match, closure };

/// A measured relative pose between two scans.
struct Constraint {
  ConstraintKind kind = ConstraintKind::match;
  std::size_t from = 0;  ///< index into Site::scans
  std::size_t to = 0;
  Pose2 T_from_to;                  ///< between robot poses
  Mat3 information = Mat3::Zero();  ///< of log(T_from_to^-1 * truth), i.e. in the axes of `to`
  double score = 0;                 ///< share of beams that fit, 0 ... 1
  double overlap = 0;               ///< share of beams that the other scans could see, 0 ... 1
  double chi2 = 0;                  ///< squared Mahalanobis residual at the final poses, 3 dof
  bool enabled = true;              ///< false: rejected or switched off; kept as evidence
};

/// What the front end knew of a key scan when it matched it to a local map: with the constraints
/// enough to optimise the map anew without the log.
struct KeyLink {
  std::size_t local_map = 0;              ///< key scan that began that map; counts key scans
  bool weak_step = false;                 ///< the way from the key scan before is not to be trusted
  Mat3 match_information = Mat3::Zero();  ///< of its pose in that map, own axes
};

/// A value learnt from the log with its standard deviation.
struct Learnt {
  double value = 0;
  double sigma = 0;
  bool used = false;  ///< false: not determined by this log, or no better than the nominal value
};

/// What the log says about its own odometry and mounting (see motion/odometry_model).
struct OdometryFindings {
  Learnt lag_s;              ///< the odometry is this much later than the laser (s)
  Learnt translation_scale;  ///< true distance = scale * odometry's
  Learnt rotation_scale;
  Learnt laser_x_m, laser_y_m, laser_theta_rad;  ///< T_robot_laser
  std::int64_t reversed_records = 0;  ///< odometry records that state the wrong direction of travel
  std::int64_t jumps = 0;             ///< steps that no robot makes: the counters began anew
  double translation_noise = 0;       ///< m per sqrt(m), after mending
  double rotation_noise = 0;          ///< rad per sqrt(rad), after mending
};

struct Site {
  std::string source_name;  ///< the log's file name, without its folder
  std::vector<PosedScan> scans;
  std::vector<Constraint> constraints;
  std::vector<KeyLink> key_links;  ///< of the key scans in their order; empty: the method has none
  std::vector<Edit> edits;         ///< what people corrected, the oldest first
  /// The edits are in the scans and poses already (map/edits): for use, not for keeping.
  bool edits_applied = false;
  std::vector<Truth> truth;  ///< as found in the log, may be empty
  OdometryFindings odometry;
  bool used_odometry = false;
  std::string options_toml;  ///< effective options, can be fed back
  Report report;
};

}  // namespace majak
