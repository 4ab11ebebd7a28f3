// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/front_end.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace majak::slam {
namespace {

Mat3 information_of(const MotionPrior& motion) {
  const double t = 1.0 / (motion.sigma_translation * motion.sigma_translation);
  const double r = 1.0 / (motion.sigma_rotation * motion.sigma_rotation);
  return Vec3(t, t, r).asDiagonal();
}

}  // namespace

FrontEnd::FrontEnd(const FrontEndOptions& options) : options_(options), active_(options.map), next_(options.map) {}

FrontEndStep FrontEnd::add(const Scan& scan, const std::optional<MotionPrior>& motion) {
  FrontEndStep step;
  const auto points = match::scan_points(scan, options_.points, false, directions_);
  const Pose2 previous = pose_;
  if (started_ && points.size() >= 10) {
    const MotionPrior prior = motion ? *motion : MotionPrior{constant_velocity(scan.time), 2 * surprise_translation_, 2 * surprise_rotation_};
    step.match = track(points, prior);
    if (step.match.score < options_.trusted_score) {
      step.match = recover(points, step.match, prior, to_seconds(scan.time - last_time_) > options_.gap);
      step.searched = true;
    }
    // What was found far off the prediction must fit well, or it is another place that looks alike.
    const Pose2 off = between(previous * prior.T_previous_robot, step.match.T_map_robot);
    const bool far = off.translation().norm() > options_.search_translation || std::abs(off.theta) > options_.search_rotation;
    const bool gap = to_seconds(scan.time - last_time_) > options_.gap;
    const bool poor = step.match.score < (far ? options_.trusted_score : options_.weak_score);
    poor_ = poor ? poor_ + 1 : 0;
    step.broken = poor && (gap || poor_ >= options_.patience);
    if (step.broken) begin_again();
    // A scan that fits nowhere tells nothing: the wheels do, or the robot is taken to stand still.
    if (poor_ > 0 && step.match.score < 0.5 * options_.weak_score)
      step.match.T_map_robot = motion ? previous * motion->T_previous_robot : previous;
    pose_ = step.match.T_map_robot;
    step.prior_information = information_of(prior);
    if (!motion && !step.searched) learn_surprise(between(pose_, previous * prior.T_previous_robot));
  } else if (motion) {
    pose_ = pose_ * motion->T_previous_robot;
  }
  motion_ = poor_ == 0 ? between(previous, pose_) : Pose2{};
  motion_time_ = scan.time - last_time_;
  last_time_ = scan.time;
  step.T_map_robot = pose_;

  const Pose2 since_key = between(last_key_, pose_);
  step.key = points.size() >= 10 && (!started_ || step.broken || std::hypot(since_key.x, since_key.y) > options_.key_distance ||
             std::abs(since_key.theta) > options_.key_turn);
  if (step.key) {
    step.key_points = match::scan_points(scan, options_.points, true, directions_);
    insert(step.key_points, pose_);
    last_key_ = pose_;
    started_ = true;
  }
  return step;
}

void FrontEnd::learn_surprise(const Pose2& error) {
  const auto average = [](double rms, double e) { return std::sqrt(0.98 * rms * rms + 0.02 * e * e); };
  surprise_translation_ = std::clamp(average(surprise_translation_, error.translation().norm()), 0.01, 0.05);
  surprise_rotation_ = std::clamp(average(surprise_rotation_, error.theta), 0.01, 0.05);
}

// The last motion again, as long as the time took; stamps that come in bursts tell no velocity.
Pose2 FrontEnd::constant_velocity(Time now) const {
  const double ratio = motion_time_ > 0 ? static_cast<double>(now - last_time_) / static_cast<double>(motion_time_) : 0;
  return ratio > 0.3 && ratio < 3.0 ? exp(ratio * log(motion_)) : motion_;
}

match::Match FrontEnd::track(const match::ScanPoints& points, const MotionPrior& motion) {
  match::PosePrior prior;
  prior.T_map_robot = pose_ * motion.T_previous_robot;
  prior.information = information_of(motion);
  return match::align(points, active_, prior, options_.align);
}

match::Match FrontEnd::recover(const match::ScanPoints& points, match::Match tracked, const MotionPrior& motion, bool gap) {
  tracked = search_window(points, tracked, motion, {options_.search_translation, options_.search_rotation});
  if (tracked.score >= options_.weak_score) return tracked;
  return search_window(points, tracked, motion, {options_.wide_translation, gap ? kPi : options_.wide_rotation});
}

match::Match FrontEnd::search_window(const match::ScanPoints& points, const match::Match& tracked,
                                     const MotionPrior& motion, const match::SearchWindow& window) {
  const match::LikelihoodPyramid pyramid(active_, pose_.translation(), {.max_translation = window.translation});
  const auto found = match::search(points, pyramid, pose_ * motion.T_previous_robot, window,
                                   match::likelihood(points, pyramid, tracked.T_map_robot) + 0.02);
  if (!found) return tracked;
  match::PosePrior prior;
  prior.T_map_robot = found->T_map_robot;
  prior.information.diagonal() << 100, 100, 100;
  const match::Match refined = match::align(points, active_, prior, options_.align);
  return refined.score > tracked.score + 0.05 ? refined : tracked;
}

void FrontEnd::begin_again() {
  active_.clear();
  next_.clear();
  active_keys_ = next_keys_ = 0;
  poor_ = 0;
}

void FrontEnd::insert(const match::ScanPoints& points, const Pose2& pose) {
  match::add_to(active_, points, pose);
  if (++active_keys_ <= options_.local_map_keys) return;
  match::add_to(next_, points, pose);
  if (++next_keys_ < options_.local_map_keys) return;
  std::swap(active_, next_);
  active_keys_ = next_keys_;
  next_.clear();
  next_keys_ = 0;
}

}  // namespace majak::slam
