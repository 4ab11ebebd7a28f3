// SPDX-License-Identifier: Apache-2.0
#include "majak/methods/kalman_with_laser.hpp"

#include <memory>

#include "majak/motion/odometry_model.hpp"

namespace majak::methods {
namespace {

// A step is the difference of two places in one local map. Their errors do not add up over the
// steps, as independent ones would; what does add up is the local map's own walk (docs/MATH.md
// section 4). So a step counts as so many matches, and no better than that walk.
constexpr double kMatches = 12;
constexpr double kWalk = 0.7e-3, kTurnWalk = 0.55e-3;  // m and rad per root of a key scan's 0.25 m
constexpr double kLeast = 1e-3;                     // 1/m^2, 1/rad^2, of what a match leaves open
constexpr double kKeyWay = 0.25, kLeastWay = 0.01;  // m

class KalmanWithLaser {
 public:
  KalmanWithLaser(const KalmanWithLaserOptions& options, const Pose2& start,
                  const beacon::BeaconMap& beacons)
      : options_(options),
        kalman_(options.kalman, start, beacons),
        front_end_(options.front_end),
        odometry_({.wheelbase = options.kalman.wheelbase}) {}

  std::optional<Estimate> add(const Event& event) {
    if (const auto* odometry = std::get_if<Odometry>(&event)) odometry_.add(*odometry);
    if (const auto* wheels = std::get_if<WheelMotion>(&event)) odometry_.add(*wheels);
    if (const auto* scan = std::get_if<Scan>(&event); scan && scan->laser == 0) match(*scan);
    return kalman_.add(event);
  }
  localize::Localization finish() { return kalman_.finish(); }

 private:
  void match(const Scan& scan) {
    odometry_.add(scan);
    std::optional<slam::MotionPrior> prior;
    if (scans_ > 0)
      if (const auto m = odometry_.predict(scans_))
        prior = slam::MotionPrior{m->T_previous_robot, m->sigma_translation, m->sigma_rotation};
    const slam::FrontEndStep step = front_end_.add(scan, prior);
    const bool sound = scans_ > 0 && !step.broken && !step.held && !step.searched &&
                       step.match.score > options_.front_end.weak_score;
    const Pose2 T_from_to = between(previous_, step.T_map_robot);
    if (scans_ > 0) odometry_.observe(scans_, T_from_to, sound);
    if (sound) {
      const double c = std::cos(step.T_map_robot.theta), s = std::sin(step.T_map_robot.theta);
      Mat3 turn = Mat3::Identity();  // from the robot's axes to the local map's
      turn.topLeftCorner<2, 2>() << c, -s, s, c;
      const double keys = (kLeastWay + T_from_to.translation().norm()) / kKeyWay;
      Mat3 noise =
          (kMatches * turn.transpose() * step.match.information * turn + kLeast * Mat3::Identity())
              .inverse();
      noise.diagonal() += keys * Vec3(kWalk * kWalk, kWalk * kWalk, kTurnWalk * kTurnWalk);
      kalman_.matched(T_from_to, noise.inverse());
    }
    previous_ = step.T_map_robot;
    ++scans_;
  }

  KalmanWithLaserOptions options_;
  localize::Kalman kalman_;
  slam::FrontEnd front_end_;
  motion::OdometryModel odometry_;
  std::size_t scans_ = 0;
  Pose2 previous_;
};

}  // namespace

localize::Localizer kalman_with_laser(const KalmanWithLaserOptions& options, const Pose2& start,
                                      const beacon::BeaconMap& beacons) {
  const auto method = std::make_shared<KalmanWithLaser>(options, start, beacons);
  return {[method](const Event& event) { return method->add(event); },
          [method] { return method->finish(); }};
}

}  // namespace majak::methods
