// SPDX-License-Identifier: Apache-2.0
// PlayerLog: a log of Player's writelog driver (file version 0.3.0) as a Source: laser scans with
// or without the pose beside them, position2d odometry, and the mounting that the laser reports.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "majak/core/event.hpp"
#include "majak/io/line_reader.hpp"
#include "majak/io/number.hpp"
#include "majak/io/source.hpp"

namespace majak::io {

/// Does this text contain a line that only a Player log would?
bool looks_like_player(std::string_view text);

class PlayerLog final : public Source {
 public:
  /// Throws Error for an angle step that cannot be.
  explicit PlayerLog(std::unique_ptr<ByteStream> bytes, std::string format = "Player log",
                     const SourceOptions& options = {});

  std::optional<Event> next() override;
  const Report& report() const override { return report_; }
  const std::string& format() const override { return format_; }

 private:
  struct Head;

  std::optional<Event> read_line(std::string_view line);
  std::optional<Event> read_laser(const Head& head, Fields& fields);
  std::optional<Event> read_angled_scan(Scan scan, Fields& fields);
  std::optional<Event> read_position(const Head& head, Fields& fields);
  void read_mounting(int index, Fields& fields);
  void place(Scan& scan, int index);
  bool read_ranges(Fields& fields, std::size_t count, Scan& scan);
  std::nullopt_t damaged();
  void watch_stamp(const Event& event);
  void finish();

  LineReader lines_;
  std::string format_;
  SourceOptions options_;
  std::map<int, Pose2> T_robot_laser_;  ///< by the index of the interface
  std::optional<Time> last_scan_, last_odometry_;
  bool finished_ = false;
  Report report_;
};

}  // namespace majak::io
