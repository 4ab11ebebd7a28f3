// SPDX-License-Identifier: Apache-2.0
#include "app/record.hpp"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <ctime>
#include <memory>
#include <string>

#include "app/live.hpp"
#include "app/progress.hpp"
#include "app/viewer.hpp"
#include "app/work_view.hpp"
#include "majak/core/error.hpp"
#include "majak/io/recording.hpp"

namespace majak::app {
namespace {

struct RecordOptions {
  std::string port, output;
  DeviceOptions device;
  bool view = false;  // show it on a page meanwhile
  ViewerOptions viewer;
};

// "lms-20260714-183012.mcap"
std::string default_name() {
  const std::time_t now = std::time(nullptr);
  std::tm t{};
  localtime_r(&now, &t);
  return fmt::format("lms-{:04}{:02}{:02}-{:02}{:02}{:02}.mcap", t.tm_year + 1900, t.tm_mon + 1,
                     t.tm_mday, t.tm_hour, t.tm_min, t.tm_sec);
}

void run(const RecordOptions& o) {
  if (!is_device(o.port))
    throw Error(
        fmt::format("{}: is no device; majak record wants a serial port or tcp://host", o.port));
  const std::string name = o.output.empty() ? default_name() : o.output;
  const RunEnd end(o.device.duration);
  Progress progress;
  std::unique_ptr<io::RecordingWriter> recording;
  const auto keep = [&](std::span<const std::uint8_t> telegram, Time first_byte) {
    recording->add_telegram(telegram, first_byte);
  };
  const auto source = open_device(o.port, o.device, end, progress, keep);
  recording = std::make_unique<io::RecordingWriter>(
      name, telegrams_of(o.port));  // not before the port is there
  std::unique_ptr<Viewer> viewer;
  std::unique_ptr<WorkView> view;
  if (o.view) {
    viewer = std::make_unique<Viewer>(o.viewer);
    view = std::make_unique<WorkView>(*viewer, o.port, "recording", map::OccupancyGridOptions{});
  }
  while (const auto event = source->next()) {
    const auto* scan = std::get_if<Scan>(&*event);
    if (scan == nullptr) continue;
    recording->add_scan(*scan, live_clock());
    if (view) view->show(*scan);
  }
  progress.clear();
  recording->close();
  fmt::print("{} scans\n", recording->scans());
  for (const auto& [what, entry] : source->report().entries())
    fmt::print("  {} x {}\n", entry.count, what);
  fmt::print("recording: {}\n", name);
  if (recording->scans() == 0)
    throw Error(fmt::format("{}: no scan came; docs/SENSOR.md tells what to look at", o.port));
}

}  // namespace

void add_record(CLI::App& app) {
  auto options = std::make_shared<RecordOptions>();
  CLI::App* command = app.add_subcommand(
      "record",
      "From a live SICK laser into a recording (MCAP: ROS 2 LaserScan, and the telegrams).\n\n"
      "Examples:\n"
      "  majak record /dev/ttyUSB0                      until Ctrl-C\n"
      "  majak record /dev/ttyUSB0 -o hall.mcap --duration 60\n"
      "  majak record /dev/ttyUSB0 --baud 500000 --resolution 180/0.5\n"
      "  majak record tcp://192.168.0.1                 an LMS1xx, LMS5xx or TiM\n"
      "  majak record /dev/ttyUSB0 --view               watched in the browser\n\n"
      "Nothing has to be known of the device: its rate is found, and it is waited for while it\n"
      "boots. A recording that is cut off opens all the same, less its last second.\n");
  command
      ->add_option("PORT", options->port,
                   "serial port, or tcp://host:port of an LMS1xx, LMS5xx, TiM")
      ->required();
  command->add_option("-o,--output", options->output, "the recording; default: lms-DATE-TIME.mcap");
  add_device_options(*command, options->device);
  command->add_flag("--view", options->view, "show the scans on a page in the browser meanwhile");
  add_viewer_options(*command, options->viewer);
  command->callback([options] { run(*options); });
}

}  // namespace majak::app
