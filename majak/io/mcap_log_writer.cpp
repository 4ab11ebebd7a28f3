// SPDX-License-Identifier: Apache-2.0
#include "majak/io/mcap_log_writer.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <utility>

#include "majak/beacon/local_frame.hpp"
#include "majak/io/recording.hpp"
#include "majak/io/ros_scan.hpp"

namespace majak::io {
namespace {

const char* const kTruthTopic = "/ground_truth";
const char* const kWorldFrame = "world";
// A local frame does not say where on the Earth it lies: here at latitude 0, longitude 0.
const beacon::LocalFrame& world_on_earth() {
  static const beacon::LocalFrame kFrame(beacon::Geodetic{});
  return kFrame;
}
constexpr std::size_t kLookAhead = 300;  // events without an odometry record

ros::Transform transform_of(const Pose2& pose) {
  ros::Transform t;
  t.translation = {pose.x, pose.y, 0};
  t.rotation = {0, 0, std::sin(0.5 * pose.theta), std::cos(0.5 * pose.theta)};
  return t;
}

ros::Transform transform_of(const beacon::LocalFrame& frame) {
  const Eigen::Quaterniond turn(frame.axes());
  const Vec3& p = frame.origin();
  return {{p.x(), p.y(), p.z()}, {turn.x(), turn.y(), turn.z(), turn.w()}};
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

void McapLogWriter::write_static(Time time, const std::string& parent, const std::string& child,
                                 const ros::Transform& transform) {
  ros::TransformList list;
  ros::StampedTransform& placed = list.transforms.emplace_back();
  placed.header.stamp = time;
  placed.header.frame = parent;
  placed.child_frame = child;
  placed.transform = transform;
  writer_.write(channel("/tf_static", "tf2_msgs/msg/TFMessage", transform_list_definition()), time,
                time, ros::encode(list));
}

void McapLogWriter::write_scan(const Scan& scan) {
  const std::string frame = kLaserFrame + number_of(scan.laser);
  const auto mounting = mountings_.find(scan.laser);
  if (mounting == mountings_.end() || !(mounting->second == scan.T_robot_laser)) {
    mountings_[scan.laser] = scan.T_robot_laser;
    write_static(scan.time, "base_link", frame, transform_of(scan.T_robot_laser));
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
  m.header = {0, time, topic == kTruthTopic ? kWorldFrame : "odom"};
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

// The frame of the fixes hangs on that of the Earth (ROS REP 105), so that it reads back the same.
void McapLogWriter::write_fix(const GpsFix& fix) {
  const beacon::LocalFrame& frame = world_on_earth();
  if (!std::exchange(placed_on_earth_, true))
    write_static(fix.time, kEarthFrame, kWorldFrame, transform_of(frame));
  const beacon::Geodetic place = frame.geodetic({fix.east, fix.north});
  ros::NavSatFix m;
  m.header = {0, fix.time, "gps"};
  m.latitude = place.latitude, m.longitude = place.longitude, m.altitude = place.altitude;
  if (fix.sigma > 0) {
    m.covariance[0] = m.covariance[4] = fix.sigma * fix.sigma;
    m.covariance_type = 2;  // the diagonal is known
  }
  writer_.write(channel("/fix", "sensor_msgs/msg/NavSatFix", nav_sat_fix_definition()), fix.time,
                fix.time, ros::encode(m));
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
  if (const auto* fix = std::get_if<GpsFix>(&event)) return write_fix(*fix);
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
