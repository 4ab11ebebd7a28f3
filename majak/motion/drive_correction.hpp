// SPDX-License-Identifier: Apache-2.0
// DriveCorrection: what a calibration found wrong with the wheels and the laser's place, and how to
// mend a log with it. An options file holds it as the table [odometry].
//
//   motion::CorrectedDrive drive(correction);
//   while (auto event = log->next()) { drive.apply(*event); use(*event); }
#pragma once

#include <optional>

#include "majak/core/event.hpp"
#include "majak/core/options.hpp"

namespace majak::motion {

/// Of a step that the wheels report as the twist (x, y, turn):
///   x' = scale x + way_per_turn turn,   y' = scale y,   turn' = turn_scale turn + turn_per_metre x
/// (docs/MATH.md "Calibration"). The defaults change nothing.
struct DriveCorrection {
  double lag = 0;              ///< s, the odometry is this much later than the laser
  double scale = 1;            ///< true way per way of the odometry
  double turn_scale = 1;       ///< true turn per turn of the odometry
  double turn_per_metre = 0;   ///< rad/m, of unequal wheels; left positive
  double way_per_turn = 0;     ///< m/rad, of unequal wheels
  double steering_offset = 0;  ///< rad, to be added to the steering of an Ackermann drive
  double wheelbase = 0;        ///< m, of such a drive, that all this was found with; 0: not told
  bool reversed = false;       ///< records that state a negative speed go a step ahead: turn these
  bool mounting = false;       ///< the laser's place below holds, not that of the log
  double laser_x = 0, laser_y = 0, laser_theta = 0;  ///< T_robot_laser, m and rad

  bool operator==(const DriveCorrection&) const = default;
};

void describe(OptionFields& fields, DriveCorrection& correction);

/// The twist of a step, corrected.
Vec3 corrected(const DriveCorrection& correction, const Vec3& twist);
/// Speed and steering, corrected: the turn is turn_scale times what the wheels say.
WheelMotion corrected(const DriveCorrection& correction, const WheelMotion& wheels);

/// A step that no robot makes in that time: the counters began anew.
bool leaps(const Pose2& step, double seconds);
/// A logger that integrates |v| writes a step ahead where it states a negative speed.
Pose2 turned_round(const Pose2& step, double speed);

/// Mends the events of a log, in the log's order. The stamps of wheels are moved by the lag; where
/// there is one, a scan's own odometry, which cannot be moved, is taken away.
class CorrectedDrive {
 public:
  explicit CorrectedDrive(const DriveCorrection& correction) : correction_(correction) {}
  void apply(Event& event);

 private:
  struct Chain {
    std::optional<Pose2> raw, mended;
    Time time = 0;
  };
  Pose2 next(Chain& chain, Time time, const Pose2& raw) const;
  DriveCorrection correction_;
  Chain stream_, records_;
  double speed_ = 0;  ///< m/s, as last stated
};

}  // namespace majak::motion
