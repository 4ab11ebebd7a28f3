// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/front_end.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

namespace majak::slam {
namespace {

// Without wheels a few stray returns must not turn the motion round where the rest say nothing:
// returns of one wall share their errors, so together they count too much, and habit is counted up
// to match.
constexpr double kHabit = 4.0;

constexpr double kAgainst = 4.0;      // sigmas off the wheels, and at least
constexpr std::pair kSlip{0.3, 0.4};  // m, rad: what wheels slip between two scans; half of it
                                      // is doubted where things may walk

constexpr double kDoubt = 2.0;  // sigmas off the wheels from which on a match is doubted

constexpr double kWalked = 0.03;      // m, by which things that walk move a match, at least
constexpr double kCrowd = 0.1;        // share of the returns that is of things that may walk
constexpr int kCrowdedWitnesses = 3;  // times as many

constexpr int kSlideGain = 3;         // returns more that must fit
constexpr double kSlideShare = 0.33;  // of the returns left over, that must fit then
constexpr double kSlideWeak = 0.04;   // share of the strong direction's information
constexpr double kSlideGate = 0.08, kSlideStep = 0.06, kSlideReach = 0.6;  // m

Mat3 information_of(const MotionPrior& motion) {
  const double t = 1.0 / (motion.sigma_translation * motion.sigma_translation);
  const double r = 1.0 / (motion.sigma_rotation * motion.sigma_rotation);
  return Vec3(t, t, r).asDiagonal();
}

}  // namespace

FrontEnd::FrontEnd(const FrontEndOptions& options)
    : options_(options), active_(options.map), next_(options.map) {}

FrontEndStep FrontEnd::add(const Scan& scan, const std::optional<MotionPrior>& motion) {
  FrontEndStep step;
  const auto points = match::scan_points(scan, options_.points, false, directions_);
  const Pose2 previous = pose_;
  const bool matched = started_ && points.size() >= 10;
  if (matched) {
    const MotionPrior prior = motion ? *motion : habit(scan.time);
    predict(prior);
    follow(points, prior, to_seconds(scan.time - last_time_) > options_.gap, step);
    pose_ = step.match.T_map_robot;
  } else if (motion) {
    pose_ = pose_ * motion->T_previous_robot;
    predict(*motion);
  }
  if (!matched || poor_ > 0 || step.held) {
    habit_.forget();
  } else if (!slid_) {  // sliding is a correction, not a motion to go on with
    habit_.observe(between(previous, pose_), scan.time - last_time_, !step.searched);
  }
  last_time_ = scan.time;
  step.T_map_robot = pose_;

  const Pose2 since_key = between(last_key_, pose_);
  step.key =
      points.size() >= 10 && !step.held &&
      (!started_ || step.broken || std::hypot(since_key.x, since_key.y) > options_.key_distance ||
       std::abs(since_key.theta) > options_.key_turn);
  if (step.key) {
    step.key_points = match::scan_points(scan, options_.points, true, directions_);
    step.local_map = active_keys_ > 0 ? active_first_ : keys_;
    step.T_key_predicted = std::exchange(T_key_predicted_, Pose2{});
    step.predicted_variance = std::exchange(predicted_variance_, Vec3::Zero());
    insert(step.key_points, pose_);
    last_key_ = pose_;
    started_ = true;
  }
  return step;
}

void FrontEnd::follow(const match::ScanPoints& points, const MotionPrior& prior, bool gap,
                      FrontEndStep& step) {
  const Pose2 predicted = pose_ * prior.T_previous_robot;
  step.match = track(points, prior);
  const bool doubted = !prior.habit && doubt(prior, step.match);
  const match::ScanPoints rest = doubted ? match::without_lone_things(points) : match::ScanPoints{};
  const bool walk = doubted && things_walk(rest, prior, step.match);
  step.searched = step.match.score < options_.trusted_score;
  if (step.searched) {
    const match::Match found = recover(walk ? rest : points, step.match, prior, gap);
    const bool crowded = doubted && static_cast<double>(points.size() - rest.size()) >
                                        kCrowd * static_cast<double>(points.size());
    const int witnesses = (crowded ? kCrowdedWitnesses : 1) * options_.witnesses;
    step.held =
        !gap && against_wheels(prior, found.T_map_robot, crowded) && told(prior, found) < witnesses;
    if (!step.held) step.match = found;
  }
  if (!step.held) told_ = 0;
  // What was found far off the prediction must fit well, or it is another place that looks alike.
  const Pose2 off = between(predicted, step.match.T_map_robot);
  const bool far = off.translation().norm() > options_.search_translation ||
                   std::abs(off.theta) > options_.search_rotation;
  const bool poor = step.match.score < (far ? options_.trusted_score : options_.weak_score);
  if (!step.held) poor_ = poor ? poor_ + 1 : 0;
  step.broken = poor && !step.held && (gap || poor_ >= options_.patience);
  if (step.broken) begin_again();
  // A scan that fits nowhere tells nothing: the wheels do, or the robot is taken to stand still.
  if ((poor_ > 0 || step.held) && step.match.score < 0.5 * options_.weak_score)
    step.match.T_map_robot = prior.habit ? pose_ : predicted;
}

bool FrontEnd::doubt(const MotionPrior& motion, const match::Match& match) const {
  const Pose2 off = between(pose_ * motion.T_previous_robot, match.T_map_robot);
  return match.score < options_.trusted_score ||
         off.translation().norm() > kDoubt * motion.sigma_translation;
}

// People who walk along with the robot would take it with them where walls tell little, and hide
// walls. So where the wheels and all of the scan disagree, what does not stand alone decides.
bool FrontEnd::things_walk(const match::ScanPoints& rest, const MotionPrior& motion,
                           match::Match& match) {
  if (rest.size() < 10) return false;
  const match::Match without = track(rest, motion);
  const double apart = (without.T_map_robot.translation() - match.T_map_robot.translation()).norm();
  if (apart < kWalked && match.score >= options_.trusted_score) return false;
  if (without.score < match.score && doubt(motion, without)) return false;
  match = without;
  return true;
}

// In a direction in which the laser knows less than the wheels, a better fit tells nothing: along
// an empty corridor a scan fits best where the map's returns lie closest.
bool FrontEnd::slides_off(const MotionPrior& motion, const match::Match& found) const {
  if (motion.habit) return false;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes;
  axes.computeDirect(found.information.topLeftCorner<2, 2>());
  const double sigma = motion.sigma_translation;
  const Vec2 off =
      found.T_map_robot.translation() - (pose_ * motion.T_previous_robot).translation();
  return axes.eigenvalues()(0) < 1 / (sigma * sigma) &&
         std::abs(axes.eigenvectors().col(0).dot(off)) > kAgainst * sigma;
}

bool FrontEnd::against_wheels(const MotionPrior& motion, const Pose2& T_map_robot,
                              bool crowded) const {
  if (motion.habit) return false;
  const double share = crowded ? 0.5 : 1;
  const Pose2 off = between(pose_ * motion.T_previous_robot, T_map_robot);
  return off.translation().norm() >
             std::max(kAgainst * motion.sigma_translation, share * kSlip.first) ||
         std::abs(off.theta) > std::max(kAgainst * motion.sigma_rotation, share * kSlip.second);
}

// A person before the laser makes another place look alike for a scan or two; that the wheels slip
// or someone carries the robot goes on being seen. So the next scans must tell the same.
int FrontEnd::told(const MotionPrior& motion, const match::Match& found) {
  const Pose2 off = between(rumour_ * motion.T_previous_robot, found.T_map_robot);
  const bool same = told_ > 0 && off.translation().norm() < 0.15 && std::abs(off.theta) < 0.15;
  told_ = same ? told_ + 1 : 1;
  rumour_ = found.T_map_robot;
  return told_;
}

MotionPrior FrontEnd::habit(Time now) const {
  const motion::Habit::Prediction p = habit_.predict(now - last_time_);
  return {p.T_previous_robot, p.sigma_translation, p.sigma_rotation, true};
}

void FrontEnd::predict(const MotionPrior& motion) {
  T_key_predicted_ = T_key_predicted_ * motion.T_previous_robot;
  const Vec3 sigma(motion.sigma_translation, motion.sigma_translation, motion.sigma_rotation);
  if (motion.habit) {
    predicted_variance_ = (predicted_variance_.cwiseSqrt() + sigma).cwiseAbs2();
  } else {
    predicted_variance_ += sigma.cwiseAbs2();
  }
}

match::Match FrontEnd::track(const match::ScanPoints& points, const MotionPrior& motion) {
  match::PosePrior prior;
  prior.T_map_robot = pose_ * motion.T_previous_robot;
  prior.information = (motion.habit ? kHabit : 1.0) * information_of(motion);
  const match::Match match = match::align(points, active_, prior, options_.align);
  slid_ = false;
  return motion.habit ? slide(points, match) : match;
}

// Along a corridor few returns tell how far the robot came: a niche's side, the end wall. Once they
// are out of the gate nothing pulls back, and the match still looks well. So where a direction is
// weak and returns are left over, the pose is slid along it to where more of them meet surfaces
// across it.
match::Match FrontEnd::slide(const match::ScanPoints& points, const match::Match& tracked) {
  const int left_over = static_cast<int>(points.size()) - tracked.inliers;
  if (left_over < kSlideGain) return tracked;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes;
  axes.computeDirect(tracked.information.topLeftCorner<2, 2>());
  if (axes.eigenvalues()(0) > kSlideWeak * axes.eigenvalues()(1)) return tracked;
  const Vec2 weak = axes.eigenvectors().col(0);
  const auto slid_by = [&](double way) {
    return Pose2{tracked.T_map_robot.x + way * weak.x(), tracked.T_map_robot.y + way * weak.y(),
                 tracked.T_map_robot.theta};
  };
  int most =
      match::count_across(points, active_, tracked.T_map_robot, weak, kSlideGate) + kSlideGain - 1;
  double best = 0;
  for (double way = kSlideStep; way <= kSlideReach; way += kSlideStep)
    for (const double signed_way : {way, -way}) {
      const int count = match::count_across(points, active_, slid_by(signed_way), weak, kSlideGate);
      if (count > most) most = count, best = signed_way;
    }
  if (best == 0) return tracked;
  match::PosePrior prior{slid_by(best), Mat3::Zero()};
  prior.information.diagonal() << 400, 400, 400;
  const match::Match slid = match::align(points, active_, prior, options_.align);
  const double gain = slid.inliers - tracked.inliers;
  slid_ = gain >= kSlideGain && gain >= kSlideShare * left_over;
  return slid_ ? slid : tracked;
}

match::Match FrontEnd::recover(const match::ScanPoints& points, match::Match tracked,
                               const MotionPrior& motion, bool gap) {
  tracked = search_window(points, tracked, motion,
                          {options_.search_translation, options_.search_rotation});
  if (tracked.score >= options_.weak_score) return tracked;
  return search_window(points, tracked, motion,
                       {options_.wide_translation, gap ? kPi : options_.wide_rotation});
}

match::Match FrontEnd::search_window(const match::ScanPoints& points, const match::Match& tracked,
                                     const MotionPrior& motion, const match::SearchWindow& window) {
  const match::LikelihoodPyramid pyramid(active_, pose_.translation(),
                                         {.max_translation = window.translation});
  const auto found = match::search(points, pyramid, pose_ * motion.T_previous_robot, window,
                                   match::likelihood(points, pyramid, tracked.T_map_robot) + 0.02);
  if (!found) return tracked;
  match::PosePrior prior;
  prior.T_map_robot = found->T_map_robot;
  prior.information.diagonal() << 100, 100, 100;
  const match::Match refined = match::align(points, active_, prior, options_.align);
  const bool better = refined.score > tracked.score + 0.05;
  return better && !slides_off(motion, refined) ? refined : tracked;
}

void FrontEnd::begin_again() {
  active_.clear();
  next_.clear();
  active_keys_ = next_keys_ = 0;
  poor_ = 0;
}

void FrontEnd::insert(const match::ScanPoints& points, const Pose2& pose) {
  const std::size_t number = keys_++;
  if (active_keys_ == 0) active_first_ = number;
  if (next_keys_ == 0) next_first_ = number;
  match::add_to(active_, points, pose);
  if (++active_keys_ <= options_.local_map_keys) return;
  match::add_to(next_, points, pose);
  if (++next_keys_ < options_.local_map_keys) return;
  std::swap(active_, next_);
  active_keys_ = next_keys_;
  active_first_ = next_first_;
  next_.clear();
  next_keys_ = 0;
}

}  // namespace majak::slam
