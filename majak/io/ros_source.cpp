// SPDX-License-Identifier: Apache-2.0
#include "majak/io/ros_source.hpp"

#include <cmath>
#include <utility>

#include "majak/core/error.hpp"
#include "majak/io/mcap_reader.hpp"
#include "majak/io/ros1_bag.hpp"
#include "majak/io/ros2_sqlite.hpp"

namespace majak::io {

namespace {

const char* const kUndecoded = "messages that cannot be decoded; left out";
const char* const kNoStamp = "messages without a stamp; the time of recording used";
const char* const kClocks =
    "messages of laser and odometry are stamped by different clocks; times of recording used";
const char* const kNoMounting =
    "scans whose frame tf does not place on the robot; the laser is taken as the robot's centre "
    "(--mounting places it)";
const char* const kUpsideDown = "scans of a laser that hangs upside down; mirrored";
const char* const kNoFix = "satellite messages without a fix; left out";
const char* const kBadPose = "odometry whose pose is no number; left out";

const char* const kBadDrive = "speed or steering that is no number; left out";

constexpr const char* kBackwards[4] = {"scan stamps that run backwards; order of the file kept",
                                       "odometry stamps that run backwards; order of the file kept",
                                       "GPS stamps that run backwards; order of the file kept",
                                       "truth stamps that run backwards; order of the file kept"};

}  // namespace

RosSource::RosSource(const OpenMessages& open, std::string format, const SourceOptions& options)
    : format_(std::move(format)),
      survey_(survey_recording(open, options.topic)),
      T_robot_laser_(options.T_robot_laser),
      log_(open(Depth::messages)),
      frames_(survey_.frames) {
  check_angle_step(options);
  if (options.angle_step > 0) scan_options_.angle_step = radians(options.angle_step);
  scan_options_.code = survey_.code;
  for (const std::string& name : survey_.more_odometry)
    report_.count("odometry of the topic " + name + " is left out; " + survey_.odometry_topic +
                  " is used");
}

/// From the events' own stamps, unless those say nothing.
void RosSource::add_stamped(Event event, Time recorded) {
  std::visit(
      [&](auto& e) {
        if (survey_.use_recording_times) {
          e.time = recorded;
          report_.count(kClocks, records_);
        } else if (e.time == 0) {
          e.time = recorded;
          report_.count(kNoStamp, records_);
        }
      },
      event);
  order_.add(std::move(event));
}

Mounting RosSource::mounting(const std::string& laser_frame) {
  Mounting mounting;
  if (laser_frame != survey_.robot_frame) {
    const auto placed = frames_.find(survey_.robot_frame, laser_frame);
    if (placed) mounting = mounting_of(*placed);
    // Where there is a laser and nothing else, it is the robot.
    const bool matters =
        !survey_.odometry_topic.empty() || survey_.odometry_from_tf || !survey_.drive_topic.empty();
    if (!placed && !T_robot_laser_ && matters) report_.count(kNoMounting, records_);
  }
  if (mounting.upside_down) report_.count(kUpsideDown, records_);
  if (T_robot_laser_) mounting.T_robot_laser = *T_robot_laser_;
  return mounting;
}

void RosSource::add_scan(const Message& message) {
  ros::LaserScan m;
  ros::decode(message.data, *log_->topics()[message.topic].encoding, m);
  auto scan = scan_of(m, mounting(m.header.frame), scan_options_, records_, report_);
  if (scan) add_stamped(std::move(*scan), message.time);
}

void RosSource::add_odometry(const Message& message) {
  ros::Odometry m;
  ros::decode(message.data, *log_->topics()[message.topic].encoding, m);
  Odometry odometry;
  odometry.time = m.header.stamp;
  odometry.T_odom_robot = planar_pose(m.pose);
  if (!odometry.T_odom_robot.finite()) return report_.count(kBadPose, records_);
  const bool states_velocity = std::isfinite(m.linear[0]) && std::isfinite(m.angular[2]);
  const bool moves = m.linear[0] != 0 || m.angular[2] != 0;
  if (moves) survey_.velocity_missing = false;
  if (states_velocity && !survey_.velocity_missing) {
    odometry.speed = m.linear[0];
    odometry.turn_rate = m.angular[2];
  }
  add_stamped(odometry, message.time);
}

/// The frame of fixes is the map's or world's own where tf says that this one lies level on the
/// Earth with x to the east.
void RosSource::place_on_earth() {
  constexpr double kSame = 1e-6;
  for (const char* frame : {"map", "world"}) {
    if (frames_.parent_of(frame) != kEarthFrame) continue;
    const auto placed = frames_.find(kEarthFrame, frame);
    if (!placed || placed->translation.norm() < 1e6) continue;  // m; not on the Earth
    const beacon::LocalFrame local(beacon::geodetic_of(placed->translation));
    if ((local.axes() - placed->rotation).norm() < kSame) return frame_of_fixes_.begin_at(local);
  }
}

void RosSource::add_fix(const Message& message) {
  ros::NavSatFix m;
  ros::decode(message.data, *log_->topics()[message.topic].encoding, m);
  const bool sound = m.status >= 0 && std::abs(m.latitude) <= 90 && std::abs(m.longitude) <= 360;
  if (!sound) return report_.count(kNoFix, records_);
  if (!frame_of_fixes_.begun()) place_on_earth();
  const double altitude = std::isfinite(m.altitude) ? m.altitude : 0;
  const Vec2 p = frame_of_fixes_.east_north({m.latitude, m.longitude, altitude});
  // Row by row, in east, north, up; type 0 says that nothing is known of it.
  const double variance = m.covariance_type == 0 ? 0 : 0.5 * (m.covariance[0] + m.covariance[4]);
  const double sigma = variance > 0 && std::isfinite(variance) ? std::sqrt(variance) : 0;
  add_stamped(GpsFix{.time = m.header.stamp, .east = p.x(), .north = p.y(), .sigma = sigma},
              message.time);
}

void RosSource::add_drive(const Message& message) {
  ros::AckermannDrive m;
  ros::decode(message.data, *log_->topics()[message.topic].encoding, m);
  if (!std::isfinite(m.speed) || !std::isfinite(m.steering))
    return report_.count(kBadDrive, records_);
  add_stamped(WheelMotion{m.header.stamp, m.speed, m.steering}, message.time);
}

void RosSource::add_truth(const Message& message) {
  ros::Odometry m;
  ros::decode(message.data, *log_->topics()[message.topic].encoding, m);
  const Pose2 pose = planar_pose(m.pose);
  if (!pose.finite()) return report_.count(kBadPose, records_);
  add_stamped(Truth{m.header.stamp, pose}, message.time);
}

/// tf as it goes; where there is no message of its own for it, the odometry is in there.
void RosSource::follow_frames(const Message& message) {
  ros::TransformList list;
  ros::decode(message.data, *log_->topics()[message.topic].encoding, list);
  for (const ros::StampedTransform& transform : list.transforms) {
    frames_.set(transform);
    if (!survey_.odometry_from_tf || transform.header.frame != survey_.odometry_frame) continue;
    if (!frames_.find(transform.child_frame, survey_.robot_frame)) continue;
    Odometry odometry;
    odometry.time = transform.header.stamp;
    if (transform.child_frame == survey_.robot_frame) {
      odometry.T_odom_robot = planar_pose(transform.transform);
    } else if (const auto placed = frames_.find(survey_.odometry_frame, survey_.robot_frame)) {
      odometry.T_odom_robot = mounting_of(*placed).T_robot_laser;
    }
    if (!odometry.T_odom_robot.finite()) {
      report_.count(kBadPose, records_);
    } else {
      add_stamped(odometry, message.time);
    }
  }
}

/// Reads one message; false at the end of the recording.
bool RosSource::read_message() {
  Message message;
  if (!log_->next(message)) return false;
  ++records_;
  const Topic& topic = log_->topics()[message.topic];
  if (!topic.encoding) return true;
  try {
    if (topic.type == "sensor_msgs/LaserScan") {
      if (topic.name == survey_.scan_topic) add_scan(message);
    } else if (topic.type == "nav_msgs/Odometry") {
      if (topic.name == survey_.odometry_topic) add_odometry(message);
      if (topic.name == survey_.truth_topic) add_truth(message);
    } else if (topic.type == "ackermann_msgs/AckermannDriveStamped") {
      if (topic.name == survey_.drive_topic) add_drive(message);
    } else if (topic.type == "sensor_msgs/NavSatFix") {
      if (topic.name == survey_.fix_topic) add_fix(message);
    } else if (topic.type == "tf2_msgs/TFMessage" || topic.type == "tf/tfMessage") {
      follow_frames(message);
    }
  } catch (const Error&) {
    report_.count(kUndecoded, records_);
  }
  return true;
}

void RosSource::watch_stamp(const Event& event) {
  const std::size_t sensor = std::holds_alternative<Scan>(event)     ? 0
                             : std::holds_alternative<GpsFix>(event) ? 2
                             : std::holds_alternative<Truth>(event)  ? 3
                                                                     : 1;
  const Time time = time_of(event);
  std::optional<Time>& last = last_stamp_[sensor];
  if (last && time < *last) report_.count(kBackwards[sensor]);
  last = time;
}

void RosSource::finish() {
  if (finished_) return;
  finished_ = true;
  order_.close();
  for (const auto& [what, entry] : log_->report().entries()) report_.add(what, entry);
}

std::optional<Event> RosSource::next() {
  for (;;) {
    if (order_.ready()) {
      Event event = order_.take();
      watch_stamp(event);
      return event;
    }
    if (finished_) return std::nullopt;
    if (!read_message()) finish();
  }
}

namespace {

struct Kind {
  const char* name;
  OpenMessages open;
};

std::optional<Kind> kind_of(const std::filesystem::path& path, std::string_view head) {
  if (looks_like_ros1_bag(head))
    return Kind{"ROS 1 bag", [path](Depth depth) -> std::unique_ptr<MessageLog> {
                  return std::make_unique<Ros1Bag>(open_bytes(path).bytes, depth);
                }};
  if (looks_like_mcap(head))
    return Kind{"MCAP recording", [path](Depth depth) -> std::unique_ptr<MessageLog> {
                  return std::make_unique<McapReader>(open_bytes(path).bytes, depth);
                }};
  if (looks_like_sqlite(head))
    return Kind{"ROS 2 bag, SQLite", [path](Depth depth) -> std::unique_ptr<MessageLog> {
                  return std::make_unique<Ros2Sqlite>(path, depth);
                }};
  return std::nullopt;
}

std::string head_of(const std::filesystem::path& path) {
  std::string head;
  PieceReader(open_bytes(path).bytes).read(head, 64);
  return head;
}

std::optional<Kind> folder_kind(const std::filesystem::path& folder) {
  std::vector<OpenMessages> open;
  for (const std::filesystem::path& file : ros2_bag_files(folder)) {
    const auto kind = kind_of(file, head_of(file));
    if (!kind) throw Error(file.filename().string() + " is no recording that majak knows");
    open.push_back(kind->open);
  }
  if (open.empty()) return std::nullopt;
  return Kind{"ROS 2 bag", [open](Depth depth) -> std::unique_ptr<MessageLog> {
                return std::make_unique<ChainedLogs>(open, depth);
              }};
}

}  // namespace

std::unique_ptr<Source> open_ros(const std::filesystem::path& path, std::string_view head,
                                 const SourceOptions& options) {
  try {
    std::error_code ignored;
    const bool folder = std::filesystem::is_directory(path, ignored);
    const auto kind = folder ? folder_kind(path) : kind_of(path, head);
    if (!kind) return nullptr;
    return std::make_unique<RosSource>(kind->open, kind->name, options);
  } catch (const Error& e) {
    const std::string what = e.what();
    throw Error(what.starts_with(path.string()) ? what : path.string() + ": " + what);
  }
}

}  // namespace majak::io
