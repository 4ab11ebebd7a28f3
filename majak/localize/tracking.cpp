// SPDX-License-Identifier: Apache-2.0
#include "majak/localize/tracking.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <memory>
#include <utility>

namespace majak::localize {
namespace {

constexpr std::size_t kLeastReturns = 10;
constexpr double kWeak = 0.10;  // m, sigma of a direction from which on it is weak

}  // namespace

Tracker::Tracker(PlacePtr place, const TrackingOptions& options, const Pose2& start)
    : place_(std::move(place)), options_(options) {
  align_.sigma = options.return_sigma;
  estimate_.T_map_robot = start;
  const double t = options.start_sigma, r = options.start_turn;
  covariance_ = Vec3(t * t, t * t, r * r).asDiagonal();
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
  predicted_covariance_ =
      swing * covariance_ * swing.transpose() + turn * motion_.covariance * turn.transpose();
}

void Tracker::measure(const FedScan& scan) {
  points_ = match::scan_points(scan.scan, {}, false, directions_);
}

Estimate Tracker::correct() {
  estimate_.T_map_robot = T_map_predicted_;
  estimate_.health = Health::ok;
  estimate_.weak_direction = Vec2::Zero();
  covariance_ = predicted_covariance_;
  match_ = {};
  nis_ = 0;
  if (points_.size() >= kLeastReturns) {
    const match::PosePrior prior{T_map_predicted_, predicted_covariance_.inverse()};
    match_ = match::align(points_, place_->surfaces, prior, align_);
    if (match_.score < options_.trusted_score) search_window();
    poor_ = match_.score < options_.lost_score ? poor_ + 1 : 0;
    if (poor_ == 0) {
      estimate_.T_map_robot = match_.T_map_robot;
      covariance_ = (prior.information + match_.information).inverse();
      const Vec3 off = match_.T_map_robot.vector() - T_map_predicted_.vector();
      const Vec3 correction(off.x(), off.y(), wrap_angle(off.z()));
      nis_ = correction.dot((predicted_covariance_ - covariance_).inverse() * correction);
    }
  }
  Mat3& shown = estimate_.covariance = covariance_;
  shown.diagonal() += Vec3(options_.map_sigma, options_.map_sigma, options_.map_turn).cwiseAbs2();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes;
  axes.computeDirect(shown.topLeftCorner<2, 2>());
  if (axes.eigenvalues()(1) > kWeak * kWeak) {
    estimate_.health = Health::degraded;
    estimate_.weak_direction = axes.eigenvectors().col(1);
  }
  if (poor_ > 0 && poor_ < options_.patience) estimate_.health = Health::degraded;
  if (poor_ >= options_.patience) estimate_.health = Health::lost;
  return estimate_;
}

// The prediction was no use: the best pose of a whole window, and from there the matching again.
void Tracker::search_window() {
  const match::LikelihoodPyramid pyramid(place_->surfaces, T_map_predicted_.translation(),
                                         {.max_translation = options_.search_translation});
  const auto found = match::search(points_, pyramid, T_map_predicted_,
                                   {options_.search_translation, options_.search_rotation},
                                   match::likelihood(points_, pyramid, match_.T_map_robot) + 0.02);
  if (!found) return;
  match::PosePrior loose{found->T_map_robot, Mat3::Zero()};
  loose.information.diagonal() << 100, 100, 100;
  const match::Match refined = match::align(points_, place_->surfaces, loose, align_);
  if (refined.score > match_.score + 0.05) match_ = refined;
}

namespace {

struct TrackingRun {
  ScanFeed feed;
  Tracker tracker;
  Localization result;
  std::function<double()> clock;
  bool first = true;

  std::optional<Estimate> take_scans() {
    std::optional<Estimate> newest;
    while (const auto scan = feed.next()) {
      const double t0 = now();
      tracker.move(*scan);
      const double t1 = now();
      tracker.predict();
      const double t2 = now();
      tracker.measure(*scan);
      const double t3 = now();
      const Pose2 before = result.estimates.empty() ? Pose2{} : result.estimates.back().T_map_robot;
      newest = tracker.correct();
      const double t4 = now();
      result.phases.resize(4);
      for (const auto& [k, name, seconds] :
           {std::tuple(0, "move", t1 - t0), std::tuple(1, "predict", t2 - t1),
            std::tuple(2, "measure", t3 - t2), std::tuple(3, "correct", t4 - t3)}) {
        result.phases[k].name = name;
        result.phases[k].seconds += seconds;
      }
      result.innovations.push_back({newest->time, "laser", tracker.nis(), 3, tracker.nis() > 0});
      if (!first) feed.observe(between(before, newest->T_map_robot), newest->health == Health::ok);
      first = false;
      result.estimates.push_back(*newest);
    }
    return newest;
  }
  double now() const { return clock ? clock() : 0; }
};

}  // namespace

Localizer tracking(const PlacePtr& place, const TrackingOptions& options, const Pose2& start,
                   const std::function<double()>& clock) {
  const auto run = std::make_shared<TrackingRun>(
      TrackingRun{ScanFeed{}, Tracker(place, options, start), {}, clock, true});
  return {[run](const Event& event) {
            run->feed.add(event);
            return run->take_scans();
          },
          [run] {
            run->feed.end();
            run->take_scans();
            return std::move(run->result);
          }};
}

void describe(OptionFields& f, TrackingOptions& o) {
  f.add("tracking.start_sigma", o.start_sigma, {"m", "how well the start is known", 0.001, 10});
  f.add("tracking.start_turn", o.start_turn, {"rad", "how well the start is known", 0.001, 4});
  f.add("tracking.return_sigma", o.return_sigma, {"m", "of a return against the map", 0.001, 1});
  f.add("tracking.map_sigma", o.map_sigma, {"m", "of the map itself", 0, 1});
  f.add("tracking.map_turn", o.map_turn, {"rad", "of the map itself", 0, 1});
  f.add("tracking.trusted_score", o.trusted_score,
        {"1", "share of returns on the map below which a window is searched", 0, 1});
  f.add("tracking.lost_score", o.lost_score, {"1", "share below which the robot is lost", 0, 1});
  f.add("tracking.patience", o.patience, {"1", "scans in a row before it says so", 1, 1000});
  f.add("tracking.search_translation", o.search_translation,
        {"m", "half width of that window", 0.1, 8});
  f.add("tracking.search_rotation", o.search_rotation, {"rad", "half width", 0.01, 3.2});
}

}  // namespace majak::localize
