// SPDX-License-Identifier: Apache-2.0
// A trajectory: poses with stamps, in any order; looked up by time, lined up one to one.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "majak/core/event.hpp"
#include "majak/core/pose2.hpp"
#include "majak/core/report.hpp"
#include "majak/core/time.hpp"
#include "majak/io/byte_stream.hpp"

namespace majak::eval {

struct StampedPose {
  Time time = 0;
  Pose2 pose;

  bool operator==(const StampedPose&) const = default;
};
using Trajectory = std::vector<StampedPose>;

/// TUM lines `time x y z qx qy qz qw`, stamps exact to the nanosecond; z, roll and pitch are
/// dropped. `name` is used in messages. Damaged lines are skipped and counted; throws Error if no
/// line holds a pose. A file may be packed by gzip or bzip2.
Trajectory read_tum(std::unique_ptr<io::ByteStream> bytes, const std::string& name, Report& report);
Trajectory read_tum(const std::string& path, Report& report);

/// The truth that a log carries, or what its odometry says at each scan.
Trajectory truth_of(const std::vector<Truth>& truth);
Trajectory odometry_of(const std::vector<Event>& events);

struct LookupOptions {
  Duration tolerance = 10'000;     ///< ns; nearer than this is the same stamp
  Duration max_gap = 2 * kSecond;  ///< ns; no interpolation across a wider gap
};

struct Lookup {
  Pose2 pose;
  bool exact = false;     ///< a stamp within the tolerance; else interpolated
  std::size_t index = 0;  ///< of the (nearest) pose in the trajectory as given
};

/// A trajectory sorted by stamp (stable: equal stamps keep their order).
class TrajectoryIndex {
 public:
  explicit TrajectoryIndex(const Trajectory& trajectory, LookupOptions options = {});

  /// The pose at a time: the nearest stamp within the tolerance (of equal stamps the
  /// `occurrence`-th), else interpolated along the arc between the neighbours, else nullopt
  /// (outside, or a wide gap).
  std::optional<Lookup> at(Time time, std::size_t occurrence = 0) const;

 private:
  std::optional<std::size_t> nearest(Time time) const;

  struct Entry {
    Time time;
    Pose2 pose;
    std::size_t index;
  };
  std::vector<Entry> entries_;
  LookupOptions options_;
};

struct PosePair {
  Time time = 0;
  Pose2 T_map_robot;        ///< estimate
  Pose2 T_reference_robot;  ///< reference
  bool exact = false;       ///< the reference has this very stamp
};

struct Association {
  std::vector<PosePair> pairs;  ///< by time
  std::size_t exact = 0;
  std::size_t interpolated = 0;
  std::size_t unmatched = 0;  ///< poses of the estimate without a reference
};

/// One pair for each pose of the estimate: no pose of the reference is used as it stands for two of
/// them; the k-th of equal stamps goes with the k-th.
Association associate(const Trajectory& estimate, const Trajectory& reference,
                      LookupOptions options = {});

}  // namespace majak::eval
