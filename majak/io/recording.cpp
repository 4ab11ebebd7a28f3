// SPDX-License-Identifier: Apache-2.0
#include "majak/io/recording.hpp"

#include <map>

#include "majak/io/ros_scan.hpp"

namespace majak::io {
namespace {

constexpr Duration kFlushEvery = kSecond;
// The types that messages are made of.
const std::map<std::string, std::string>& parts() {
  static const std::map<std::string, std::string> kParts{
      {"std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"},
      {"builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"},
      {"geometry_msgs/PoseWithCovariance", "geometry_msgs/Pose pose\nfloat64[36] covariance\n"},
      {"geometry_msgs/Pose",
       "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"},
      {"geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"},
      {"geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"},
      {"geometry_msgs/TwistWithCovariance", "geometry_msgs/Twist twist\nfloat64[36] covariance\n"},
      {"geometry_msgs/Twist", "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n"},
      {"geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"},
      {"ackermann_msgs/AckermannDrive",
       "float32 steering_angle\nfloat32 steering_angle_velocity\n"
       "float32 speed\nfloat32 acceleration\nfloat32 jerk\n"},
      {"nav_msgs/MapMetaData",
       "builtin_interfaces/Time map_load_time\nfloat32 resolution\nuint32 width\nuint32 height\n"
       "geometry_msgs/Pose origin\n"},
      {"sensor_msgs/NavSatStatus", "int8 status\nuint16 service\n"},
      {"geometry_msgs/TransformStamped",
       "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n"},
      {"geometry_msgs/Transform",
       "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n"},
  };
  return kParts;
}

std::string part(const std::string& type) {
  return std::string(80, '=') + "\nMSG: " + type + "\n" + parts().at(type);
}

}  // namespace

std::string laser_scan_definition() {
  return "std_msgs/Header header\n"
         "float32 angle_min\nfloat32 angle_max\nfloat32 angle_increment\n"
         "float32 time_increment\nfloat32 scan_time\n"
         "float32 range_min\nfloat32 range_max\n"
         "float32[] ranges\nfloat32[] intensities\n" +
         part("std_msgs/Header") + part("builtin_interfaces/Time");
}

std::string odometry_definition() {
  return "std_msgs/Header header\nstring child_frame_id\n"
         "geometry_msgs/PoseWithCovariance pose\ngeometry_msgs/TwistWithCovariance twist\n" +
         part("std_msgs/Header") + part("builtin_interfaces/Time") +
         part("geometry_msgs/PoseWithCovariance") + part("geometry_msgs/Pose") +
         part("geometry_msgs/Point") + part("geometry_msgs/Quaternion") +
         part("geometry_msgs/TwistWithCovariance") + part("geometry_msgs/Twist") +
         part("geometry_msgs/Vector3");
}

std::string transform_list_definition() {
  return "geometry_msgs/TransformStamped[] transforms\n" + part("geometry_msgs/TransformStamped") +
         part("std_msgs/Header") + part("builtin_interfaces/Time") +
         part("geometry_msgs/Transform") + part("geometry_msgs/Vector3") +
         part("geometry_msgs/Quaternion");
}

std::string ackermann_drive_definition() {
  return "std_msgs/Header header\nackermann_msgs/AckermannDrive drive\n" + part("std_msgs/Header") +
         part("builtin_interfaces/Time") + part("ackermann_msgs/AckermannDrive");
}

std::string nav_sat_fix_definition() {
  return "std_msgs/Header header\nsensor_msgs/NavSatStatus status\n"
         "float64 latitude\nfloat64 longitude\nfloat64 altitude\n"
         "float64[9] position_covariance\nuint8 position_covariance_type\n" +
         part("std_msgs/Header") + part("builtin_interfaces/Time") +
         part("sensor_msgs/NavSatStatus");
}

std::string occupancy_grid_definition() {
  return "std_msgs/Header header\nnav_msgs/MapMetaData info\nint8[] data\n" +
         part("std_msgs/Header") + part("builtin_interfaces/Time") + part("nav_msgs/MapMetaData") +
         part("geometry_msgs/Pose") + part("geometry_msgs/Point") +
         part("geometry_msgs/Quaternion");
}

RecordingWriter::RecordingWriter(const std::string& path, const std::string& telegrams)
    : file_(path),
      writer_([this](std::string_view bytes) { file_.write(bytes); }),
      scan_channel_(writer_.add_channel({.topic = kScanTopic,
                                         .encoding = "cdr",
                                         .schema = "sensor_msgs/msg/LaserScan",
                                         .schema_encoding = "ros2msg",
                                         .schema_text = laser_scan_definition(),
                                         .metadata = {}})),
      telegram_channel_(writer_.add_channel({.topic = kTelegramTopic,
                                             .encoding = telegrams,
                                             .schema = "",
                                             .schema_encoding = "",
                                             .schema_text = "",
                                             .metadata = {}})) {}

void RecordingWriter::add_scan(const Scan& scan, Time now) {
  writer_.write(scan_channel_, now, scan.time, ros::encode(message_of(scan, kLaserFrame)));
  ++scans_;
  flush_now_and_then(now);
}

void RecordingWriter::add_telegram(std::span<const std::uint8_t> bytes, Time first_byte) {
  writer_.write(telegram_channel_, first_byte, first_byte,
                {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  flush_now_and_then(first_byte);
}

void RecordingWriter::flush_now_and_then(Time now) {
  if (!flushed_) flushed_ = now;
  if (now - *flushed_ < kFlushEvery) return;
  flush();
  flushed_ = now;
}

void RecordingWriter::flush() { writer_.flush(); }

void RecordingWriter::close() {
  writer_.close();
  file_.sync();
}

}  // namespace majak::io
