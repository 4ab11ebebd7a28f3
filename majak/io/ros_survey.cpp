// SPDX-License-Identifier: Apache-2.0
#include "majak/io/ros_survey.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "majak/core/error.hpp"
#include "majak/io/no_return.hpp"
#include "majak/io/ros_scan.hpp"

namespace majak::io {

namespace {

// How far to look: until the robot has driven some metres, but not through a whole long recording.
constexpr int kLeastScans = 200, kMostScans = 2000;
constexpr double kPathToSee = 10.0;  // m
constexpr std::size_t kMostBytes = std::size_t{1} << 28;
constexpr std::size_t kDelays = 200;
constexpr Duration kClocksApart = 2 * kSecond;

using Names = std::set<std::string>;

Names names_of(const std::vector<Topic>& topics, std::string_view type) {
  Names names;
  for (const Topic& topic : topics)
    if (topic.encoding && topic.type == type) names.insert(topic.name);
  return names;
}

std::string listed(const Names& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

/// The topics of the recording, without unpacking it where its end lists them.
std::vector<Topic> topics_of(const OpenMessages& open) {
  Message message;
  for (const Depth depth : {Depth::topics, Depth::messages}) {
    const auto log = open(depth);
    while (log->next(message)) {
    }
    if (!log->topics().empty()) return log->topics();
  }
  return {};
}

std::string choose_scans(const Names& lasers, const std::vector<Topic>& topics,
                         const std::string& wanted) {
  const bool useful = !lasers.empty() || !names_of(topics, "nav_msgs/Odometry").empty() ||
                      !names_of(topics, "sensor_msgs/NavSatFix").empty();
  if (!useful) {
    Names all;
    for (const Topic& topic : topics) all.insert(topic.name + " (" + topic.type + ")");
    throw Error(all.empty()
                    ? "a ROS recording without messages"
                    : "a ROS recording without a sensor_msgs/LaserScan; it has " + listed(all));
  }
  if (!wanted.empty()) {
    for (const std::string& name : lasers)
      if (name == wanted || (name.starts_with('/') && name.substr(1) == wanted)) return name;
    throw Error("no laser scans under the topic " + wanted +
                (lasers.empty() ? "" : "; there are " + listed(lasers)));
  }
  if (lasers.size() > 1)
    throw Error("more than one laser; choose with --topic NAME: " + listed(lasers));
  return lasers.empty() ? std::string() : *lasers.begin();
}

/// The wheels rather than what a filter made of them: the shortest name, "odom" if there is one.
std::string choose_odometry(const Names& names) {
  for (const char* usual : {"/odom", "odom"})
    if (names.contains(usual)) return usual;
  const auto shortest = std::min_element(
      names.begin(), names.end(), [](const auto& a, const auto& b) { return a.size() < b.size(); });
  return shortest == names.end() ? std::string() : *shortest;
}

class Surveyor {
 public:
  explicit Surveyor(RosSurvey& survey) : survey_(survey) {}

  void look(const OpenMessages& open) {
    const auto log = open(Depth::messages);
    Message message;
    while (!enough() && log->next(message)) {
      bytes_ += message.data.size();
      try {
        look_at(log->topics()[message.topic], message);
      } catch (const Error&) {  // counted when its turn comes
      }
    }
    settle();
  }

 private:
  bool enough() const {
    if (bytes_ >= kMostBytes || scans_ >= kMostScans) return true;
    return scans_ >= kLeastScans && path_ >= kPathToSee &&
           (laser_frame_.empty() || connected(choose_robot_frame()));
  }

  bool connected(const std::string& robot) const {
    return !robot.empty() && survey_.frames.find(robot, laser_frame_).has_value();
  }

  void look_at(const Topic& topic, const Message& message) {
    if (!topic.encoding) return;
    if (topic.name == survey_.scan_topic && topic.type == "sensor_msgs/LaserScan") {
      look_at_scan(message, *topic.encoding);
    } else if (topic.name == survey_.odometry_topic && topic.type == "nav_msgs/Odometry") {
      look_at_odometry(message, *topic.encoding);
    } else if (topic.type == "tf2_msgs/TFMessage" || topic.type == "tf/tfMessage") {
      ros::TransformList list;
      ros::decode(message.data, *topic.encoding, list);
      for (const ros::StampedTransform& transform : list.transforms)
        survey_.frames.set_if_new(transform);
    }
  }

  void look_at_scan(const Message& message, ros::Encoding encoding) {
    ros::LaserScan scan;
    ros::decode(message.data, encoding, scan);
    ++scans_;
    laser_frame_ = scan.header.frame;
    note_delay(scan_delays_, message.time, scan.header.stamp);
    Report ignored;
    if (const auto read = scan_of(scan, {}, {}, 0, ignored)) finder_.add(*read);
  }

  void look_at_odometry(const Message& message, ros::Encoding encoding) {
    ros::Odometry odometry;
    ros::decode(message.data, encoding, odometry);
    child_frame_ = odometry.child_frame;
    note_delay(odometry_delays_, message.time, odometry.header.stamp);
    velocity_seen_ |= odometry.linear[0] != 0 || odometry.angular[2] != 0;
    const Pose2 pose = planar_pose(odometry.pose);
    if (last_pose_) path_ += (pose.translation() - last_pose_->translation()).norm();
    last_pose_ = pose;
  }

  static void note_delay(std::vector<Duration>& delays, Time recorded, Time stamp) {
    if (stamp != 0 && delays.size() < kDelays) delays.push_back(recorded - stamp);
  }

  /// What the odometry moves; else the usual names, the one that tf hangs on the odometry first.
  std::string choose_robot_frame() const {
    if (!child_frame_.empty() && (laser_frame_.empty() || connected(child_frame_)))
      return child_frame_;
    std::string best;
    for (const char* usual : {"base_link", "base_footprint", "base"}) {
      if (!connected(usual)) continue;
      if (is_odometry_frame(survey_.frames.parent_of(usual))) return usual;
      if (best.empty()) best = usual;
    }
    return best.empty() ? child_frame_ : best;
  }

  void settle() {
    survey_.robot_frame = choose_robot_frame();
    survey_.code = finder_.code();
    survey_.velocity_missing = !velocity_seen_ && path_ > 0.1;
    if (survey_.odometry_topic.empty()) {
      // From the robot's frame up to the one that dead reckoning is told in.
      std::string frame = survey_.robot_frame;
      for (int i = 0; i < 20 && !frame.empty() && !is_odometry_frame(frame); ++i)
        frame = survey_.frames.parent_of(frame);
      survey_.odometry_from_tf = !frame.empty();
      survey_.odometry_frame = frame;
    }
    if (scan_delays_.empty() || odometry_delays_.empty()) return;
    const auto median = [](std::vector<Duration>& delays) {
      const auto middle = delays.begin() + static_cast<std::ptrdiff_t>(delays.size() / 2);
      std::nth_element(delays.begin(), middle, delays.end());
      return *middle;
    };
    survey_.use_recording_times =
        std::abs(median(scan_delays_) - median(odometry_delays_)) > kClocksApart;
  }

  RosSurvey& survey_;
  SaturationFinder finder_;
  std::string laser_frame_, child_frame_;
  std::vector<Duration> scan_delays_, odometry_delays_;
  std::optional<Pose2> last_pose_;
  double path_ = 0;  ///< m
  int scans_ = 0;
  std::size_t bytes_ = 0;
  bool velocity_seen_ = false;
};

}  // namespace

bool is_odometry_frame(const std::string& frame) {
  return frame == "odom" || frame.starts_with("odom_") || frame.ends_with("/odom");
}

RosSurvey survey_recording(const OpenMessages& open, const std::string& scan_topic) {
  const std::vector<Topic> topics = topics_of(open);
  RosSurvey survey;
  survey.scan_topic = choose_scans(names_of(topics, "sensor_msgs/LaserScan"), topics, scan_topic);
  Names odometry = names_of(topics, "nav_msgs/Odometry");
  for (const std::string& name : Names(odometry))
    if (name.find("ground_truth") != std::string::npos) {
      survey.truth_topic = name;
      odometry.erase(name);
    }
  survey.odometry_topic = choose_odometry(odometry);
  odometry.erase(survey.odometry_topic);
  survey.more_odometry.assign(odometry.begin(), odometry.end());
  const Names fixes = names_of(topics, "sensor_msgs/NavSatFix");
  if (!fixes.empty()) survey.fix_topic = *fixes.begin();
  Surveyor(survey).look(open);
  const Names drives = names_of(topics, "ackermann_msgs/AckermannDriveStamped");
  // Beside odometry they are as a rule what the car is told, not what it does.
  if (!drives.empty() && survey.odometry_topic.empty() && !survey.odometry_from_tf)
    survey.drive_topic = *drives.begin();
  return survey;
}

}  // namespace majak::io
