// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>
#include <map>
#include <cstdlib>
#include "majak/core/error.hpp"
#include "majak/eval/relations.hpp"
#include "majak/eval/ate_rpe.hpp"
#include "majak/io/source.hpp"
#include "majak/motion/drive_log.hpp"
#include "majak/slam/graph_slam.hpp"

using namespace majak;
struct M { double rt, rr, d10, r10, d50, r50; };
M measure(const Site& site, std::vector<Pose2> dr, size_t first, const std::vector<eval::Relation>& rel) {
  // dr: pose per scan
  std::map<Time,size_t> idx; for (size_t i=first;i<site.scans.size();++i) idx.emplace(site.scans[i].scan.time/10000, i);
  M m{}; double n=0;
  for (auto& r: rel) { auto find=[&](Time t){ auto it=idx.lower_bound(t/10000-1); return it!=idx.end() && std::abs(it->first - t/10000)<=1 ? long(it->second) : -1L; };
    long a=find(r.from), b=find(r.to); if (a<0||b<0) continue; Pose2 e=between(r.T_from_to, between(dr[a],dr[b])); m.rt+=e.translation().norm(); m.rr+=std::abs(e.theta); ++n; }
  m.rt/=n; m.rr/=n;
  for (double L : {10.0, 50.0}) { double st=0, sr=0; int c=0;
    std::vector<double> cum(site.scans.size(),0); for (size_t i=first+1;i<cum.size();++i) cum[i]=cum[i-1]+ (site.scans[i].estimate.T_map_robot.translation()-site.scans[i-1].estimate.T_map_robot.translation()).norm();
    size_t j=first; for (size_t i=first;i<cum.size();i+=5) { while(j<cum.size() && cum[j]-cum[i]<L) ++j; if (j>=cum.size()) break;
      Pose2 e=between(between(site.scans[i].estimate.T_map_robot,site.scans[j].estimate.T_map_robot), between(dr[i],dr[j])); st+=e.translation().norm()/L; sr+=std::abs(degrees(e.theta))/L; ++c; }
    (L<20?m.d10:m.d50)=st/c; (L<20?m.r10:m.r50)=sr/c; }
  fmt::print("{} relations {:.3f} m {:.2f} deg | 10 m: {:.2f} % {:.3f} deg/m | 50 m: {:.2f} % {:.3f} deg/m\n", n, m.rt, degrees(m.rr), 100*m.d10, m.r10, 100*m.d50, m.r50);
  return m;
}
int main(int argc, char** argv) {
  std::string f = argv[1];
  motion::DriveLog log; slam::GraphSlam slam({}, {2});
  auto src = io::open_log("/work/shared/data/freiburg/"+f+".clf.bz2");
  while (auto e = src->next()) { log.add(*e); slam.add(std::move(*e)); }
  Site site = slam.finish();
  fmt::print("{} scans {} stream {}\n", f, site.scans.size(), log.stream.size());
  Report rep; auto rel = eval::read_relations("/work/shared/data/freiburg/"+f+".relations", rep);
  double mm=0; for (auto&r:rel) mm+=r.T_from_to.translation().norm(); fmt::print("mean relation length {:.2f}\n", mm/rel.size());
  if (argc>2) { FILE* o=fopen(argv[2],"w"); for (size_t i=0;i<site.scans.size();++i){ auto&p=site.scans[i]; auto&T=p.estimate.T_map_robot; auto&q=log.records[i]; fmt::print(o,"{} {} {} {} {} {} {} {} {}\n", p.scan.time*1e-9, q.T_odom_robot.x,q.T_odom_robot.y,q.T_odom_robot.theta, T.x,T.y,T.theta, int(p.estimate.health), q.speed.value_or(0)); } fclose(o);}
  const size_t half = site.scans.size()/2;
  auto show=[&](const motion::LogCalibration& c){ fmt::print("{} steps {} out {} nis {:.2f} ll/step {:.3f} way {:.0f} turned {:.0f}\n", motion::name_of(c.source), c.calibration.steps, c.calibration.left_out, c.calibration.mean_nis, c.calibration.log_likelihood/c.calibration.steps, c.calibration.way, c.calibration.turned);
    const char* names[]={"scale","turn_scale","uneven","x","y","theta","lag"}; for(int k=0;k<7;++k) fmt::print("  {} {:.4f} +- {:.4f} {}\n", names[k], c.calibration.values[k].value, c.calibration.values[k].sigma, c.calibration.values[k].used);
    auto&n=c.calibration.noise; fmt::print("  noise {:.4f} {:.4f} | {:.4f} {:.4f} {:.4f} {:.4f} jitter {:.4f}\n", n.laser_translation,n.laser_rotation,n.ahead,n.aside,n.turn_of_way,n.turn_of_turn,n.jitter); };
  auto path=[&](const motion::DriveCorrection& c, motion::WheelSource s, bool place){ auto p = motion::WheelPath(motion::samples_of(log,s,c.reversed,0), c); auto t=motion::scan_times(site,s); std::vector<Pose2> out; Pose2 last;
    Pose2 D = place&&c.mounting ? Pose2{c.laser_x,c.laser_y,c.laser_theta}*site.scans.front().scan.T_robot_laser.inverse() : Pose2{};
    for (auto x: t) { if (auto q=p.at(x)) last=q->pose; out.push_back(last*D);} return out; };
  motion::DriveCorrection raw; 
  fmt::print("RAW 2nd half\n"); const M r=measure(site, path(raw, motion::WheelSource::ordered,false), half, rel);
  std::vector<Pose2> est; for (auto&s:site.scans) est.push_back(s.estimate.T_map_robot); fmt::print("SLAM\n"); measure(site, est, half, rel);
  raw.reversed = site.odometry.reversed_records>0; fmt::print("RAW reversed mended\n"); measure(site, path(raw, motion::WheelSource::ordered,false), half, rel);
  for (int h=0; h<3; ++h) { motion::LogCalibrationOptions o; if (h==0) o.last=half; if (h==1) o.first=half;
    auto c = motion::calibrate_log(log, site, o); fmt::print("== {}\n", h==0?"first half":h==1?"second half (cheat)":"whole"); show(c);
    const M m=measure(site, path(c.calibration.correction, c.source,true), half, rel); fmt::print("ratios {:.2f} {:.2f} {:.2f} {:.2f}\n", r.rt/m.rt, r.d10/m.d10, r.d50/m.d50, r.r50/m.r50); }
}
