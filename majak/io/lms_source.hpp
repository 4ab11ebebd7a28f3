// SPDX-License-Identifier: Apache-2.0
// LmsSource: a SICK LMS-2xx at a serial port as a Source of scans. It waits for the device as long
// as it takes, and for its cable when that is pulled out.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "majak/io/serial_port.hpp"
#include "majak/io/source.hpp"
#include "majak/sensor/lms_driver.hpp"

namespace majak::io {

struct LmsSourceOptions {
  sensor::LmsDriverOptions driver;
};

/// What the world outside gives: the library has no clock of its own.
struct LiveHooks {
  std::function<Time()> clock;                       ///< now, in ns since 1970, never backwards
  std::function<bool()> stopped;                     ///< true ends the source
  std::function<void(const std::string&)> activity;  ///< what it is busy with, where that changes
  std::function<void(const sensor::LmsDelivery&)> delivered;  ///< each telegram, before its scan
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

  std::string device_, format_;
  LmsSourceOptions options_;
  LiveHooks hooks_;
  std::optional<SerialPort> port_;
  sensor::LmsDriver driver_;
  int baud_ = 0;
  Time next_try_ = 0;
  std::string told_;
  Report own_;
  mutable Report all_;
};

}  // namespace majak::io
