// SPDX-License-Identifier: Apache-2.0
#include "majak/io/mcap_log_writer.hpp"

#include <cmath>
#include <utility>

#include "majak/io/recording.hpp"
#include "majak/io/ros_scan.hpp"

namespace majak::io {
namespace {

const char* const kTruthTopic = "/ground_truth";
constexpr std::size_t kLookAhead = 300;  // events without an odometry record

ros::Transform transform_of(const Pose2& pose) {
  ros::Transform t;
  t.translation = {pose.x, pose.y, 0};
  t.rotation = {0, 0, std::sin(0.5 * pose.theta), std::cos(0.5 * pose.theta)};
  return t;
}

std::string number_of(int laser) { return laser == 0 ? "" : std::to_string(laser + 1); }

}  // namespace

McapLogWriter::McapLogWriter(const std::string& path)
    : file_(path), writer_([this](std::string_view bytes) { file_.write(bytes); }) {}

std::uint16_t McapLogWriter::channel(const std::string& topic, const std::string& type,
                                     const std::string& definition) {
  const auto found = channels_.find(topic);
  if (found != channels_.end()) return found->second;
  return channels_[topic] = writer_.add_channel({.topic = topic,
                                                 .encoding = "cdr",
                                                 .schema = type,
                                                 .schema_encoding = "ros2msg",
                                                 .schema_text = definition,
                                                 .metadata = {}});
}

void McapLogWriter::write_scan(const Scan& scan) {
  const std::string frame = kLaserFrame + number_of(scan.laser);
  const auto mounting = mountings_.find(scan.laser);
  if (mounting == mountings_.end() || !(mounting->second == scan.T_robot_laser)) {
    mountings_[scan.laser] = scan.T_robot_laser;
    ros::TransformList list;
    list.transforms.push_back(
        {{0, scan.time, "base_link"}, frame, transform_of(scan.T_robot_laser)});
    writer_.write(channel("/tf_static", "tf2_msgs/msg/TFMessage", transform_list_definition()),
                  scan.time, scan.time, ros::encode(list));
  }
  if (scan.T_odom_robot && *scans_have_odom_)
    write_pose("/odom", scan.time, *scan.T_odom_robot, 0, 0);
  const std::string topic = kScanTopic + number_of(scan.laser);
  writer_.write(channel(topic, "sensor_msgs/msg/LaserScan", laser_scan_definition()), scan.time,
                scan.time, ros::encode(message_of(scan, frame)));
}

void McapLogWriter::write_pose(const std::string& topic, Time time, const Pose2& pose, double speed,
                               double turn_rate) {
  ros::Odometry m;
  m.header = {0, time, topic == kTruthTopic ? "world" : "odom"};
  m.child_frame = "base_link";
  m.pose = transform_of(pose);
  m.linear[0] = speed;
  m.angular[2] = turn_rate;
  writer_.write(channel(topic, "nav_msgs/msg/Odometry", odometry_definition()), time, time,
                ros::encode(m));
}

void McapLogWriter::write_drive(const WheelMotion& wheels) {
  ros::AckermannDrive m;
  m.header = {0, wheels.time, "base_link"};
  m.steering = static_cast<float>(wheels.steering);
  m.speed = static_cast<float>(wheels.speed);
  writer_.write(
      channel("/drive", "ackermann_msgs/msg/AckermannDriveStamped", ackermann_drive_definition()),
      wheels.time, wheels.time, ros::encode(m));
}

// An odometry's own records beat what scans state: they come more often, and say more.
void McapLogWriter::write(const Event& event) {
  if (scans_have_odom_) return put(event);
  waiting_.push_back(event);
  if (std::holds_alternative<Odometry>(event) || std::holds_alternative<WheelMotion>(event)) {
    scans_have_odom_ = false;
    settle();
  } else if (waiting_.size() >= kLookAhead) {
    scans_have_odom_ = true;
    settle();
  }
}

void McapLogWriter::settle() {
  for (const Event& event : std::exchange(waiting_, {})) put(event);
}

void McapLogWriter::put(const Event& event) {
  if (const auto* scan = std::get_if<Scan>(&event)) return write_scan(*scan);
  if (const auto* o = std::get_if<Odometry>(&event)) {
    if (!*scans_have_odom_)
      return write_pose("/odom", o->time, o->T_odom_robot, o->speed.value_or(0),
                        o->turn_rate.value_or(0));
    return report_.count("odometry records beside those of the scans; left out");
  }
  if (const auto* wheels = std::get_if<WheelMotion>(&event)) return write_drive(*wheels);
  if (const auto* truth = std::get_if<Truth>(&event))
    return write_pose(kTruthTopic, truth->time, truth->T_world_robot, 0, 0);
  report_.count("records that a ROS 2 recording has no message for; left out");
}

void McapLogWriter::close() {
  if (!scans_have_odom_) scans_have_odom_ = true;
  settle();
  writer_.close();
  file_.sync();
}

}  // namespace majak::io
