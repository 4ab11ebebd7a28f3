// SPDX-License-Identifier: Apache-2.0
// An underwater vehicle that goes round a course and sees fourteen features by sonar: EKF-SLAM in
// its textbook form, ranges and bearings to features that are told from each other (Smith, Self and
// Cheeseman 1990). The map's frame is the world's: the vehicle knows where it begins.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "majak/core/random.hpp"
#include "majak/filter/landmark_filter.hpp"

namespace majak::draw {

inline constexpr int kSonarFeatures = 14;
inline constexpr int kSonarLap = 160;      ///< steps
inline constexpr double kSonarStep = 1;    ///< m
inline constexpr double kSonarReach = 15;  ///< m

/// Where the features truly are, m.
const std::array<Vec2, kSonarFeatures>& sonar_features();

/// A feature as the filter knows it.
struct SonarFeature {
  Vec2 p_map = Vec2::Zero();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< m^2, map axes
};

class SonarDrive {
 public:
  explicit SonarDrive(std::uint64_t seed);

  /// A metre on, and a ping: every feature within reach answers.
  void step();
  int steps() const { return steps_; }
  const Pose2& truth() const { return truth_; }
  const Pose2& dead_reckoned() const { return dead_reckoned_; }
  const Pose2& estimate() const { return filter_.T_map_robot(); }
  /// Of the vehicle's place, m^2.
  Eigen::Matrix2d covariance() const { return filter_.covariance().topLeftCorner<2, 2>(); }
  std::optional<SonarFeature> feature(int number) const;
  /// Those that answered the last ping.
  const std::vector<int>& heard() const { return heard_; }
  /// One of them had been silent for half a lap: the vehicle is where it was before.
  bool loop_closes() const { return loop_closes_; }

 private:
  struct Echo {
    int number;
    double range, bearing;
  };
  std::vector<Echo> ping();
  void correct(const std::vector<Echo>& echoes);
  void add(const Echo& echo);

  RandomStream random_;
  Pose2 truth_, dead_reckoned_;
  filter::LandmarkFilter filter_;
  std::array<int, kSonarFeatures> id_;          ///< the filter's number, -1: never heard
  std::array<int, kSonarFeatures> heard_at_{};  ///< step
  std::vector<int> heard_;
  bool loop_closes_ = false;
  int steps_ = 0;
};

}  // namespace majak::draw
