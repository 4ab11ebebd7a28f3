// SPDX-License-Identifier: Apache-2.0
// What a scan shows to EKF-SLAM, and which landmark is which.
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "majak/core/chi_square.hpp"
#include "majak/match/scan_points.hpp"
#include "majak/slam/ekf_slam.hpp"

namespace majak::slam {
namespace {

using filter::LandmarkFilter;

constexpr double kNever = 3;  // times as far as ever before
constexpr int kWitness = 10;  // sightings of a landmark that may contradict the wheels

}  // namespace

// In the robot's frame at the scan's stamp: meanwhile it drove on.
std::vector<EkfSlam::Seen> EkfSlam::look(const Scan& scan) const {
  std::vector<Seen> seen;
  for (const beacon::LandmarkSighting& s : beacon::find_trunks(scan, options_.trunks)) {
    const double late = 0.5 * (match::beam_time(scan, s.beam, options_.mirror_turn) +
                               match::beam_time(scan, s.beam + 1, options_.mirror_turn));
    const Pose2 T_robot_laser = exp(late * motion_.twist()) * scan.T_robot_laser;
    const Vec2 q = T_robot_laser * s.p_laser();
    const double across = s.range * s.bearing_sigma;
    const Eigen::Matrix2d turn =
        Eigen::Rotation2Dd(T_robot_laser.theta + s.bearing).toRotationMatrix();
    const double bark = options_.trunks.range_sigma;
    Eigen::Matrix2d noise =
        turn * Vec2(bark * bark, across * across).asDiagonal() * turn.transpose();
    noise.diagonal().array() += options_.point_sigma * options_.point_sigma;
    seen.push_back(
        {q, s.depth * turn.col(0), noise, s.diameter, s.diameter_sigma * s.diameter_sigma});
  }
  if (options_.see_corners) look_for_corners(scan, seen);
  return seen;
}

// A corner has no diameter; one that no trunk has keeps the two kinds apart.
void EkfSlam::look_for_corners(const Scan& scan, std::vector<Seen>& seen) const {
  const Eigen::Matrix2d unsure = std::pow(options_.point_sigma, 2) * Eigen::Matrix2d::Identity();
  for (const Corner& corner : find_corners(scan, options_.corners))
    seen.push_back({corner.p_robot, Vec2::Zero(), corner.covariance + unsure, kCorner, 1e-6});
}

// The bark is what was seen; how far behind it the centre is, the diameter says.
EkfSlam::Centre EkfSlam::centre(const Seen& seen, double diameter, double variance) {
  return {seen.q_robot + (diameter - seen.diameter) * seen.by_diameter,
          seen.noise + variance * seen.by_diameter * seen.by_diameter.transpose()};
}

// Whose diameter is known from many sightings, most of all from near ones: a single one from far
// off tells little of it, and errs always to the same side.
EkfSlam::Centre EkfSlam::centre(const Seen& seen, int id) const {
  Known known = known_[static_cast<std::size_t>(id)];
  known.measure(seen);
  return centre(seen, known.diameter, known.diameter_variance);
}

void EkfSlam::Known::measure(const Seen& seen) {
  const double share = diameter_variance / (diameter_variance + seen.diameter_variance);
  diameter += share * (seen.diameter - diameter);
  diameter_variance *= 1 - share;
}

void EkfSlam::remember(const Seen& seen, int id) {
  Known& known = known_[static_cast<std::size_t>(id)];
  known.measure(seen);
  ++known.sightings;
  known.missed = 0;
  known.last = clock_;
  sightings_.push_back({estimates_.size(), id, seen});
}

// q = R' (l - t), the landmark in the robot's frame.
Pairing EkfSlam::pair(const Seen& seen, int id, const Eigen::MatrixXd& covariance) const {
  const Pose2& at = filter_.T_map_robot();
  const Eigen::Matrix2d back = Eigen::Rotation2Dd(at.theta).toRotationMatrix().transpose();
  const Vec2 q = back * (filter_.landmark(id) - at.translation());
  Pairing p;
  p.landmark = id;
  p.column = filter_.column(id);
  const Centre seen_at = centre(seen, id);
  p.innovation = seen_at.q_robot - q;
  p.by_state << -back, Vec2(q.y(), -q.x()), back;
  p.spread = shared_spread(p, p, covariance) + seen_at.noise;
  p.nis = p.innovation.dot(p.spread.inverse() * p.innovation);
  return p;
}

std::vector<Pairing> EkfSlam::candidates(const Seen& seen,
                                         const Eigen::MatrixXd& covariance) const {
  constexpr double kReach = 15;  // m, farther off nothing is looked at
  const double gate = chi_square_quantile(options_.association.gate, 2);
  const double diameter_variance = options_.diameter_sigma * options_.diameter_sigma;
  const Vec2 p_map = filter_.T_map_robot() * seen.q_robot;
  std::vector<Pairing> found;
  for (const int id : filter_.near()) {
    if ((filter_.landmark(id) - p_map).squaredNorm() > kReach * kReach) continue;
    const double wider = seen.diameter - known_[static_cast<std::size_t>(id)].diameter;
    if (wider * wider > 9 * (seen.diameter_variance + diameter_variance)) continue;
    const Pairing p = pair(seen, id, covariance);
    if (p.nis < gate) found.push_back(p);
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Pairing& a, const Pairing& b) { return a.nis < b.nis; });
  return found;
}

const Pairing* EkfSlam::Matching::pairing(std::size_t sighting) const {
  const int c = choice[sighting];
  return c < 0 ? nullptr : &allowed[sighting][static_cast<std::size_t>(c)];
}

EkfSlam::Matching EkfSlam::match(const std::vector<Seen>& seen,
                                 const Eigen::MatrixXd& covariance) const {
  Matching matching;
  for (const Seen& s : seen) matching.allowed.push_back(candidates(s, covariance));
  matching.choice = associate_jointly(matching.allowed, covariance, options_.association);
  for (std::size_t s = 0; s < seen.size(); ++s)
    if (const Pairing* p = matching.pairing(s)) matching.followed += followed(p->landmark);
  return matching;
}

bool EkfSlam::followed(int id) const {
  const Known& known = known_[static_cast<std::size_t>(id)];
  return !estimates_.empty() && known.last == estimates_.back().time && known.sightings > kWitness;
}

// ---- Wheels that err more than they ever say -------------------------------------------------

// A sensor that is stuck tells nothing until it moves again.
bool EkfSlam::mistrusted(Time time) {
  const bool same = motion_.steering_held() > options_.stuck;
  stuck_ = same && (stuck_ || motion_.steering_held() > kNever * motion_.steering_held_before());
  return stuck_ || time < mistrusted_until_;
}

// Of a step. The way, too: it bends within the step.
Mat3 EkfSlam::told_nothing(double seconds) const {
  return options_.mistrusted_noise * options_.mistrusted_noise * seconds * Mat3::Identity();
}

// Most landmarks of the scan before are seen no more, and would be if the robot had moved
// otherwise: they are believed, all together, and the wheels are not.
void EkfSlam::match_without_wheels(const std::vector<Seen>& seen, Matching& matching) {
  const auto& near = filter_.near();
  const auto before =
      static_cast<int>(std::count_if(near.begin(), near.end(), [&](int i) { return followed(i); }));
  if (before < 2 || 2 * matching.followed >= before || mistrusted(clock_)) return;
  filter::RelativeInput<LandmarkFilter::kExtra> more;
  more.at = filter_.extra();
  more.noise = told_nothing(to_seconds(clock_ - estimates_.back().time));
  Eigen::MatrixXd covariance = filter_.covariance();
  covariance.topLeftCorner<3, 3>() += more.noise;
  Matching without = match(seen, covariance);
  if (without.followed < matching.followed + 2 || 2 * without.followed < before) return;
  matching = std::move(without);
  filter_.predict(more);
  steps_.back().noise += more.noise;
  mistrusted_until_ = clock_ + from_seconds(options_.mistrust);
  stuck_ = motion_.steering_held() > options_.stuck;
}

// Landmarks that were not seen for long come back by several at once, or again and again: a single
// bush that happens to stand where a trunk was foretold must not turn the map.
void EkfSlam::doubt(Time time, Matching& matching) {
  std::vector<std::size_t> returning;
  for (std::size_t s = 0; s < matching.choice.size(); ++s) {
    const Pairing* pairing = matching.pairing(s);
    if (!pairing) continue;
    Known& known = known_[static_cast<std::size_t>(pairing->landmark)];
    if (to_seconds(time - known.last) < options_.recent) continue;
    known.returns = to_seconds(time - known.returned) < 1 ? known.returns + 1 : 1;
    known.returned = time;
    if (known.returns < options_.witnesses) returning.push_back(s);
  }
  if (static_cast<int>(returning.size()) >= options_.witnesses) return;
  for (const std::size_t s : returning) matching.choice[s] = kDoubted;
}

}  // namespace majak::slam
