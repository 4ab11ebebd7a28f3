// SPDX-License-Identifier: Apache-2.0
// The Victoria Park data set (Guivant and Nebot): a folder with LASER.txt[.gz], DRS.txt (wheel
// speed and steering), GPS.txt and Sensors_manager.txt, which says in which order they were
// recorded.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "majak/io/line_reader.hpp"
#include "majak/io/source.hpp"
#include "majak/io/word_reader.hpp"

namespace majak::io {

/// The car that drove there.
struct VictoriaParkCar {
  double wheelbase = 2.83;   ///< m
  double half_track = 0.76;  ///< m, rear left wheel (it carries the encoder) to the axle's middle
  Pose2 T_robot_laser{3.78, 0.5, 0};  ///< from the middle of the rear axle
};

class VictoriaPark final : public Source {
 public:
  /// The streams of the four files; `gps` and `order` may be null. Without `order` the records are
  /// merged by time.
  struct Files {
    std::unique_ptr<ByteStream> laser, drive, gps, order;
  };
  explicit VictoriaPark(Files files, const VictoriaParkCar& car = {});

  std::optional<Event> next() override;
  const Report& report() const override { return report_; }
  const std::string& format() const override { return format_; }

 private:
  enum Sensor : std::size_t { gps, drive, laser, sensors };
  using Table = std::unique_ptr<LineReader>;
  using Row = std::array<double, 3>;

  void load(Sensor sensor);
  std::optional<Scan> read_scan();
  std::optional<WheelMotion> read_drive();
  std::optional<GpsFix> read_fix();
  bool read_row(Table& table, Row& row, const char* problem);
  bool find_next_scan(WordReader& words, double& time);
  std::optional<Sensor> next_in_order();
  std::optional<Sensor> earliest() const;
  void finish();

  VictoriaParkCar car_;
  std::unique_ptr<WordReader> laser_;
  Table gps_, drive_, order_;
  std::optional<Event> waiting_[sensors];
  std::optional<double> last_scan_time_;  ///< s
  std::int64_t scans_ = 0;
  bool loaded_ = false, finished_ = false;
  std::string format_ = "Victoria Park folder";
  Report report_;
};

/// Nothing when the folder does not hold such a data set. Throws majak::Error when a file of it
/// cannot be opened.
std::unique_ptr<Source> open_victoria_park(const std::filesystem::path& folder);

}  // namespace majak::io
