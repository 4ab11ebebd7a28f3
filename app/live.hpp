// SPDX-License-Identifier: Apache-2.0
// What a live run needs of the world: a clock, a way to end it, and sources that are devices.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "majak/io/lms_source.hpp"

namespace CLI {
class App;
}

namespace majak::app {

/// While it lives, Ctrl-C (and SIGTERM) does not kill the program but is told by pressed().
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;
  bool pressed() const;
};

/// ns since 1970 at the start, from then on by a clock that nobody sets back.
Time live_clock();

/// A serial port, and no file to be read.
bool is_device(const std::string& name);

/// How a device is to be set; the command line's words for it.
struct DeviceOptions {
  int baud = 0;            // Bd, 0: majak's choice
  std::string resolution;  // "180/0.5": degrees / degrees; empty: as it is
  std::string unit;        // "mm", "cm"; empty: as it is
  double duration = 0;     // s, 0: until Ctrl-C
};
void add_device_options(CLI::App& command, DeviceOptions& options);

/// Throws Error for words that mean nothing, and where the port cannot be opened. `delivered` as in
/// io::LiveHooks. `interrupt` must outlive the source.
std::unique_ptr<io::LmsSource> open_device(
    const std::string& port, const DeviceOptions& options, const Interrupt& interrupt,
    std::function<void(const sensor::LmsDelivery&)> delivered = {});

}  // namespace majak::app
