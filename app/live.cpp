// SPDX-License-Identifier: Apache-2.0
#include "app/live.hpp"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <utility>

#include "app/progress.hpp"
#include "majak/core/error.hpp"
#include "majak/io/cola_source.hpp"
#include "majak/io/lms_source.hpp"

namespace majak::app {
namespace {

constexpr std::uint16_t kColaPort = 2112;

volatile std::sig_atomic_t interrupted = 0;  // a signal handler can reach nothing else

extern "C" void on_signal(int) { interrupted = 1; }

constexpr int kFastBaud = 500000;

// "180/0.5". Of single turns a device with quarters of a degree sends 180 degrees, too.
sensor::Variant variant_of(const std::string& text, bool interlaced) {
  int field = 0;
  double step = 0;
  char end = 0;
  if (std::sscanf(text.c_str(), "%d/%lf%c", &field, &step, &end) == 2) {
    const sensor::Variant wanted{field, static_cast<int>(std::lround(100 * step))};
    for (const sensor::Variant& v : sensor::kVariants)
      if (v == wanted) return v;
    if (interlaced && wanted == sensor::Variant{180, 25}) return {100, 25};
  }
  throw Error(
      fmt::format("--resolution {}: choose 180/1, 180/0.5, 100/1, 100/0.5 or 100/0.25 (degrees){}",
                  text, interlaced ? ", or 180/0.25" : ""));
}

sensor::Unit unit_of(const std::string& text) {
  if (text == "cm") return sensor::Unit::centimetre;
  if (text == "mm") return sensor::Unit::millimetre;
  throw Error(fmt::format("--unit {}: choose cm or mm", text));
}

io::LmsSourceOptions lms_options(const DeviceOptions& options) {
  io::LmsSourceOptions source;
  if (options.merge_turns && options.baud != 0 && options.baud != kFastBaud)
    throw Error(
        fmt::format("--merge-turns: at {} Bd turns get lost; it needs 500000", options.baud));
  source.merge_turns = options.merge_turns;
  source.max_range = options.max_range;
  source.driver.interlaced = options.interlaced || options.merge_turns;
  if (options.merge_turns) source.driver.baud = kFastBaud;
  if (options.baud > 0) source.driver.baud = options.baud;
  if (!options.resolution.empty())
    source.driver.variant = variant_of(options.resolution, source.driver.interlaced);
  if (!options.unit.empty()) source.driver.unit = unit_of(options.unit);
  return source;
}

}  // namespace

RunEnd::RunEnd(double seconds) : end_(seconds > 0 ? live_clock() + from_seconds(seconds) : 0) {
  interrupted = 0;
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
}

RunEnd::~RunEnd() {
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

bool RunEnd::reached() const { return interrupted != 0 || (end_ > 0 && live_clock() >= end_); }

Time live_clock() {
  using namespace std::chrono;
  static const auto offset =
      duration_cast<nanoseconds>(system_clock::now().time_since_epoch()).count() -
      duration_cast<nanoseconds>(steady_clock::now().time_since_epoch()).count();
  return duration_cast<nanoseconds>(steady_clock::now().time_since_epoch()).count() + offset;
}

bool is_device(const std::string& name) {
  std::error_code error;
  return name.starts_with("tcp://") || std::filesystem::is_character_file(name, error);
}

std::string telegrams_of(const std::string& device) {
  return device.starts_with("tcp://") ? "sick-cola" : "sick-lms2xx";
}

void add_device_options(CLI::App& command, DeviceOptions& options) {
  command.add_option("--baud", options.baud, "device: Bd to stream at (500000 needs RS-422)")
      ->check(CLI::IsMember({9600, 19200, 38400, 500000}));
  command.add_option("--resolution", options.resolution,
                     "device: field of view and step, 180/0.5 or the like (degrees)");
  command.add_option("--unit", options.unit,
                     "device: cm or mm; written to its EEPROM if different");
  command.add_flag("--interlaced", options.interlaced,
                   "device: each turn of the mirror is a scan, a beam a degree");
  command.add_flag("--merge-turns", options.merge_turns,
                   "device: interlaced turns put together to whole scans (at 500000 Bd)");
  command
      .add_option("--max-range", options.max_range,
                  "device: m, returns from there on are none; default: as far as it sees")
      ->check(CLI::Range(0.1, 1000.0));
  command.add_option("--duration", options.duration, "device: s, until Ctrl-C where not given")
      ->check(CLI::NonNegativeNumber);
}

std::unique_ptr<io::Source> open_device(const std::string& port, const DeviceOptions& options,
                                        const RunEnd& end, Progress& progress,
                                        KeepTelegram telegram) {
  io::LiveHooks hooks;
  hooks.clock = live_clock;
  hooks.stopped = [&end] { return end.reached(); };
  hooks.status = [&progress](const io::LiveStatus& status) { progress.show(status); };
  hooks.telegram = std::move(telegram);
  if (const auto address = io::parse_tcp(port, kColaPort)) {
    io::ColaSourceOptions source;
    source.scan.max_range = options.max_range;
    return std::make_unique<io::ColaSource>(*address, source, std::move(hooks));
  }
  return std::make_unique<io::LmsSource>(port, lms_options(options), std::move(hooks));
}

}  // namespace majak::app
