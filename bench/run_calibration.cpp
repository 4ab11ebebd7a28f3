// SPDX-License-Identifier: Apache-2.0
// scratch
#include <fmt/core.h>
#include <Eigen/LU>
#include <cstdlib>
#include <string>
#include "majak/core/random.hpp"
#include <vector>
#include "majak/core/error.hpp"
#include "majak/core/parallel.hpp"
#include "majak/eval/consistency.hpp"
#include "majak/motion/calibration.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/simulator.hpp"
#include "majak/slam/graph_slam.hpp"
using namespace majak;
struct Run { std::array<double,7> e, s; double nees, nis, wd, wds, len, lens; size_t steps, out; motion::StepNoise n; };
Run one(int seed, const std::string& w, double tn) {
  const sim::World world(sim::built_in(w));
  sim::SimulationOptions o;
  o.seed = seed; o.odometry_lag = 0.05;
  o.robot.left_scale = 0.995; o.robot.right_scale = 1.005; o.robot.track_scale = 1.02;
  o.robot.scale_sigma = o.robot.unequal_sigma = o.robot.track_sigma = 0;
  if (getenv("SLIP")) o.robot.slip=atof(getenv("SLIP")); if (getenv("ENC")) o.robot.encoder_step=atof(getenv("ENC")); if (getenv("RATE")) o.odometry_rate=atof(getenv("RATE"));  if (getenv("PERFECT")) o.laser.systematic_error=0;
  o.mounting_x = 0.1; o.mounting_y = 0;
  const Pose2 nominal{0.07, 0.03, radians(1.0)};
  slam::GraphSlam slam({}, {1});
  std::vector<Odometry> odo;
  for (Event& e : sim::simulate(world, sim::plan_tour(world, {.short_tour = true}), o)) {
    if (auto* s = std::get_if<Scan>(&e)) s->T_robot_laser = nominal;
    if (auto* d = std::get_if<Odometry>(&e)) odo.push_back(*d);
    slam.add(std::move(e));
  }
  Site site = slam.finish();
  const bool truth = tn >= 0;
  std::vector<motion::LaserPose> poses;
  RandomStream rnd(seed, 999);
  for (size_t i = 0; i < site.scans.size(); ++i) {
    auto& p = site.scans[i];
    Pose2 T = p.estimate.T_map_robot;
    if (truth) T = site.truth[i].T_world_robot * Pose2{0.1,0,0} * nominal.inverse() * Pose2{tn*rnd.normal(), tn*rnd.normal(), 0.5*tn*rnd.normal()};
    else if (p.estimate.health != Health::ok) continue;
    poses.push_back({p.scan.time + (truth ? 0 : kSecond/300), T});
  }
  auto wheels = motion::wheel_samples(odo, false);
  motion::CalibrationOptions co; if (getenv("LEAST")) co.least_way=co.least_turn=atof(getenv("LEAST")); co.track = 0.4*1.02; co.T_robot_laser = nominal; co.start_lag = site.odometry.lag_s.value;
  auto c = motion::calibrate(poses, wheels, co);
  const double rl = 1/0.995, rr = 1/1.005;
  const double t[7] = {(rl+rr)/2, (rl+rr)/2*1.02, (rr-rl)/0.4, 0.1, 0, 0, 0.05};
  Run r; Eigen::Matrix<double,7,1> e;
  for (int k=0;k<7;++k) { r.e[k]=e(k)=c.values[k].value-t[k]; r.s[k]=c.values[k].sigma; }
  r.nees = e.dot(c.covariance.inverse()*e); r.nis=c.mean_nis; r.steps=c.steps; r.out=c.left_out; r.n=c.noise;
  r.wd = c.wheel_difference.value - (rr-rl)/((rl+rr)/2); r.wds=c.wheel_difference.sigma; r.len=c.length.value-0.4; r.lens=c.length.sigma;
  return r;
}
int main(int argc, char** argv) {
  int n = argc>1?atoi(argv[1]):4; std::string w = argc>2?argv[2]:"building"; double tn = argc>3?atof(argv[3]):-1;
  std::vector<Run> runs(n);
  parallel_for({2}, n, [&](std::size_t i){ runs[i]=one((getenv("SEED")?atoi(getenv("SEED")):5001)+i,w,tn); });
  double nees=0; std::array<double,9> rms{}, mean{}, sig{};
  const bool quiet=getenv("Q"); for (auto& r: runs) { nees+=r.nees/n;
    if(!quiet) fmt::print("nees {:.2f} nis {:.2f} {}/{} noise {:.4f} {:.4f} {:.4f} {:.4f} {:.4f} {:.4f} j {:.4f} |", r.nees,r.nis,r.out,r.steps,r.n.laser_translation,r.n.laser_rotation,r.n.ahead,r.n.aside,r.n.turn_of_way,r.n.turn_of_turn,r.n.jitter);
    for(int k=0;k<7;++k) { if(!quiet) fmt::print(" {:.4f}/{:.4f}", r.e[k], r.s[k]); rms[k]+=r.e[k]*r.e[k]/r.s[k]/r.s[k]/n; mean[k]+=r.e[k]/n; sig[k]+=r.s[k]/n; }
    rms[7]+=r.wd*r.wd/r.wds/r.wds/n; mean[7]+=r.wd/n; sig[7]+=r.wds/n; rms[8]+=r.len*r.len/r.lens/r.lens/n; mean[8]+=r.len/n; sig[8]+=r.lens/n;
    if(!quiet) fmt::print("\n"); }
  fmt::print("NEES {:.2f} band {:.2f}..{:.2f}\n", nees, eval::chi_square_quantile(.025,7*n)/n, eval::chi_square_quantile(.975,7*n)/n);
  for (int k=0;k<9;++k) fmt::print("{} rms e/s {:.2f} mean {:.5f} sigma {:.5f}\n", k, std::sqrt(rms[k]), mean[k], sig[k]);
}
