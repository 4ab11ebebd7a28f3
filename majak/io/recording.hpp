// SPDX-License-Identifier: Apache-2.0
// Recording: what a laser sent, as an MCAP file that the tools of ROS 2 open: /scan holds
// LaserScan messages, /telegrams the device's own bytes, so that a recording can be played into
// the emulator. It reads back as any other MCAP file.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "majak/core/event.hpp"
#include "majak/io/mcap_writer.hpp"
#include "majak/io/ros_messages.hpp"

namespace majak::io {

inline constexpr const char* kScanTopic = "/scan";
inline constexpr const char* kTelegramTopic = "/telegrams";
inline constexpr const char* kLaserFrame = "laser";

/// Definitions of message types and what they need, as MCAP files carry them.
std::string laser_scan_definition();
std::string odometry_definition();
std::string transform_list_definition();
std::string ackermann_drive_definition();
std::string nav_sat_fix_definition();
std::string occupancy_grid_definition();

class RecordingWriter {
 public:
  /// An empty file in the place of whatever was there. Throws Error (path, cause). `telegrams`: how
  /// they are encoded, "sick-lms2xx" or "sick-cola".
  RecordingWriter(const std::string& path, const std::string& telegrams);

  void add_scan(const Scan& scan, Time now);
  /// A telegram with all its bytes.
  void add_telegram(std::span<const std::uint8_t> bytes, Time first_byte);
  /// What came until now survives a kill; done by itself once a second.
  void flush();
  void close();

  std::int64_t scans() const { return scans_; }

 private:
  void flush_now_and_then(Time now);

  GrowingFile file_;
  McapWriter writer_;
  std::uint16_t scan_channel_, telegram_channel_;
  std::int64_t scans_ = 0;
  std::optional<Time> flushed_;
};

}  // namespace majak::io
