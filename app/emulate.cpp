// SPDX-License-Identifier: Apache-2.0
#include "app/emulate.hpp"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "app/live.hpp"
#include "majak/core/error.hpp"
#include "majak/io/atomic_file.hpp"
#include "majak/io/options_file.hpp"
#include "majak/io/serial_port.hpp"
#include "majak/io/source.hpp"
#include "majak/io/tcp.hpp"
#include "majak/sensor/cola_emulator.hpp"
#include "majak/sensor/lms_emulator.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/plan.hpp"
#include "majak/sim/robot.hpp"
#include "majak/sim/tour.hpp"
#include "majak/sim/world.hpp"

namespace majak::app {
namespace {

namespace fs = std::filesystem;
using sensor::Variant;

struct EmulateOptions {
  std::string source = "building", link, eeprom, device = "lms291";
  std::vector<std::string> set;
  int seed = 1, baud = 9600, address = 0;
  double boot = 2, cell = 0, noise = 1, duration = 0;
  std::optional<int> tcp;
};

// What the laser sees at a time (s since the first scan that somebody wanted), beam by beam.
using View = std::function<std::vector<double>(double seconds, const Variant& variant)>;

// A robot drives through a world, and stands at the end of its tour.
class WorldView {
 public:
  WorldView(sim::Scene scene, int seed, double noise)
      : world_(std::move(scene)),
        run_(sim::drive_path(sim::plan_tour(world_, {}), {}, static_cast<std::uint64_t>(seed))),
        seed_(static_cast<std::uint64_t>(seed)),
        noise_(errors(noise), RandomStream(seed_, 1)) {}

  std::vector<double> operator()(double seconds, const Variant& variant) {
    std::vector<double> ranges(static_cast<std::size_t>(variant.beams()));
    const Time begin = from_seconds(seconds);
    for (int i = 0; i < variant.beams(); ++i) {
      const Pose2 laser = run_.truth(begin + sensor::beam_time(variant, i)) * Pose2{0.1, 0, 0};
      const double angle = laser.theta + variant.start_angle() + i * variant.angle_step();
      const sim::Hit hit = world_.cast(laser.translation(), angle, kFarthest);
      RandomStream beam(seed_, static_cast<std::uint64_t>(begin), static_cast<std::uint64_t>(i));
      ranges[static_cast<std::size_t>(i)] = static_cast<double>(
          noise_.simulate_range(hit.range, hit.incidence, hit.reflectivity, beam));
    }
    return ranges;
  }

 private:
  static constexpr double kFarthest = 81;  // m
  // The device rounds by itself, and knows its limits.
  static sensor::RangeNoiseOptions errors(double factor) {
    sensor::RangeNoiseOptions o;
    o.max_range = kFarthest;
    o.quantum = 0;
    o.systematic_error *= factor;
    o.statistical_error *= factor;
    o.no_return *= factor;
    return o;
  }

  sim::World world_;
  sim::RobotRun run_;
  std::uint64_t seed_;
  sensor::RangeNoise noise_;
};

// The scans of a log or recording, each until the next one's time.
class LogView {
 public:
  explicit LogView(const std::string& log) : source_(io::open_log(log)) {
    now_ = read();
    if (!now_) throw Error(fmt::format("{}: no laser scans in this log", log));
    begin_ = now_->time;
    next_ = read();
  }

  std::vector<double> operator()(double seconds, const Variant& variant) {
    while (next_ && to_seconds(next_->time - begin_) <= seconds) {
      now_ = std::move(next_);
      next_ = read();
    }
    std::vector<double> ranges(static_cast<std::size_t>(variant.beams()));
    for (int i = 0; i < variant.beams(); ++i) {
      const double angle = variant.start_angle() + i * variant.angle_step();
      const auto beam = std::lround((angle - now_->start_angle) / now_->angle_step);
      const bool there = beam >= 0 && beam < static_cast<long>(now_->ranges.size());
      ranges[static_cast<std::size_t>(i)] =
          there ? static_cast<double>(now_->ranges[static_cast<std::size_t>(beam)])
                : std::numeric_limits<double>::infinity();
    }
    return ranges;
  }

 private:
  std::optional<Scan> read() {
    while (auto event = source_->next())
      if (auto* scan = std::get_if<Scan>(&*event); scan && scan->laser == 0)
        return std::move(*scan);
    return std::nullopt;
  }
  std::unique_ptr<io::Source> source_;
  std::optional<Scan> now_, next_;
  Time begin_ = 0;
};

View view_of(const EmulateOptions& o) {
  const auto names = sim::built_in_names();
  const auto world = [&](sim::Scene scene) {
    return View([v = std::make_shared<WorldView>(std::move(scene), o.seed, o.noise)](
                    double t, const Variant& variant) { return (*v)(t, variant); });
  };
  if (std::find(names.begin(), names.end(), o.source) != names.end() || !fs::exists(o.source))
    return world(sim::built_in(o.source));
  const std::string extension = fs::path(o.source).extension().string();
  if (extension == ".txt" || extension == ".png") return world(sim::read_plan(o.source, o.cell));
  return [v = std::make_shared<LogView>(o.source)](double t, const Variant& variant) {
    return (*v)(t, variant);
  };
}

// A name that does not change from run to run; taken back at the end.
class Link {
 public:
  Link(const std::string& device, const std::string& name) : name_(name) {
    if (name_.empty()) return;
    std::error_code error;
    if (fs::is_symlink(name_, error)) fs::remove(name_, error);
    fs::create_symlink(device, name_, error);
    if (error) throw Error(fmt::format("{}: {}", name_, error.message()));
  }
  ~Link() {
    std::error_code error;
    if (!name_.empty()) fs::remove(name_, error);
  }
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

 private:
  std::string name_;
};

std::vector<std::uint8_t> read_bytes(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

sensor::LmsEmulatorOptions device_options(const EmulateOptions& o) {
  sensor::LmsEmulatorOptions d =
      o.device == "lms200" ? sensor::lms200_recorded() : sensor::lms291_s05();
  d.baud = o.baud;
  d.permanent_baud = o.baud != 9600;  // or it would not begin with it
  d.address = static_cast<std::uint8_t>(o.address);
  d.boot = from_seconds(o.boot);
  d.seed = static_cast<std::uint64_t>(o.seed);
  if (o.eeprom.empty()) return d;
  const auto kept = read_bytes(o.eeprom);
  if (sensor::LmsConfiguration::is_size(kept.size()))
    d.configuration.raw = kept;
  else if (!kept.empty())
    throw Error(fmt::format("{}: {} bytes are no configuration of an LMS-2xx (34 or 32 are)",
                            o.eeprom, kept.size()));
  return d;
}

// Bytes leave when they have left the device's line, not before.
void run_lms(const EmulateOptions& o, const sensor::LmsFaults& faults, const View& view) {
  const RunEnd end(o.duration);
  const Time start = live_clock();
  std::optional<Time> first;
  sensor::LmsEmulator device(
      device_options(o),
      [&](Time first_beam, const Variant& variant) {
        if (!first) first = first_beam;
        return view(to_seconds(first_beam - *first), variant);
      },
      start);
  device.set_faults(faults);
  auto terminal = std::make_optional<io::PseudoTerminal>();
  auto link = std::make_optional<Link>(terminal->device(), o.link);
  fmt::print("{}\n", o.link.empty() ? terminal->device() : o.link);
  std::fflush(stdout);
  auto kept = device.configuration();
  std::array<std::uint8_t, 4096> buffer;
  while (!end.reached()) {
    const Time now = live_clock();
    if (device.unplugged(now)) {
      link.reset();
      terminal.reset();
    } else if (!terminal) {
      terminal.emplace();
      link.emplace(terminal->device(), o.link);
    }
    if (!terminal) {
      device.advance(now);
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      continue;
    }
    if (const std::size_t n = terminal->read(buffer); n > 0)
      device.receive({buffer.data(), n}, terminal->baud(), now);
    for (const sensor::Chunk& chunk : device.transmit(now, terminal->baud()))
      terminal->write(chunk.bytes);
    if (!(device.configuration() == kept)) {
      kept = device.configuration();
      if (!o.eeprom.empty())
        io::write_file_atomically(o.eeprom, std::string(kept.raw.begin(), kept.raw.end()));
    }
    // Several bytes at a time: nobody on a computer sees them one by one.
    const Time next = std::max(device.next_event(), now + kSecond / 1000);
    terminal->wait_readable(std::clamp<Duration>(next - now, 0, kSecond / 20));
  }
}

void run_cola(const EmulateOptions& o, const View& view) {
  const RunEnd end(o.duration);
  const Time start = live_clock();
  sensor::ColaEmulatorOptions d;
  d.boot_time = o.boot;
  d.start_angle = -90, d.angle_step = 0.5, d.beams = 361;
  d.identity.name = "LMS10x_FieldEval";
  std::optional<Time> first;
  sensor::ColaEmulator device(
      d,
      [&](Time first_beam) {
        if (!first) first = first_beam;
        return view(to_seconds(first_beam - *first), Variant{180, 50});
      },
      start);
  const io::TcpServer server(static_cast<std::uint16_t>(*o.tcp));
  fmt::print("tcp://127.0.0.1:{}\n", server.port());
  std::fflush(stdout);
  std::array<std::uint8_t, 4096> buffer;
  while (!end.reached()) {
    device.advance(live_clock());
    const auto guest = server.accept(kSecond / 10);
    if (!guest) continue;
    device.connected();
    try {
      while (!end.reached()) {
        const Duration wait =
            std::clamp<Duration>(device.wake_at() - live_clock(), 0, kSecond / 20);
        if (guest->wait_readable(wait) != io::Descriptor::Ready::no)
          if (const std::size_t n = guest->read(buffer); n > 0)
            device.receive({buffer.data(), n}, live_clock());
        device.advance(live_clock());
        if (const auto out = device.take_output(); !out.empty()) guest->write(out);
      }
    } catch (const Error&) {  // gone; the next one may come
    }
  }
}

void run(EmulateOptions& o) {
  if (o.device != "lms291" && o.device != "lms200")
    throw Error(fmt::format("--device {}: choose lms291 or lms200", o.device));
  sensor::LmsFaults faults;
  OptionFields fields;
  sensor::describe(fields, faults);
  for (const std::string& assignment : o.set) io::apply_option(fields, assignment);
  const View view = view_of(o);
  if (o.tcp)
    run_cola(o, view);
  else
    run_lms(o, faults, view);
}

}  // namespace

void add_emulate(CLI::App& app) {
  auto o = std::make_shared<EmulateOptions>();
  CLI::App* command = app.add_subcommand(
      "emulate",
      "A SICK laser that is not there, for drivers and tests: an LMS-2xx on a pseudo-terminal.\n\n"
      "Examples:\n"
      "  majak emulate --link /tmp/lms                a robot drives through a building\n"
      "  majak emulate my.log --link /tmp/lms         the scans of a log or recording\n"
      "  majak emulate --set fault.drop=0.001 --set fault.reset_at=30 --link /tmp/lms\n"
      "  majak emulate --tcp 2112                     a newer SICK (CoLa) on the network\n\n"
      "Says the name of its port and then behaves like the device, until Ctrl-C. The robot sets "
      "off\n"
      "with the first scan that somebody wants.\n");
  command->add_option("SOURCE", o->source,
                      "building, ring, corridor, yard, park, a plan (.txt, .png), a log or a "
                      "recording");
  command->add_option("--link", o->link, "a name for the port, as a symbolic link");
  command->add_option("--device", o->device, "lms291 (fresh) or lms200 (as one was recorded)");
  command->add_option("--baud", o->baud, "at power-on")
      ->check(CLI::IsMember({9600, 19200, 38400, 500000}));
  command->add_option("--boot", o->boot, "s, silent after power-on")->check(CLI::Range(0.0, 600.0));
  command->add_option("--address", o->address, "of the device")->check(CLI::Range(0, 127));
  command->add_option("--eeprom", o->eeprom, "a file that keeps the configuration");
  command->add_option("--tcp", o->tcp, "a newer SICK at this port of this machine; 0: any")
      ->check(CLI::Range(0, 65535));
  command->add_option("--seed", o->seed, "of noise and faults")->check(CLI::NonNegativeNumber);
  command->add_option("--noise", o->noise, "times the laser's usual errors")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--cell", o->cell, "m a character or pixel of a plan");
  command->add_option("--duration", o->duration, "s, until Ctrl-C where not given")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--set", o->set, "faults: fault.drop=0.001 ...");
  command->callback([o] { run(*o); });
}

}  // namespace majak::app
