// SPDX-License-Identifier: Apache-2.0
// ColaEmulator: the device's side of CoLa, an LMS1xx, LMS5xx or TiM whose scans come from whoever
// knows the true ranges. No socket and no clock, like ColaSession.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "majak/core/options.hpp"
#include "majak/core/time.hpp"
#include "majak/sensor/cola.hpp"
#include "majak/sensor/cola_identity.hpp"
#include "majak/sensor/cola_scan.hpp"

namespace majak::sensor {

struct ColaEmulatorOptions {
  ColaDialect dialect = ColaDialect::b;
  double boot_time = 0;          ///< s after power-up in which it hears and says nothing
  double spin_up_time = 0;       ///< s from the order to measure to the first turn
  bool measures_at_once = true;  ///< after power-up; else it waits for LMCstartmeas and Run
  bool knows_stlms = true;       ///< LMS; TiM answers SCdevicestate only
  double mirror_rate = 15;       ///< Hz
  double start_angle = -135;     ///< deg, bearing of the first beam, 0 is ahead
  double angle_step = 1;         ///< deg
  int beams = 271;
  double scale = 1;         ///< mm a digit; 2 for LMS5xx in long ranges
  bool intensities = true;  ///< an 8-bit channel RSSI1
  std::uint32_t serial = 17'225'564;
  std::uint32_t password = 0xF4724744;
  std::uint32_t clock_start = 0;  ///< us that the device's clock shows at power-up
  std::string name = {};          ///< sent with each scan where it is not empty
  ColaIdentity identity{"TiM551", "V2.17-15.08.12"};  ///< no name: the question is refused
};
void describe(OptionFields& fields, ColaEmulatorOptions& options);

class ColaEmulator {
 public:
  /// True ranges in m, one a beam, at the time of the scan's first beam; not finite: no echo. What
  /// is missing counts as no echo.
  using Ranges = std::function<std::vector<double>(Time)>;

  ColaEmulator(const ColaEmulatorOptions& options, Ranges ranges, Time power_up);

  /// Off and on again; the connection is gone.
  void reset(Time now);
  /// Another connection: whoever wants scans has to ask again.
  void connected();
  void receive(std::span<const std::uint8_t> bytes, Time now);
  /// Sends the scans that are through by now. A reader who takes nothing loses scans.
  void advance(Time now);
  /// When the next scan is through.
  Time wake_at() const;
  std::vector<std::uint8_t> take_output();

  bool streams() const { return subscribed_; }
  std::int64_t scans_sent() const { return scans_sent_; }
  /// When the first beam of the turn with this number is fired.
  Time turn_start(std::int64_t turn) const;

 private:
  static constexpr std::size_t kMostOutput = 1 << 20;

  bool measures(Time now) const;
  Time sent_at(std::int64_t turn) const;
  std::int64_t turns_through(Time now) const;
  void obey(const ColaTelegram& command, Time now);
  void call(const ColaTelegram& command, Time now);
  void read(const ColaTelegram& command, Time now);
  void write(const ColaTelegram& command);
  void event(const ColaTelegram& command, Time now);
  void say(const ColaWriter& telegram);
  void refuse(unsigned code);
  void start_measuring(Time now);
  ColaScan measure(std::int64_t turn);
  std::uint32_t clock(Time time) const;

  ColaEmulatorOptions options_;
  Ranges ranges_;
  ColaFramer framer_;
  ColaDialect dialect_;
  Time power_up_ = 0, ready_ = 0;
  std::optional<Time> first_turn_;  ///< nothing: it does not measure
  std::int64_t next_turn_ = 0;
  std::uint16_t telegrams_ = 0;
  bool authorized_ = false, ordered_ = false, subscribed_ = false, sends_name_ = true;
  bool wide_intensities_ = false;  ///< 16 bits
  std::int64_t scans_sent_ = 0;
  std::vector<std::uint8_t> output_;
};

}  // namespace majak::sensor
