// SPDX-License-Identifier: Apache-2.0
#include "majak/localize/tracking.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "majak/localize/on_scans.hpp"

namespace majak::localize {
namespace {

constexpr std::size_t kLeastReturns = 10;
constexpr double kWeak = 0.10;        // m, sigma of a direction from which on it is weak
constexpr double kLongestStep = 1.0;  // s between scans, over which a motion is taken for steady
constexpr double kTelling = 0.02;     // m, residual at which a pair counts half
constexpr double kPeriodGain = 0.05;
constexpr double kBetter = 0.05;        // share of returns by which another pose must fit better
constexpr double kClearly = 0.20;       // the same, of a jump that one scan may tell
constexpr double kAllowed = 16;         // squared Mahalanobis distance that is no jump
constexpr double kContradicted = 0.10;  // share of returns from beyond walls
constexpr double kWall = 0.4;           // m, by which they must be beyond
constexpr double kOffsetMemory = 0.95;  // share of what is known that the next scan finds
constexpr double kSame = 0.15;          // m, rad
constexpr int kLearnt = 3;              // of so many scans that fit, one is learnt from

Vec3 difference(const Pose2& a, const Pose2& b) {
  return {a.x - b.x, a.y - b.y, angle_diff(a.theta, b.theta)};
}

Mat3 start_information(const TrackingOptions& options) {
  const double t = options.start_sigma, r = options.start_turn;
  return Vec3(1 / (t * t), 1 / (t * t), 1 / (r * r)).asDiagonal();
}

// c' (P- - P)^-1 c = c' W c + (W c)' H^-1 (W c), with W and H the informations of prediction and
// scan; where the scan tells nothing, nothing is corrected either.
double innovation(const match::PosePrior& prior, const match::Match& match) {
  const Vec3 pulled = prior.information * difference(match.T_map_robot, prior.T_map_robot);
  const Mat3 scan = match.information + 1e-3 * prior.information;
  return difference(match.T_map_robot, prior.T_map_robot).dot(pulled) +
         pulled.dot(scan.ldlt().solve(pulled));
}

}  // namespace

Tracker::Tracker(PlacePtr place, const TrackingOptions& options, const Pose2& start)
    : place_(std::move(place)), options_(options) {
  align_.sigma = options.return_sigma;
  align_.cauchy = kTelling;
  estimate_.T_map_robot = start;
  covariance_ = start_information(options).inverse();
}

Estimate Tracker::add(const FedScan& scan) {
  move(scan);
  predict();
  measure(scan);
  return correct();
}

void Tracker::move(const FedScan& scan) {
  motion_.T_previous_robot = scan.T_previous_robot;
  motion_.covariance = scan.covariance;
  twist_ = Vec3::Zero();
  const double passed = to_seconds(scan.scan.time - estimate_.time);
  // Stamps that come in bursts tell no velocity, their mean does.
  if (passed > 0 && passed < kLongestStep) {
    period_ += (period_ == 0 ? 1 : kPeriodGain) * (passed - period_);
    twist_ = log(scan.T_previous_robot) / std::max(period_, passed);
  }
  estimate_.time = scan.scan.time;
}

// x' = x * m: an error of heading swings the way that was made since.
void Tracker::predict() {
  const Pose2& from = estimate_.T_map_robot;
  T_map_predicted_ = from * motion_.T_previous_robot;
  Mat3 swing = Mat3::Identity(), turn = Mat3::Identity();
  swing(0, 2) = -(T_map_predicted_.y - from.y);
  swing(1, 2) = T_map_predicted_.x - from.x;
  const double c = std::cos(T_map_predicted_.theta), s = std::sin(T_map_predicted_.theta);
  turn.topLeftCorner<2, 2>() << c, -s, s, c;
  const Mat3 carried = swing * covariance_ * swing.transpose();
  predicted_covariance_ = carried + turn * motion_.covariance * turn.transpose();
  predicted_errors_ = carried + turn * errors_.of_wheels(motion_.covariance) * turn.transpose();
}

void Tracker::measure(const FedScan& scan) {
  match::ScanPointsOptions options;
  options.twist = twist_;
  options.mirror_turn = options_.mirror_turn;
  options.range_offset = offset_.offset;
  laser_ = scan.scan.T_robot_laser.translation();
  points_ = match::scan_points(scan.scan, options, false, directions_);
}

Estimate Tracker::correct() {
  take(T_map_predicted_, predicted_errors_);
  match_ = {};
  nis_ = 0;
  jumped_ = false;
  if (points_.size() >= kLeastReturns) {
    const match::PosePrior prior{T_map_predicted_, predicted_covariance_.inverse()};
    match_ = match::align(points_, place_->surfaces, prior, align_);
    if (match_.score < options_.lost_score ||
        (match_.score < options_.trusted_score && contradicted() > kContradicted))
      search_window(prior);
    else
      told_ = 0;
    poor_ = match_.score < options_.lost_score ? poor_ + 1 : 0;
    if (poor_ == 0 && !jumped_) {
      fuse(prior);
      nis_ = innovation(prior, match_);
    }
  }
  tell(estimate_);
  return estimate_;
}

// A scalar Kalman filter that forgets: the offset changes with the range, so with the place.
void Tracker::learn_offset() {
  if (options_.offset_sigma <= 0) return;
  const auto seen =
      match::range_offset(points_, place_->surfaces, match_.T_map_robot, laser_, align_);
  const double least = 1 / (options_.offset_sigma * options_.offset_sigma);
  const double known = std::max(kOffsetMemory * offset_.information, least);
  offset_.information = known + seen.information;
  offset_.offset += seen.information / offset_.information * seen.offset;
}

// The weights are those of the matching, so the covariance is that of a weighted mean whose parts
// err as they were found to: A^-1 (W P W + H C H) A^-1 with weights W, H and A = W + H.
void Tracker::fuse(const match::PosePrior& prior) {
  const Mat3 claimed = (prior.information + match_.information).inverse();
  const Mat3 held = claimed * prior.information;
  if (match_.score >= options_.trusted_score) {
    errors_.learn_wheels(difference(match_.T_map_robot, T_map_predicted_),
                         predicted_covariance_ - claimed);
    learn_offset();
    if (fitting_++ % kLearnt == 0) {
      errors_.learn_scan(match::jackknife(points_, place_->surfaces, match_.T_map_robot,
                                          prior.information, align_, {}),
                         offset_.offset);
      align_.noise = errors_.returns();
    }
  }
  take(match_.T_map_robot, held * predicted_errors_ * held.transpose() +
                               errors_.of_scan(claimed * match_.information * claimed));
}

void Tracker::take(const Pose2& T_map_robot, const Mat3& covariance) {
  estimate_.T_map_robot = T_map_robot;
  covariance_ = covariance;
}

// What the laser and the map's cells err by from scan to scan alike is told, but not remembered:
// the next scan does not make it less.
void Tracker::tell(Estimate& estimate) const {
  estimate.health = Health::ok;
  estimate.weak_direction = Vec2::Zero();
  estimate.covariance = covariance_ + errors_.of_ranges();
  estimate.covariance.diagonal().head<2>().array() += place_->surface_sigma * place_->surface_sigma;
  if (least_known(estimate.covariance).sigma > kWeak) degrade(estimate);
  if (poor_ > 0) estimate.health = poor_ < options_.patience ? Health::degraded : Health::lost;
}

// The scan fits badly where it was predicted to lie: is there a better pose in a window around? One
// that the prediction allows for is fused with it. Any other is a jump: someone has carried the
// robot, or people stand around it and another place looks alike. So the next scans must tell the
// same, unless one fits well and far better, and what was known before is forgotten.
void Tracker::search_window(const match::PosePrior& prior) {
  const match::LikelihoodPyramid pyramid(place_->surfaces, T_map_predicted_.translation(),
                                         {.max_translation = options_.search_translation});
  const auto found = match::search(points_, pyramid, T_map_predicted_,
                                   {options_.search_translation, options_.search_rotation},
                                   match::likelihood(points_, pyramid, match_.T_map_robot) + 0.02);
  if (!found) return void(told_ = 0);
  match::PosePrior loose{found->T_map_robot, Mat3::Zero()};
  loose.information.diagonal() << 100, 100, 100;
  match::Match refined = match::align(points_, place_->surfaces, loose, align_);
  if (refined.score < match_.score + kBetter) return void(told_ = 0);
  const Vec3 off = difference(refined.T_map_robot, T_map_predicted_);
  if (off.dot(prior.information * off) < kAllowed) {
    told_ = 0;
    const Mat3 sum = prior.information + refined.information;
    const Vec3 fused = T_map_predicted_.vector() + sum.ldlt().solve(refined.information * off);
    match_ = refined;
    match_.T_map_robot = from_vector(fused);
  } else if (told_before(refined.T_map_robot) ||
             (refined.score >= options_.trusted_score && refined.score > match_.score + kClearly)) {
    told_ = 0;
    jumped_ = true;
    match_ = refined;
    take(refined.T_map_robot, (refined.information + start_information(options_)).inverse());
  }
}

// Share of the returns that would have passed through a wall. Those that end before one do not
// speak against a pose: someone stands there.
double Tracker::contradicted() const {
  const Vec2 from = match_.T_map_robot * laser_;
  int through = 0;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Vec2 way = match_.T_map_robot * Vec2(points_.x[i], points_.y[i]) - from;
    const double range = way.norm(), reach = range - kWall;
    through += reach > 0 && place_->distances.cast(from, way / range, reach) < reach;
  }
  return static_cast<double>(through) / static_cast<double>(points_.size());
}

bool Tracker::told_before(const Pose2& T_map_robot) {
  const Vec3 off = difference(T_map_robot, rumour_ * motion_.T_previous_robot);
  const bool same = told_ > 0 && off.head<2>().norm() < kSame && std::abs(off.z()) < kSame;
  told_ = same ? told_ + 1 : 1;
  rumour_ = T_map_robot;
  return told_ >= options_.witnesses;
}

Localizer tracking(const PlacePtr& place, const TrackingOptions& options, const Pose2& start,
                   const PlausibilityOptions& plausibility, const std::function<double()>& clock) {
  return on_scans([tracker = Tracker(place, options, start),
                   watch = Plausibility(place, plausibility),
                   clock](const FedScan& scan, Localization& result) mutable -> Step {
    const auto now = [&] { return clock ? clock() : 0.0; };
    std::array<double, 5> t{};
    t[0] = now();
    tracker.move(scan);
    t[1] = now();
    tracker.predict();
    t[2] = now();
    tracker.measure(scan);
    t[3] = now();
    Estimate estimate = tracker.correct();
    t[4] = now();
    if (result.phases.empty())
      result.phases = {{"move", 0}, {"predict", 0}, {"measure", 0}, {"correct", 0}};
    for (std::size_t k = 0; k < 4; ++k) result.phases[k].seconds += t[k + 1] - t[k];
    result.innovations.push_back({estimate.time, "laser", tracker.nis(), 3, tracker.nis() > 0});
    watch.add(scan, estimate.T_map_robot);
    const bool trusted = estimate.health == Health::ok;
    watch.limit(estimate);
    return {estimate, trusted};
  });
}

void describe(OptionFields& f, TrackingOptions& o) {
  f.add("tracking.start_sigma", o.start_sigma, {"m", "how well the start is known", 0.001, 10});
  f.add("tracking.start_turn", o.start_turn, {"rad", "how well the start is known", 0.001, 4});
  f.add("tracking.return_sigma", o.return_sigma, {"m", "of a return against the map", 0.001, 1});
  f.add("tracking.trusted_score", o.trusted_score,
        {"1", "share of returns on the map below which a window is searched", 0, 1});
  f.add("tracking.lost_score", o.lost_score, {"1", "share below which the robot is lost", 0, 1});
  f.add("tracking.patience", o.patience, {"1", "scans in a row before it says so", 1, 1000});
  f.add("tracking.search_translation", o.search_translation,
        {"m", "half width of that window", 0.1, 8});
  f.add("tracking.search_rotation", o.search_rotation, {"rad", "half width", 0.01, 3.2});
  f.add("tracking.offset_sigma", o.offset_sigma,
        {"m", "by how much the laser may read too long", 0, 1});
  f.add("tracking.witnesses", o.witnesses,
        {"1", "scans in a row that must tell of a jump", 1, 1000});
  f.add("tracking.mirror_turn", o.mirror_turn, {"s", "of the laser's mirror, 0: none", 0, 1});
}

}  // namespace majak::localize
