// SPDX-License-Identifier: Apache-2.0
// The messages of ROS that a mapper needs, as plain structs, from and to both of their
// serialisations: ROS 1 (packed, little endian) and ROS 2 (CDR, aligned, either byte order).
// Lengths in the bytes are checked before anything is allocated for them.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "majak/core/time.hpp"
#include "majak/io/ros_wire.hpp"

namespace majak::io::ros {

struct Header {
  std::uint32_t sequence = 0;  ///< ROS 1 only
  Time stamp = 0;
  std::string frame;  ///< without a leading slash
};

/// sensor_msgs/LaserScan: one turn; the stamp is that of the first ray.
struct LaserScan {
  Header header;
  float angle_min = 0, angle_max = 0, angle_increment = 0;  ///< rad
  float time_increment = 0, scan_time = 0;                  ///< s
  float range_min = 0, range_max = 0;                       ///< m
  std::vector<float> ranges;                                ///< m
  std::vector<float> intensities;                           ///< empty or one a range
};

/// A rigid motion in space as messages state it: x y z in metres, quaternion x y z w.
struct Transform {
  std::array<double, 3> translation{};
  std::array<double, 4> rotation{0, 0, 0, 1};
};

/// nav_msgs/Odometry: the pose of the child frame in the frame of the header, and its velocity.
struct Odometry {
  Header header;
  std::string child_frame;
  Transform pose;
  std::array<double, 36> pose_covariance{};
  std::array<double, 3> linear{};   ///< m/s in the child frame
  std::array<double, 3> angular{};  ///< rad/s
  std::array<double, 36> twist_covariance{};
};

/// geometry_msgs/TransformStamped: the child frame in the frame of the header.
struct StampedTransform {
  Header header;
  std::string child_frame;
  Transform transform;
};

/// tf2_msgs/TFMessage and tf/tfMessage.
struct TransformList {
  std::vector<StampedTransform> transforms;
};

/// sensor_msgs/NavSatFix.
struct NavSatFix {
  Header header;
  std::int8_t status = 0;                            ///< -1 means no fix
  std::uint16_t service = 0;                         ///< which satellites
  double latitude = 0, longitude = 0, altitude = 0;  ///< degrees, m above the ellipsoid
  std::array<double, 9> covariance{};
  std::uint8_t covariance_type = 0;
};

/// ackermann_msgs/AckermannDriveStamped.
struct AckermannDrive {
  Header header;
  float steering = 0, steering_rate = 0;        ///< rad, rad/s; left positive
  float speed = 0, acceleration = 0, jerk = 0;  ///< m/s and so on, ahead
};

/// Reads a message. Throws Error (without a position) when the bytes end early or a length in them
/// cannot be true. Bytes behind the message are allowed.
void decode(std::string_view bytes, Encoding encoding, LaserScan& message);
void decode(std::string_view bytes, Encoding encoding, Odometry& message);
void decode(std::string_view bytes, Encoding encoding, TransformList& message);
void decode(std::string_view bytes, Encoding encoding, NavSatFix& message);
void decode(std::string_view bytes, Encoding encoding, AckermannDrive& message);

/// Writes a message; CDR in little endian. A stamp outside what the encoding can say (from 1970 to
/// 2106 for ROS 1, 1901 to 2038 for CDR) throws Error.
std::string encode(const LaserScan& message, Encoding encoding = Encoding::cdr);
std::string encode(const Odometry& message, Encoding encoding = Encoding::cdr);
std::string encode(const TransformList& message, Encoding encoding = Encoding::cdr);
std::string encode(const NavSatFix& message, Encoding encoding = Encoding::cdr);
std::string encode(const AckermannDrive& message, Encoding encoding = Encoding::cdr);

}  // namespace majak::io::ros
