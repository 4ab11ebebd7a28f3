// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/landmark_graph.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "majak/graph/marginals.hpp"
#include "majak/graph/optimize.hpp"

namespace majak::slam {
namespace {

constexpr int kAntenna = MotionInput::kNumbers;
constexpr double kUpright = 1e6;   // information of a heading that is none
constexpr double kAny = 1e-6;      // of one that does not matter
constexpr double kSettled = 5e-3;  // m that the last round moved the farthest pose

Mat3 of_place(const Eigen::Matrix2d& information, double heading) {
  Mat3 m = Mat3::Zero();
  m.topLeftCorner<2, 2>() = information;
  m(2, 2) = heading;
  return m;
}

// Nodes: the poses at the scans, the landmarks, and with fixes the earth, how each piece of fixes
// errs, and where the antenna was at each fix. Places are poses whose heading nothing depends on.
class Problem {
 public:
  Problem(LandmarkMap& map, WheelNumbers& wheels, const EkfSlamOptions& ekf,
          const LandmarkGraphOptions& options)
      : map_(map), wheels_(wheels), ekf_(ekf), options_(options) {}

  // Poses by the graph, and what the wheels count wrongly with them. The antenna stays where the
  // filter found it.
  void solve() {
    build();
    graph::Optimizer optimizer(
        {.max_iterations = 30, .start = graph::Start::given, .robust = graph::Robust::cauchy});
    for (int k = 0; k < options_.rounds; ++k) {
      const std::vector<Pose2> before = graph_.poses;
      set_measurements();
      summary_ = optimizer.optimize(graph_);
      wheels_.learn(graph_, graph::Marginals(graph_, summary_.edge_weight));
      double moved = 0;
      for (std::size_t i = 0; i < before.size(); ++i)
        moved = std::max(moved, (before[i].translation() - graph_.poses[i].translation()).norm());
      if (moved < kSettled) break;
    }
    store();
  }

 private:
  std::size_t scans() const { return map_.localization.estimates.size(); }
  int landmark_node(int landmark) const { return static_cast<int>(scans()) + landmark; }

  int place(const Vec2& p) {
    graph_.poses.push_back({p.x(), p.y(), 0});
    return static_cast<int>(graph_.poses.size()) - 1;
  }

  void build() {
    for (const Estimate& e : map_.localization.estimates) graph_.poses.push_back(e.T_map_robot);
    for (const MappedLandmark& l : map_.landmarks) place(l.p_map);
    for (std::size_t k = 1; k < scans(); ++k) {
      Mat3 noise = map_.steps[k].noise;
      noise.diagonal().array() += 1e-8;  // the car stands still
      graph_.edges.push_back(
          {static_cast<int>(k - 1), static_cast<int>(k), {}, noise.inverse(), false});
    }
    for (const LandmarkObservation& o : map_.observations)
      graph_.edges.push_back({static_cast<int>(o.scan),
                              landmark_node(o.landmark),
                              {o.q_robot.x(), o.q_robot.y(), 0},
                              of_place(o.noise.inverse(), kAny),
                              true});
    build_fixes();
  }

  void build_fixes() {
    if (map_.fixes.empty()) return;
    const double slow = 1 / (ekf_.gps_sigma * ekf_.gps_sigma);
    const double fast = 1 / (ekf_.gps_fast_sigma * ekf_.gps_fast_sigma);
    const int earth = graph_.fixed = place(Vec2::Zero());
    std::map<std::size_t, int> pieces;
    for (const FixObservation& f : map_.fixes) {
      auto [piece, fresh] = pieces.try_emplace(f.piece, 0);
      if (fresh) {
        piece->second = place(Vec2::Zero());
        graph_.edges.push_back({earth,
                                piece->second,
                                {},
                                of_place(slow * Eigen::Matrix2d::Identity(), kUpright),
                                true});
      }
      const int antenna = place(f.z);
      graph_.edges.push_back({piece->second,
                              antenna,
                              {f.z.x(), f.z.y(), 0},
                              of_place(fast * Eigen::Matrix2d::Identity(), kUpright),
                              false});
      antenna_edges_.push_back(graph_.edges.size());
      graph_.edges.push_back({static_cast<int>(f.scan),
                              antenna,
                              {},
                              of_place(1e4 * Eigen::Matrix2d::Identity(), kAny),
                              false});
    }
  }

  // With the numbers as learnt so far.
  void set_measurements() {
    for (std::size_t k = 1; k < scans(); ++k) graph_.edges[k - 1].T_from_to = wheels_.step(k);
    const Vec2 antenna = map_.numbers.segment<2>(kAntenna);
    for (std::size_t i = 0; i < antenna_edges_.size(); ++i) {
      const Vec2 a = map_.fixes[i].T_scan_robot * antenna;
      graph_.edges[antenna_edges_[i]].T_from_to = {a.x(), a.y(), 0};
    }
  }

  void store() {
    const graph::Marginals marginals(graph_, summary_.edge_weight);
    for (std::size_t k = 0; k < scans(); ++k) {
      Estimate& e = map_.localization.estimates[k];
      e.T_map_robot = graph_.poses[k];
      e.covariance = marginals.covariance(static_cast<int>(k));
      tell_health(e);
    }
    for (std::size_t i = 0; i < map_.landmarks.size(); ++i) {
      const int node = landmark_node(static_cast<int>(i));
      map_.landmarks[i].p_map = graph_.poses[static_cast<std::size_t>(node)].translation();
      map_.landmarks[i].covariance = marginals.covariance(node).topLeftCorner<2, 2>();
    }
  }

  // What the filter doubted for the moment, what came later may have settled. Where it was lost,
  // what it took for landmarks is not to be trusted.
  void tell_health(Estimate& e) const {
    if (e.health == Health::lost) return;
    e.health = Health::ok;
    e.weak_direction = Vec2::Zero();
    if (least_known(e.covariance).sigma > ekf_.sure) degrade(e);
  }

  LandmarkMap& map_;
  WheelNumbers& wheels_;
  const EkfSlamOptions& ekf_;
  const LandmarkGraphOptions& options_;
  graph::PoseGraph graph_;
  graph::Summary summary_;
  std::vector<std::size_t> antenna_edges_;
};

// Landmarks that stand in one place are one. True where any were found.
bool merge(LandmarkMap& map, const LandmarkGraphOptions& options) {
  const std::size_t n = map.landmarks.size();
  std::vector<int> now(n);
  std::vector<MappedLandmark> kept;
  for (std::size_t i = 0; i < n; ++i) {
    const MappedLandmark& l = map.landmarks[i];
    now[i] = -1;
    for (std::size_t k = 0; k < kept.size() && now[i] < 0; ++k) {
      const Vec2 off = l.p_map - kept[k].p_map;
      if (off.norm() < options.merge_distance) now[i] = static_cast<int>(k);
    }
    if (now[i] < 0) {
      now[i] = static_cast<int>(kept.size());
      kept.push_back(l);
    } else {
      MappedLandmark& k = kept[static_cast<std::size_t>(now[i])];
      const double share = static_cast<double>(l.sightings) / (l.sightings + k.sightings);
      k.p_map += share * (l.p_map - k.p_map);
      k.diameter += share * (l.diameter - k.diameter);
      k.sightings += l.sightings;
    }
  }
  for (LandmarkObservation& o : map.observations)
    o.landmark = now[static_cast<std::size_t>(o.landmark)];
  map.landmarks = std::move(kept);
  return map.landmarks.size() < n;
}

WheelNumbers::Numbers sigmas(const EkfSlamOptions& ekf) {
  WheelNumbers::Numbers sigma;
  sigma << ekf.scale_sigma, ekf.turn_scale_sigma, ekf.turn_offset_sigma, ekf.steering_curve_sigma,
      ekf.steering_square_sigma, ekf.crab_sigma, ekf.lag_sigma;
  return sigma;
}

// The filter told the numbers in this order, before all others.
void tell(const WheelNumbers& wheels, LandmarkMap& map) {
  map.numbers.head<MotionInput::kNumbers>() = wheels.numbers();
  auto& learnt = map.localization.learnt;
  for (std::size_t i = 0; i < std::min<std::size_t>(learnt.size(), MotionInput::kNumbers); ++i) {
    learnt[i].value = wheels.numbers()(static_cast<Eigen::Index>(i));
    learnt[i].sigma = wheels.sigmas()(static_cast<Eigen::Index>(i));
  }
}

}  // namespace

LandmarkMap optimize_landmarks(LandmarkMap seen, const EkfSlamOptions& ekf,
                               const LandmarkGraphOptions& options) {
  if (seen.localization.estimates.empty()) return seen;
  WheelNumbers wheels(seen.steps, seen.numbers.head<MotionInput::kNumbers>(), sigmas(ekf),
                      options.ground);
  do {
    Problem(seen, wheels, ekf, options).solve();
  } while (merge(seen, options));
  tell(wheels, seen);
  return seen;
}

localize::Localizer landmark_graph(const EkfSlamOptions& ekf, const LandmarkGraphOptions& options,
                                   const Pose2& start) {
  const auto method = std::make_shared<EkfSlam>(ekf, start);
  return {[method](const Event& event) { return method->add(event); },
          [method, ekf, options] {
            return optimize_landmarks(method->finish(), ekf, options).localization;
          }};
}

void describe(OptionFields& f, LandmarkGraphOptions& o) {
  f.add("landmark_graph.ground_crab", o.ground.crab,
        {"rad", "by which the direction of driving comes and goes with the ground", 0, 1});
  f.add("landmark_graph.ground_memory", o.ground.memory,
        {"m", "driven, after which it has changed", 0.1, 1e6});
  f.add("landmark_graph.ground_knots", o.ground.knot_way,
        {"m", "driven between two values of it", 0.1, 1e6});
  f.add("landmark_graph.rounds", o.rounds,
        {"1", "of learning what the wheels count wrongly", 1, 1000});
  f.add("landmark_graph.merge_distance", o.merge_distance,
        {"m", "between landmarks that are one", 0, 100});
}

}  // namespace majak::slam
