// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/sonar_drive.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace majak::draw {
namespace {

using filter::LandmarkFilter;

constexpr int kBody = LandmarkFilter::kBody;
const Vec3 kMotionSigma(0.1, 0.1, radians(0.5));  // m, m, rad a step: log, current, gyro
constexpr double kRangeSigma = 0.15;              // m
constexpr double kBearingSigma = radians(1);

/// Curvature that repeats twice a lap closes the course, whatever it is: an oval.
Vec3 twist_of(int step) {
  const double turn = 2 * kPi / kSonarLap;
  return {kSonarStep, 0, turn * (1 - 0.7 * std::cos(2 * turn * (step + 0.5)))};
}

/// Along the course, to its left and right by turns.
std::array<Vec2, kSonarFeatures> placed() {
  RandomStream random(16);
  std::array<Vec2, kSonarFeatures> features;
  Pose2 course;
  int step = 0;
  for (int i = 0; i < kSonarFeatures; ++i) {
    for (; step < i * kSonarLap / kSonarFeatures; ++step) course = course * exp(twist_of(step));
    const double ahead = random.uniform(-2, 2), aside = random.uniform(4, 9);
    features[static_cast<std::size_t>(i)] = course * Vec2(ahead, i % 2 ? aside : -aside);
  }
  return features;
}

LandmarkFilter beginning() {
  return {{}, LandmarkFilter::Extra::Zero(), LandmarkFilter::Body::Zero()};
}

}  // namespace

const std::array<Vec2, kSonarFeatures>& sonar_features() {
  static const std::array<Vec2, kSonarFeatures> features = placed();
  return features;
}

SonarDrive::SonarDrive(std::uint64_t seed) : random_(seed), filter_(beginning()) { id_.fill(-1); }

void SonarDrive::step() {
  const Vec3 twist = twist_of(steps_++);
  truth_ = truth_ * exp(twist);
  Vec3 error;
  for (int k = 0; k < 3; ++k) error(k) = kMotionSigma(k) * random_.normal();
  filter::RelativeInput<LandmarkFilter::kExtra> motion;
  motion.T_from_to = exp(twist) * exp(error);
  motion.noise = kMotionSigma.cwiseAbs2().asDiagonal();
  dead_reckoned_ = dead_reckoned_ * motion.T_from_to;
  filter_.predict(motion);
  const std::vector<Echo> echoes = ping();
  correct(echoes);
  heard_.clear();
  loop_closes_ = false;
  for (const Echo& echo : echoes) {
    const auto i = static_cast<std::size_t>(echo.number);
    if (id_[i] < 0)
      add(echo);
    else
      loop_closes_ |= steps_ - heard_at_[i] > kSonarLap / 2;
    heard_at_[i] = steps_;
    heard_.push_back(echo.number);
  }
}

std::vector<SonarDrive::Echo> SonarDrive::ping() {
  std::vector<Echo> echoes;
  for (int i = 0; i < kSonarFeatures; ++i) {
    const Vec2 q = truth_.inverse() * sonar_features()[static_cast<std::size_t>(i)];
    const double range = q.norm() + kRangeSigma * random_.normal();
    const double bearing = std::atan2(q.y(), q.x()) + kBearingSigma * random_.normal();
    if (q.norm() < kSonarReach) echoes.push_back({i, range, bearing});
  }
  return echoes;
}

// z = (|q|, direction of q), q = R' (l - t): Thrun, Burgard and Fox, table 10.1.
void SonarDrive::correct(const std::vector<Echo>& echoes) {
  std::vector<Echo> known;
  for (const Echo& e : echoes)
    if (id_[static_cast<std::size_t>(e.number)] >= 0) known.push_back(e);
  if (known.empty()) return;
  const auto n = 2 * static_cast<Eigen::Index>(known.size());
  Eigen::VectorXd residual(n), variance(n);
  Eigen::MatrixXd by_state = Eigen::MatrixXd::Zero(n, filter_.covariance().cols());
  for (Eigen::Index row = 0; row < n; row += 2) {
    const Echo& e = known[static_cast<std::size_t>(row / 2)];
    const int id = id_[static_cast<std::size_t>(e.number)];
    const Vec2 way = filter_.landmark(id) - estimate().translation();
    const double range = way.norm(), r2 = range * range;
    Eigen::Matrix2d by_landmark;
    by_landmark << way.x() / range, way.y() / range, -way.y() / r2, way.x() / r2;
    by_state.block<2, 2>(row, 0) = -by_landmark;
    by_state(row + 1, 2) = -1;
    by_state.block<2, 2>(row, filter_.column(id)) = by_landmark;
    const double bearing = std::atan2(way.y(), way.x()) - estimate().theta;
    residual.segment<2>(row) << e.range - range, angle_diff(e.bearing, bearing);
    variance.segment<2>(row) << kRangeSigma * kRangeSigma, kBearingSigma * kBearingSigma;
  }
  filter_.correct(residual, by_state, variance.asDiagonal());
}

void SonarDrive::add(const Echo& echo) {
  const double across = echo.range * kBearingSigma;
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(echo.bearing).toRotationMatrix();
  const Vec2 variance(kRangeSigma * kRangeSigma, across * across);
  id_[static_cast<std::size_t>(echo.number)] =
      filter_.add(Pose2{0, 0, echo.bearing} * Vec2(echo.range, 0),
                  turn * variance.asDiagonal() * turn.transpose());
}

std::optional<SonarFeature> SonarDrive::feature(int number) const {
  const int id = id_[static_cast<std::size_t>(number)];
  if (id < 0) return std::nullopt;
  const int column = filter_.column(id);
  return SonarFeature{filter_.landmark(id), filter_.covariance().block<2, 2>(column, column)};
}

}  // namespace majak::draw
