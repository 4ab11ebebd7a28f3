// SPDX-License-Identifier: Apache-2.0
#include "majak/io/recording.hpp"

#include "majak/io/ros_scan.hpp"

namespace majak::io {
namespace {

constexpr Duration kFlushEvery = kSecond;
const std::string kRule(80, '=');

}  // namespace

std::string laser_scan_definition() {
  return "std_msgs/Header header\n"
         "float32 angle_min\n"
         "float32 angle_max\n"
         "float32 angle_increment\n"
         "float32 time_increment\n"
         "float32 scan_time\n"
         "float32 range_min\n"
         "float32 range_max\n"
         "float32[] ranges\n"
         "float32[] intensities\n" +
         kRule +
         "\nMSG: std_msgs/Header\n"
         "builtin_interfaces/Time stamp\n"
         "string frame_id\n" +
         kRule +
         "\nMSG: builtin_interfaces/Time\n"
         "int32 sec\n"
         "uint32 nanosec\n";
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
