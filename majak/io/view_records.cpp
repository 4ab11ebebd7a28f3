// SPDX-License-Identifier: Apache-2.0
#include "majak/io/view_records.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "majak/io/mcap_records.hpp"
#include "majak/io/recording.hpp"
#include "majak/io/ros_messages.hpp"
#include "majak/io/ros_scan.hpp"
#include "majak/io/ros_wire.hpp"

namespace majak::io {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr Time kLastStamp = Time{std::numeric_limits<std::int32_t>::max()} * kSecond;

Time writable(Time time) { return std::clamp<Time>(time, 0, kLastStamp); }

struct Topic {
  ViewTopic id;
  const char* name;
  const char* type;        // empty: JSON
  std::string definition;  // in the language of ROS 2
};

std::string with_time(const char* fields) {
  return std::string(fields) + std::string(80, '=') +
         "\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
}

std::vector<Topic> topics() {
  return {
      {ViewTopic::scan, kScanTopic, "sensor_msgs/msg/LaserScan", laser_scan_definition()},
      {ViewTopic::estimate, "/estimate", "majak_msgs/msg/Estimate",
       with_time("builtin_interfaces/Time stamp\nuint32 scan\nuint32 key\nuint8 health\n"
                 "bool is_key\nfloat32 match_score\nfloat32 milliseconds\nuint32 particles\n"
                 "float64[3] pose\nfloat32[6] covariance\nfloat64[3] odometry\n"
                 "float64[3] front_end\n")},
      {ViewTopic::key_poses, "/key_poses", "majak_msgs/msg/KeyPoses",
       "uint32[] scans\nfloat64[] poses\n"},
      {ViewTopic::map, "/map", "nav_msgs/msg/OccupancyGrid", occupancy_grid_definition()},
      {ViewTopic::graph, "/graph", "majak_msgs/msg/Graph",
       "uint32[] from_scan\nuint32[] to_scan\nuint8[] kind\nuint8[] enabled\nfloat32[] chi2\n"},
      {ViewTopic::truth, "/truth", "majak_msgs/msg/Path", "int64[] stamps\nfloat64[] poses\n"},
      {ViewTopic::segments, "/segments", "majak_msgs/msg/Segments", "float32[] ends\n"},
      {ViewTopic::particles, "/particles", "majak_msgs/msg/Particles",
       with_time("builtin_interfaces/Time stamp\nfloat32[] poses\nfloat32[] weights\n")},
      {ViewTopic::hypotheses, "/hypotheses", "", ""},
      {ViewTopic::landmarks, "/landmarks", "", ""},
      {ViewTopic::run, "/run", "", ""},
      {ViewTopic::closures, "/closures", "", ""},
      {ViewTopic::edits, "/edits", "", ""},
      {ViewTopic::status, "/status", "", ""},
  };
}

std::string message(ViewTopic topic, std::size_t sequence, Time time, std::string_view data) {
  std::string bytes;
  bytes.reserve(data.size() + 31);
  const auto stamp = static_cast<std::uint64_t>(writable(time));
  mcap::put_message(bytes, static_cast<std::uint16_t>(topic), static_cast<std::uint32_t>(sequence),
                    stamp, stamp, data);
  return bytes;
}

ros::Writer cdr() { return ros::Writer(ros::Encoding::cdr); }

std::array<double, 3> numbers(const Pose2& p) { return {p.x, p.y, p.theta}; }
std::array<double, 3> numbers(const std::optional<Pose2>& p) {
  return p ? numbers(*p) : std::array{kNaN, kNaN, kNaN};
}

template <class T>
std::vector<T> flat(std::span<const Pose2> poses) {
  std::vector<T> values;
  values.reserve(3 * poses.size());
  for (const Pose2& p : poses)
    for (const double v : numbers(p)) values.push_back(static_cast<T>(v));
  return values;
}

std::vector<std::int8_t> percent(const map::OccupancyGrid& grid, const map::CellBox& box) {
  std::vector<std::int8_t> cells;
  cells.reserve(static_cast<std::size_t>(box.width) * static_cast<std::size_t>(box.height));
  std::vector<std::int16_t> row(static_cast<std::size_t>(box.width));
  for (int iy = box.y0; iy < box.y0 + box.height; ++iy) {
    grid.copy_row(box.x0, iy, box.width, row.data());
    for (const std::int16_t v : row) {
      const double p = 1 / (1 + std::exp(-v * map::OccupancyGrid::kUnit));
      cells.push_back(v == map::OccupancyGrid::kUnknown
                          ? std::int8_t{-1}
                          : static_cast<std::int8_t>(std::lround(100 * p)));
    }
  }
  return cells;
}

}  // namespace

std::string view_head() {
  std::string bytes = mcap::head("ros2", "majak"), channels;
  for (const Topic& topic : topics()) {
    const bool json = *topic.type == 0;
    const McapChannel channel{.topic = topic.name,
                              .encoding = json ? "json" : "cdr",
                              .schema = topic.type,
                              .schema_encoding = json ? "" : "ros2msg",
                              .schema_text = topic.definition};
    const auto id = static_cast<std::uint16_t>(topic.id);
    if (!json) bytes += mcap::schema_record(id, channel);
    channels += mcap::channel_record(id, json ? 0 : id, channel);
  }
  return bytes + channels;
}

std::string view_json(ViewTopic topic, std::string_view text) { return message(topic, 0, 0, text); }

std::string view_scan(std::size_t number, const Scan& scan, std::size_t laser) {
  ros::LaserScan wire = message_of(scan, "laser" + std::to_string(laser));
  wire.header.stamp = writable(scan.time);
  return message(ViewTopic::scan, number, scan.time, ros::encode(wire));
}

std::string view_estimate(const ViewedPose& p) {
  ros::Writer wire = cdr();
  const Mat3& c = p.estimate.covariance;
  wire.stamp(writable(p.estimate.time));
  wire(static_cast<std::uint32_t>(p.scan));
  wire(static_cast<std::uint32_t>(p.key));
  wire(static_cast<std::uint8_t>(p.estimate.health));
  wire(static_cast<std::uint8_t>(p.is_key));
  wire(p.match_score);
  wire(p.milliseconds > 0 ? p.milliseconds : static_cast<float>(kNaN));
  wire(p.particles);
  wire(numbers(p.estimate.T_map_robot));
  for (const double v : {c(0, 0), c(0, 1), c(0, 2), c(1, 1), c(1, 2), c(2, 2)})
    wire(static_cast<float>(v));
  wire(numbers(p.T_map_odometry));
  wire(numbers(p.T_map_front_end));
  return message(ViewTopic::estimate, p.scan, p.estimate.time, wire.take());
}

std::string view_key_poses(std::span<const std::size_t> scans, std::span<const Pose2> poses) {
  ros::Writer wire = cdr();
  wire(std::vector<std::uint32_t>(scans.begin(), scans.end()));
  wire(flat<double>(poses));
  return message(ViewTopic::key_poses, 0, 0, wire.take());
}

std::string view_map(const map::OccupancyGrid& grid) {
  const map::CellBox box = grid.bounds();
  const double side = grid.resolution();
  ros::Writer wire = cdr();
  wire.stamp(0);
  wire(std::string("map"));
  wire.stamp(0);
  wire(static_cast<float>(side));
  wire(static_cast<std::uint32_t>(box.width));
  wire(static_cast<std::uint32_t>(box.height));
  wire(std::array{side * box.x0, side * box.y0, 0.0});
  wire(std::array{0.0, 0.0, 0.0, 1.0});
  wire(percent(grid, box));
  return message(ViewTopic::map, 0, 0, wire.take());
}

std::string view_graph(const Site& site) {
  std::vector<std::uint32_t> from, to;
  std::vector<std::uint8_t> kind, enabled;
  std::vector<float> chi2;
  for (const Constraint& c : site.constraints) {
    from.push_back(static_cast<std::uint32_t>(c.from));
    to.push_back(static_cast<std::uint32_t>(c.to));
    kind.push_back(static_cast<std::uint8_t>(c.kind));
    enabled.push_back(c.enabled ? 1 : 0);
    chi2.push_back(static_cast<float>(c.chi2));
  }
  ros::Writer wire = cdr();
  wire(from);
  wire(to);
  wire(kind);
  wire(enabled);
  wire(chi2);
  return message(ViewTopic::graph, 0, 0, wire.take());
}

std::string view_truth(const StampedPoses& path) {
  ros::Writer wire = cdr();
  wire(path.stamps);
  wire(flat<double>(path.poses));
  return message(ViewTopic::truth, 0, 0, wire.take());
}

std::string view_segments(const std::vector<float>& ends) {
  ros::Writer wire = cdr();
  wire(ends);
  return message(ViewTopic::segments, 0, 0, wire.take());
}

std::string view_particles(Time time, std::span<const Pose2> particles,
                           std::span<const float> weights) {
  ros::Writer wire = cdr();
  wire.stamp(writable(time));
  wire(flat<float>(particles));
  wire(std::vector<float>(weights.begin(), weights.end()));
  return message(ViewTopic::particles, 0, time, wire.take());
}

}  // namespace majak::io
