// SPDX-License-Identifier: Apache-2.0
#include "app/robot_view.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/live.hpp"
#include "majak/core/error.hpp"
#include "majak/localize/scan_feed.hpp"
#include "majak/map/contours.hpp"
#include "majak/methods/methods.hpp"
#include "majak/sim/tour.hpp"

namespace majak::app {
namespace {

constexpr double kStartSigma = 0.5, kStartTurn = 0.3;  // m, rad, of a start set by hand
constexpr Duration kBetweenTruths = kSecond / 2;

sim::Scene scene_of(const map::KnownMap& known) {
  sim::Scene scene;
  scene.name = "map";
  for (const map::Segment& s : map::contour_segments(known)) scene.segments.push_back({s.a, s.b});
  return scene;
}

std::string hypotheses_json(const std::vector<localize::Hypothesis>& hypotheses) {
  nlohmann::json list = nlohmann::json::array();
  for (const localize::Hypothesis& h : hypotheses) {
    const Pose2& p = h.T_map_robot;
    const Mat3& c = h.covariance;
    list.push_back({{"pose", {p.x, p.y, p.theta}},
                    {"covariance", {c(0, 0), c(0, 1), c(0, 2), c(1, 1), c(1, 2), c(2, 2)}},
                    {"weight", h.probability}});
  }
  return list.dump();
}

}  // namespace

RobotView::RobotView(Viewer& viewer, const Site& site, const map::OccupancyGrid& grid,
                     const std::string& method)
    : viewer_(viewer),
      method_name_(method),
      place_(localize::place_of(site)),
      scene_(scene_of(map::known_map(grid))),
      T_robot_laser_(site.scans.front().scan.T_robot_laser),
      first_scan_(site.scans.size()) {
  if (!methods::method(method).on_map)
    throw Error("the method " + method + " does not work on a map");
  for (const PosedScan& posed : site.scans) time_ = std::max(time_, posed.scan.time);
  for (std::size_t i = site.scans.size(); !simulator_; i -= std::min<std::size_t>(i, 50)) {
    if (i == 0) throw Error("nowhere in this map can a robot drive");
    try {  // the end of a run may be too near to a wall
      set_simulator(site.scans[i - 1].estimate.T_map_robot);
    } catch (const Error&) {
    }
  }
  set_method({});
}

RobotView::~RobotView() {
  stopped_ = true;
  if (driver_.joinable()) driver_.join();
}

void RobotView::start() {
  driver_ = std::thread([this] {
    try {
      drive();
    } catch (const std::exception& e) {  // the robot stands still, and the page says why
      const nlohmann::json status{{"activity", std::string("the robot stopped: ") + e.what()}};
      viewer_.hub().set("/status", io::view_json(io::ViewTopic::status, status.dump()));
    }
  });
}

void RobotView::start_at(const Pose2& T_map_robot) {
  const std::lock_guard lock(mutex_);
  set_method(T_map_robot);
}

void RobotView::kidnap(const Pose2& T_map_robot) {
  const std::lock_guard lock(mutex_);
  set_simulator(T_map_robot);
}

void RobotView::set_method(std::optional<Pose2> start) {
  cloud_ = nullptr;
  if (method_name_ == "monte-carlo") return set_monte_carlo(start);
  methods::LocalizeOptions options;
  options.place = place_;
  if (start) options.start = *start;
  const localize::Localizer localizer = methods::method(method_name_).make(options);
  method_ = [localizer](const Event& event) { return localizer.add(event); };
}

// The filter itself, so that its particles can be seen.
void RobotView::set_monte_carlo(std::optional<Pose2> start) {
  localize::MonteCarloOptions options;
  if (start) options.start_sigma = kStartSigma, options.start_turn = kStartTurn;
  cloud_ = std::make_shared<localize::MonteCarlo>(place_, options, start.value_or(Pose2{}));
  const auto feed = std::make_shared<localize::ScanFeed>();
  method_ = [cloud = cloud_, feed](const Event& event) {
    feed->add(event);
    std::optional<Estimate> newest;
    while (const auto scan = feed->next()) newest = cloud->add(*scan);
    return newest;
  };
}

void RobotView::set_simulator(const Pose2& T_map_robot) {
  sim::Scene scene = scene_;
  scene.start = T_map_robot;
  auto world = std::make_unique<sim::World>(std::move(scene));
  sim::SimulationOptions options;
  options.seed = 1 + static_cast<int>(scans_);
  options.mounting_x = T_robot_laser_.x;
  options.mounting_y = T_robot_laser_.y;
  options.mounting_theta = T_robot_laser_.theta;
  options.start_time = to_seconds(time_) + 1;
  auto simulator = std::make_unique<sim::Simulator>(*world, sim::plan_tour(*world), options);
  simulator_ = std::move(simulator);
  world_ = std::move(world);
  T_odom_begin_ = T_odom_robot_;
}

void RobotView::drive() {
  const auto began = std::chrono::steady_clock::now();
  const Time first = time_;
  while (!stopped_) {
    std::unique_lock lock(mutex_);
    auto event = simulator_->next();
    if (!event) {  // round again
      set_simulator(truth_.poses.back());
      continue;
    }
    time_ = std::max(time_, time_of(*event));
    take(std::move(*event));
    lock.unlock();
    // What has taken too long is not made up for.
    std::this_thread::sleep_until(began + std::chrono::nanoseconds(time_ - first));
  }
}

void RobotView::take(Event event) {
  if (auto* odometry = std::get_if<Odometry>(&event)) {
    odometry->T_odom_robot = T_odom_robot_ = T_odom_begin_ * odometry->T_odom_robot;
  } else if (const auto* truth = std::get_if<Truth>(&event)) {
    truth_.stamps.push_back(truth->time);
    truth_.poses.push_back(truth->T_world_robot);
    return;
  }
  if (auto* scan = std::get_if<Scan>(&event); scan && scan->T_odom_robot)
    scan->T_odom_robot = T_odom_begin_ * *scan->T_odom_robot;
  const std::optional<Estimate> estimate = method_(event);
  if (const auto* scan = std::get_if<Scan>(&event)) waiting_.push_back(*scan);
  if (!estimate) return;
  while (!waiting_.empty() && waiting_.front().time < estimate->time) waiting_.pop_front();
  if (!waiting_.empty()) tell(waiting_.front(), *estimate);
}

void RobotView::tell(const Scan& scan, const Estimate& estimate) {
  const std::size_t number = first_scan_ + scans_++;
  io::ViewedPose view;
  view.scan = view.key = number;
  view.estimate = estimate;
  view.estimate.time = scan.time;
  if (cloud_) view.particles = static_cast<std::uint32_t>(cloud_->weights().size());
  serve::Hub& hub = viewer_.hub();
  hub.append(io::view_estimate(view));
  hub.set("/scan", io::view_scan(number, scan, 0), serve::kInOrder);
  if (cloud_) tell_cloud(scan.time);
  const Time now = live_clock();
  if (now - truth_told_ < kBetweenTruths) return;
  truth_told_ = now;
  hub.set("/truth", io::view_truth(truth_));
}

void RobotView::tell_cloud(Time time) {
  const auto& all = cloud_->poses();
  std::vector<Pose2> poses;
  poses.reserve(all.size());
  for (std::size_t i = 0; i < all.size(); ++i)
    poses.push_back({all.x[i], all.y[i], std::atan2(all.sin[i], all.cos[i])});
  const std::vector<float> weights(cloud_->weights().begin(), cloud_->weights().end());
  viewer_.hub().set("/particles", io::view_particles(time, poses, weights));
  viewer_.hub().set("/hypotheses",
                    io::view_json(io::ViewTopic::hypotheses, hypotheses_json(cloud_->clusters())));
}

}  // namespace majak::app
