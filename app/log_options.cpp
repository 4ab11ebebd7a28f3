// SPDX-License-Identifier: Apache-2.0
#include "app/log_options.hpp"

#include <CLI/CLI.hpp>
#include <vector>

#include "majak/core/angle.hpp"

namespace majak::app {

void add_log_options(CLI::App& command, io::SourceOptions& options) {
  command.add_option("--topic", options.topic,
                     "ROS recordings: the laser's topic, where there is more than one");
  command
      .add_option("--angle-step", options.angle_step,
                  "ROS recordings: degrees between beams, instead of what the messages say")
      ->check(CLI::Range(0.01, 10.0));
  command
      .add_option_function<std::vector<double>>(
          "--mounting",
          [&options](const std::vector<double>& m) {
            options.T_robot_laser = Pose2{m[0], m[1], radians(m[2])};
          },
          "where the laser stands on the robot: x y (m) and degrees, instead of what is said")
      ->expected(3);
  command.add_option("--gps", options.gps,
                     "another log whose satellite fixes belong to this one: NMEA sentences, say");
}

}  // namespace majak::app
