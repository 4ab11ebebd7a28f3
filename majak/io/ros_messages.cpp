// SPDX-License-Identifier: Apache-2.0
#include "majak/io/ros_messages.hpp"

#include <algorithm>
#include <type_traits>

namespace majak::io::ros {

namespace {

// ---- each message, once for reading and writing -------------------------------------------------

/// tf of old ROS 1 names frames with a leading slash.
template <class Wire, class M>
void frame(Wire& wire, M& name) {
  wire(name);
  if constexpr (Wire::kReads) name.erase(0, std::min(name.find_first_not_of('/'), name.size()));
}

template <class Wire, class M>
void header(Wire& wire, M& m) {
  if (wire.ros1()) wire(m.sequence);
  wire.stamp(m.stamp);
  frame(wire, m.frame);
}

template <class Wire, class M>
void transform(Wire& wire, M& m) {
  wire(m.translation);
  wire(m.rotation);
}

template <class Wire, class M>
requires std::is_same_v<std::remove_const_t<M>, LaserScan>
void fields(Wire& wire, M& m) {
  header(wire, m.header);
  wire(m.angle_min);
  wire(m.angle_max);
  wire(m.angle_increment);
  wire(m.time_increment);
  wire(m.scan_time);
  wire(m.range_min);
  wire(m.range_max);
  wire(m.ranges);
  wire(m.intensities);
}

template <class Wire, class M>
requires std::is_same_v<std::remove_const_t<M>, Odometry>
void fields(Wire& wire, M& m) {
  header(wire, m.header);
  frame(wire, m.child_frame);
  transform(wire, m.pose);
  wire(m.pose_covariance);
  wire(m.linear);
  wire(m.angular);
  wire(m.twist_covariance);
}

template <class Wire, class M>
requires std::is_same_v<std::remove_const_t<M>, TransformList>
void fields(Wire& wire, M& m) {
  wire.list(m.transforms, [&wire](auto& t) {
    header(wire, t.header);
    frame(wire, t.child_frame);
    transform(wire, t.transform);
  });
}

template <class Wire, class M>
requires std::is_same_v<std::remove_const_t<M>, NavSatFix>
void fields(Wire& wire, M& m) {
  header(wire, m.header);
  wire(m.status);
  wire(m.service);
  wire(m.latitude);
  wire(m.longitude);
  wire(m.altitude);
  wire(m.covariance);
  wire(m.covariance_type);
}

template <class Wire, class M>
requires std::is_same_v<std::remove_const_t<M>, AckermannDrive>
void fields(Wire& wire, M& m) {
  header(wire, m.header);
  wire(m.steering);
  wire(m.steering_rate);
  wire(m.speed);
  wire(m.acceleration);
  wire(m.jerk);
}

template <class M>
void read(std::string_view bytes, Encoding encoding, M& message) {
  Reader reader(bytes, encoding);
  fields(reader, message);
}

template <class M>
std::string written(const M& message, Encoding encoding) {
  Writer writer(encoding);
  fields(writer, message);
  return writer.take();
}

}  // namespace

void decode(std::string_view b, Encoding encoding, LaserScan& m) { read(b, encoding, m); }
void decode(std::string_view b, Encoding encoding, Odometry& m) { read(b, encoding, m); }
void decode(std::string_view b, Encoding encoding, TransformList& m) { read(b, encoding, m); }
void decode(std::string_view b, Encoding encoding, NavSatFix& m) { read(b, encoding, m); }
void decode(std::string_view b, Encoding encoding, AckermannDrive& m) { read(b, encoding, m); }

std::string encode(const LaserScan& m, Encoding encoding) { return written(m, encoding); }
std::string encode(const Odometry& m, Encoding encoding) { return written(m, encoding); }
std::string encode(const TransformList& m, Encoding encoding) { return written(m, encoding); }
std::string encode(const NavSatFix& m, Encoding encoding) { return written(m, encoding); }
std::string encode(const AckermannDrive& m, Encoding encoding) { return written(m, encoding); }

}  // namespace majak::io::ros
