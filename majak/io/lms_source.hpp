// SPDX-License-Identifier: Apache-2.0
// LmsSource: a SICK LMS-2xx at a serial port as a Source of scans. It waits for the device as long
// as it takes, and for its cable when that is pulled out.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "majak/io/live_hooks.hpp"
#include "majak/io/serial_port.hpp"
#include "majak/io/source.hpp"
#include "majak/sensor/lms_driver.hpp"
#include "majak/sensor/turn_merger.hpp"

namespace majak::io {

struct LmsSourceOptions {
  sensor::LmsDriverOptions driver;
  /// Turns of an interlaced device (driver.interlaced) are put together to whole scans. At less
  /// than 500000 Bd turns are always missing, and no scan becomes whole.
  bool merge_turns = false;
  double max_range = 0;  ///< m, from which on there is no return; 0: as far as values can state
};

class LmsSource : public Source {
 public:
  /// Throws Error when the port cannot be opened now; what happens later is waited out.
  LmsSource(const std::string& device, const LmsSourceOptions& options, LiveHooks hooks);

  std::optional<Event> next() override;
  const Report& report() const override;
  const std::string& format() const override { return format_; }

  const sensor::LmsDriver& driver() const { return driver_; }

 private:
  void serve();
  void send();
  void reopen();
  void tell();
  std::optional<Event> scan_of(const sensor::LmsDelivery& delivery);
  void note(const sensor::LmsHealth& health);

  std::string device_, format_;
  LmsSourceOptions options_;
  LiveHooks hooks_;
  std::optional<SerialPort> port_;
  sensor::LmsDriver driver_;
  sensor::TurnMerger merger_;
  int baud_ = 0;
  Time next_try_ = 0;
  std::int64_t scans_ = 0, skipped_ = 0;
  Report own_;
  mutable Report all_;
};

}  // namespace majak::io
