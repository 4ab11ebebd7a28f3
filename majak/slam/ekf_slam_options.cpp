// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/ekf_slam.hpp"

namespace majak::slam {

void describe(OptionFields& f, EkfSlamOptions& o) {
  describe(f, o.trunks);
  f.add("ekf_slam.see_corners", o.see_corners, {"", "corners of walls are landmarks, too"});
  f.add("corners.wall_sigma", o.corners.wall_sigma,
        {"m", "by which a wall is no straight line", 0, 1});
  describe(f, o.association);
  f.add("ekf_slam.way_noise", o.wheels.way_noise, {"m/sqrt(m)", "wheels, along the way", 0, 10});
  f.add("ekf_slam.side_noise", o.wheels.side_noise, {"m/sqrt(m)", "wheels, across the way", 0, 10});
  f.add("ekf_slam.turn_noise", o.wheels.turn_noise,
        {"rad/sqrt(m)", "wheels, heading by way", 0, 10});
  f.add("ekf_slam.spin_noise", o.wheels.spin_noise,
        {"rad/sqrt(rad)", "wheels, heading by turn", 0, 10});
  f.add("ekf_slam.wheelbase", o.wheelbase, {"m", "of a car", 0.01, 100});
  f.add("ekf_slam.idle_noise", o.idle_noise,
        {"m/sqrt(s)", "until the wheels tell something; rad, too", 0, 100});
  f.add("ekf_slam.scale_sigma", o.scale_sigma, {"1", "how wrong the way may be counted", 0, 1});
  f.add("ekf_slam.turn_scale_sigma", o.turn_scale_sigma,
        {"1", "how wrong turns or steering may be counted", 0, 1});
  f.add("ekf_slam.turn_offset_sigma", o.turn_offset_sigma,
        {"rad/m", "how much straight ahead may turn", 0, 1});
  f.add("ekf_slam.steering_curve_sigma", o.steering_curve_sigma,
        {"1/rad^2", "of the cube of the angle in what a car steers", 0, 10});
  f.add("ekf_slam.steering_square_sigma", o.steering_square_sigma,
        {"1/rad", "of its square", 0, 10});
  f.add("ekf_slam.crab_sigma", o.crab_sigma,
        {"rad", "between the laser's and the axle's direction", 0, 1});
  f.add("ekf_slam.crab_wander", o.crab_wander,
        {"rad/sqrt(m)", "how that changes with the ground", 0, 1});
  f.add("ekf_slam.lag_sigma", o.lag_sigma, {"s", "of the wheels behind the laser", 0, 1});
  f.add("ekf_slam.mirror_turn", o.mirror_turn, {"s", "of the laser's mirror, 0: none", 0, 1});
  f.add("ekf_slam.point_sigma", o.point_sigma,
        {"m", "by which a landmark is not the same from scan to scan", 0, 10});
  f.add("ekf_slam.alike_sigma", o.alike_sigma,
        {"m", "by which all its sightings err alike that are made on ...", 0, 10});
  f.add("ekf_slam.alike_way", o.alike_way, {"m", "... so much way", 0, 1000});
  f.add("ekf_slam.diameter_sigma", o.diameter_sigma,
        {"m", "by which its diameter is not", 0.001, 10});
  f.add("ekf_slam.apart", o.apart,
        {"1", "probability with which a new landmark is none of the others", 0.5, 0.999999});
  f.add("ekf_slam.least_apart", o.least_apart, {"m", "nor nearer than this to any", 0, 100});
  f.add("ekf_slam.recent", o.recent,
        {"s", "after which a landmark seen again is doubted at first", 0, 1e6});
  f.add("ekf_slam.witnesses", o.witnesses,
        {"1", "of these in a scan, or scans in a row, that are enough", 1, 1000});
  f.add("ekf_slam.confirmed", o.confirmed,
        {"1", "sightings before it is more than a guess", 1, 1000});
  f.add("ekf_slam.stands", o.stands, {"s", "for which it stands in one place until then", 0, 1e6});
  f.add("ekf_slam.guess_gate", o.guess_gate, {"m", "between these", 0.01, 10});
  f.add("ekf_slam.gone", o.gone, {"1", "scans that look through it before it is given up", 1, 1e6});
  f.add("ekf_slam.near", o.near, {"m", "what is kept up to date", 10, 1e6});
  f.add("ekf_slam.look_around", o.look_around, {"m", "driven between two looks around", 0, 1e6});
  f.add("ekf_slam.blind", o.blind,
        {"m", "driven without a landmark before the pose is called degraded", 0, 1e6});
  f.add("ekf_slam.sure", o.sure, {"m", "sigma of a position that is not", 0, 1e6});
  f.add("ekf_slam.misfits", o.misfits,
        {"1", "scans without those landmarks that there should be, before it is lost", 1, 1e6});
  f.add("ekf_slam.mistrusted_noise", o.mistrusted_noise,
        {"m/sqrt(s)", "of wheels that the landmarks contradict; rad, too", 0, 100});
  f.add("ekf_slam.mistrust", o.mistrust, {"s", "for which they are taken to err", 0, 1e6});
  f.add("ekf_slam.stuck", o.stuck, {"m", "with the same steering before it may be stuck", 0, 1e6});
  f.add("ekf_slam.use_gps", o.use_gps, {"", "satellite fixes correct the path, too"});
  f.add("ekf_slam.gps_sigma", o.gps_sigma, {"m", "of what errs alike in a piece", 0.001, 1000});
  f.add("ekf_slam.gps_fast_sigma", o.gps_fast_sigma, {"m", "from fix to fix", 0.001, 1000});
  f.add("ekf_slam.gps_memory", o.gps_memory, {"s", "of what errs alike", 0.1, 1e6});
  f.add("ekf_slam.antenna_sigma", o.antenna_sigma, {"m", "how far off the robot's point", 0, 100});
  f.add("ekf_slam.gps_gate", o.gps_gate, {"1", "NIS beyond which a fix is believed less", 1, 1e9});
  f.add("ekf_slam.gps_refused", o.gps_refused,
        {"1", "NIS beyond which it is not believed at all ...", 1, 1e9});
  f.add("ekf_slam.gps_patience", o.gps_patience, {"s", "... unless all are for so long", 0, 1e9});
  f.add("ekf_slam.find_heading", o.find_heading,
        {"m", "driven before fixes tell the heading", 0.1, 1e4});
}

}  // namespace majak::slam
