// SPDX-License-Identifier: Apache-2.0
// What a live run needs of the world: a clock, a way to end it, and sources that are devices.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "majak/io/live_hooks.hpp"
#include "majak/io/source.hpp"

namespace CLI {
class App;
}

namespace majak::app {

/// When a live run ends: after a time, or by Ctrl-C (or SIGTERM), which does not kill the program
/// while this lives.
class RunEnd {
 public:
  explicit RunEnd(double seconds);  ///< 0: only by Ctrl-C
  ~RunEnd();
  RunEnd(const RunEnd&) = delete;
  RunEnd& operator=(const RunEnd&) = delete;
  bool reached() const;

 private:
  Time end_;
};

/// ns since 1970 at the start, from then on by a clock that nobody sets back.
Time live_clock();

/// A serial port or tcp://host, and no file to be read.
bool is_device(const std::string& name);

/// How a device's telegrams are encoded, for a recording.
std::string telegrams_of(const std::string& device);

/// How a device is to be set; the command line's words for it.
struct DeviceOptions {
  int baud = 0;              // Bd, 0: majak's choice
  std::string resolution;    // "180/0.5": degrees / degrees; empty: as it is
  std::string unit;          // "mm", "cm"; empty: as it is
  bool interlaced = false;   // every turn of the mirror is a scan
  bool merge_turns = false;  // of the interlaced device, to whole scans
  double max_range = 0;      // m, 0: as the device says
  double duration = 0;       // s, 0: until Ctrl-C
};
void add_device_options(CLI::App& command, DeviceOptions& options);

class Progress;
using KeepTelegram = std::function<void(std::span<const std::uint8_t>, Time)>;

/// Throws Error for words that mean nothing, and where the port cannot be opened. `telegram` as in
/// io::LiveHooks. `progress` shows what the device does and how many scans have come. It and `end`
/// must outlive the source.
std::unique_ptr<io::Source> open_device(const std::string& port, const DeviceOptions& options,
                                        const RunEnd& end, Progress& progress,
                                        KeepTelegram telegram);

}  // namespace majak::app
