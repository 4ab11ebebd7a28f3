// SPDX-License-Identifier: Apache-2.0
#include "app/solid_log.hpp"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <fstream>
#include <utility>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/io/source.hpp"

namespace majak::app {
namespace {

map::TiltTrack read_tilt(const std::string& path) {
  if (path.empty()) return {};
  std::ifstream file(path);
  if (!file) throw Error(path + ": cannot be read");
  std::vector<std::pair<Time, double>> samples;
  double seconds = 0, tilt = 0;
  while (file >> seconds >> tilt) samples.emplace_back(from_seconds(seconds), tilt);
  if (!file.eof() || samples.empty())
    throw Error(fmt::format("{}: a line of seconds and radians is expected after {} of them", path,
                            samples.size()));
  return map::TiltTrack(std::move(samples));
}

}  // namespace

void describe(OptionFields& fields, SolidLog& log) {
  map::describe(fields, log.mounting);
  map::describe(fields, log.points);
}

void add_solid_log(CLI::App& command, SolidLog& log) {
  command.add_option("--log", log.log, "the run's log, for its second laser, out of the plane");
  command.add_option("--look", log.look, "that laser looks up (default), left, right, down, level");
  command.add_option("--tilt", log.tilt, "of a laser that nods: a file of lines, seconds radians");
}

std::optional<map::SolidCloud> read_cloud(const Site& site, const SolidLog& log) {
  if (log.log.empty()) return std::nullopt;
  const map::LaserMounting mounting =
      log.look.empty() ? log.mounting : map::looking(log.look, log.mounting);
  map::SolidPoints points(site, mounting, log.points, read_tilt(log.tilt));
  const auto source = io::open_log(log.log);
  std::int64_t scans = 0;
  while (auto event = source->next()) {
    const auto* scan = std::get_if<Scan>(&*event);
    if (scan == nullptr || scan->laser != mounting.laser) continue;
    ++scans;
    points.add(*scan);
  }
  if (scans == 0)
    throw Error(fmt::format("{}: no scan of laser {}; --set mounting.laser=N names another",
                            log.log, mounting.laser + 1));
  if (points.beams() == 0)
    throw Error(log.log + ": no beam of the second laser belongs to this run; is it its log?");
  return points.cloud();
}

}  // namespace majak::app
