// SPDX-License-Identifier: Apache-2.0
#include "majak/io/player_log.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "majak/core/error.hpp"
#include "majak/io/no_return.hpp"

namespace majak::io {

namespace {

// Message types and subtypes of player.h.
constexpr std::size_t kData = 1, kReply = 4;
constexpr std::size_t kScan = 1, kScanWithPose = 2, kScanWithAngles = 3;
constexpr std::size_t kState = 1, kGeometry = 1;
constexpr std::size_t kMostLasers = 64;

const char* const kDamaged = "lines with a missing or unreadable number; left out";
const char* const kCutOff = "the last line is cut off; left out";
const char* const kOther = "messages of other interfaces; left out";
const char* const kUneven = "scans whose beams are not evenly spaced; left out";
const char* const kScansBackwards = "scan stamps that run backwards; order of the file kept";
const char* const kOdometryBackwards = "odometry stamps that run backwards; order of the file kept";

bool finite(const Pose2& pose) { return pose.finite() && pose.vector().norm() < 1e9; }

bool read_pose(Fields& fields, Pose2& pose) {
  return fields.number(pose.x) && fields.number(pose.y) && fields.number(pose.theta) &&
         finite(pose);
}

float usable_range(double range, float max_range) {
  if (!(range > 0)) return kInvalidRange;
  const auto metres = static_cast<float>(range);
  return metres >= max_range ? kNoReturn : metres;
}

}  // namespace

/// `time host robot interface index type subtype`, before the message itself.
struct PlayerLog::Head {
  Time time = 0;
  std::string_view interface;
  std::size_t index = 0, type = 0, subtype = 0;

  bool read(Fields& fields) {
    if (!fields.time(time) || fields.word().empty() || fields.word().empty()) return false;
    interface = fields.word();
    const auto plain = [&](std::size_t& value) {
      double number = 0;
      if (!fields.number(number) || !(number >= 0 && number < 1000)) return false;
      value = static_cast<std::size_t>(number);
      return static_cast<double>(value) == number;
    };
    return !interface.empty() && interface[0] >= 'a' && interface[0] <= 'z' && plain(index) &&
           plain(type) && plain(subtype);
  }
};

bool looks_like_player(std::string_view text) {
  if (text.starts_with("## Player")) return true;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string line(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.empty() || !(is_digit(line[0]) || line[0] == '-')) continue;
    Fields fields(line);
    Time time = 0;
    if (!fields.time(time) || fields.word().empty() || fields.word().empty()) continue;
    const std::string_view interface = fields.word();
    if (interface == "laser" || interface == "position2d") return true;
  }
  return false;
}

PlayerLog::PlayerLog(std::unique_ptr<ByteStream> bytes, std::string format,
                     const SourceOptions& options)
    : lines_(std::move(bytes)), format_(std::move(format)), options_(options) {
  if (!options.topic.empty()) throw Error("--topic is for ROS recordings");
  check_angle_step(options);
}

std::nullopt_t PlayerLog::damaged() {
  report_.count(kDamaged, lines_.line());
  return std::nullopt;
}

bool PlayerLog::read_ranges(Fields& fields, std::size_t count, Scan& scan) {
  double range = 0, intensity = 0;
  bool any = false;
  scan.ranges.reserve(count);
  scan.intensities.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    if (!fields.number(range) || !fields.number(intensity)) return false;
    scan.ranges.push_back(usable_range(range, scan.max_range));
    scan.intensities.push_back(static_cast<float>(intensity));
    any |= intensity != 0;
  }
  if (!any) scan.intensities.clear();
  return true;
}

void PlayerLog::place(Scan& scan, int index) {
  scan.laser = index;
  if (const auto known = T_robot_laser_.find(index); known != T_robot_laser_.end())
    scan.T_robot_laser = known->second;
  if (options_.T_robot_laser) scan.T_robot_laser = *options_.T_robot_laser;
}

/// Player's laser proxy reports every beam's own angle; a Scan needs them evenly spaced.
std::optional<Event> PlayerLog::read_angled_scan(Scan scan, Fields& fields) {
  double id = 0, max_range = 0;
  std::size_t count = 0;
  if (!fields.number(id) || !fields.number(max_range) || !(max_range > 0) || !fields.count(count) ||
      count < 2)
    return damaged();
  scan.max_range = sick_limit(static_cast<float>(max_range));
  double first = 0, last = 0, worst = 0;
  for (std::size_t i = 0; i < count; ++i) {
    double range = 0, angle = 0, intensity = 0;
    if (!fields.number(range) || !fields.number(angle) || !fields.number(intensity) ||
        !std::isfinite(angle))
      return damaged();
    if (i == 0) first = angle;
    if (i == 1) scan.angle_step = angle_diff(angle, first);
    if (i > 1) worst = std::max(worst, std::abs(angle_diff(angle, last) - scan.angle_step));
    last = angle;
    scan.ranges.push_back(usable_range(range, scan.max_range));
  }
  if (!(scan.angle_step > 0) || worst > 0.1 * scan.angle_step) {
    report_.count(kUneven, lines_.line());
    return std::nullopt;
  }
  scan.start_angle = first;
  if (options_.angle_step > 0) scan.angle_step = radians(options_.angle_step);
  return scan;
}

std::optional<Event> PlayerLog::read_laser(const Head& head, Fields& fields) {
  const int index = static_cast<int>(head.index);
  if (head.type == kReply && head.subtype == kGeometry) {
    read_mounting(index, fields);
    return std::nullopt;
  }
  if (head.type != kData) return std::nullopt;
  Scan scan;
  scan.time = head.time;
  place(scan, index);
  if (head.subtype == kScanWithAngles) return read_angled_scan(std::move(scan), fields);
  if (head.subtype != kScan && head.subtype != kScanWithPose) return std::nullopt;
  double id = 0, from = 0, to = 0, step = 0, max_range = 0;
  Pose2 T_odom_robot;
  if (!fields.number(id)) return damaged();
  if (head.subtype == kScanWithPose && !read_pose(fields, T_odom_robot)) return damaged();
  std::size_t count = 0;
  const bool sound = fields.number(from) && fields.number(to) && fields.number(step) &&
                     fields.number(max_range) && fields.count(count) && std::isfinite(from) &&
                     step > 0 && step <= kPi && max_range > 0 && max_range < 1e6;
  if (!sound) return damaged();
  scan.start_angle = from;
  scan.angle_step = options_.angle_step > 0 ? radians(options_.angle_step) : step;
  scan.max_range = sick_limit(static_cast<float>(max_range));
  if (!read_ranges(fields, count, scan)) return damaged();
  if (head.subtype == kScanWithPose) scan.T_odom_robot = T_odom_robot;
  return scan;
}

void PlayerLog::read_mounting(int index, Fields& fields) {
  Pose2 T_robot_laser;
  if (index >= static_cast<int>(kMostLasers) || !read_pose(fields, T_robot_laser)) {
    damaged();
  } else {
    T_robot_laser_[index] = T_robot_laser;
  }
}

std::optional<Event> PlayerLog::read_position(const Head& head, Fields& fields) {
  if (head.type != kData || head.subtype != kState || head.index != 0) return std::nullopt;
  Odometry odometry;
  odometry.time = head.time;
  double speed = 0, sideways = 0, turn_rate = 0;
  if (!read_pose(fields, odometry.T_odom_robot) || !fields.number(speed) ||
      !fields.number(sideways) || !fields.number(turn_rate))
    return damaged();
  odometry.speed = speed;
  odometry.turn_rate = turn_rate;
  return odometry;
}

std::optional<Event> PlayerLog::read_line(std::string_view line) {
  Fields fields(line);
  if (fields.at_end() || line.starts_with("#")) return std::nullopt;
  Head head;
  if (!head.read(fields)) return damaged();
  if (head.interface == "laser") return read_laser(head, fields);
  if (head.interface == "position2d") return read_position(head, fields);
  if (head.interface != "sync") report_.count(kOther, lines_.line());
  return std::nullopt;
}

void PlayerLog::watch_stamp(const Event& event) {
  const bool scan = std::holds_alternative<Scan>(event);
  std::optional<Time>& last = scan ? last_scan_ : last_odometry_;
  const Time time = time_of(event);
  if (last && time < *last)
    report_.count(scan ? kScansBackwards : kOdometryBackwards, lines_.line());
  last = time;
}

void PlayerLog::finish() {
  if (finished_) return;
  finished_ = true;
  const Report below = lines_.report();
  for (const auto& [what, entry] : below.entries()) report_.add(what, entry);
}

std::optional<Event> PlayerLog::next() {
  while (const auto line = lines_.next()) {
    if (!lines_.terminated()) {
      report_.count(kCutOff, lines_.line());
      break;
    }
    std::optional<Event> event = read_line(*line);
    if (!event) continue;
    watch_stamp(*event);
    return event;
  }
  finish();
  return std::nullopt;
}

}  // namespace majak::io
