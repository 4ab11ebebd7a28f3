// SPDX-License-Identifier: Apache-2.0
#include "app/info.hpp"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "app/log_options.hpp"
#include "app/sheet.hpp"
#include "majak/core/error.hpp"
#include "majak/io/log_summary.hpp"
#include "majak/io/source.hpp"

namespace majak::app {
namespace {

using Json = nlohmann::ordered_json;
using io::LaserSummary;
using io::LogSummary;
using io::StampSummary;

struct InfoOptions {
  std::string log;
  io::SourceOptions source;
  bool json = false;
};

double share(std::int64_t part, std::int64_t whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0.0;
}

std::string laser_name(int number) {
  if (number == 0) return "laser 1 (front)";
  if (number == 1) return "laser 2 (rear)";
  return fmt::format("laser {}", number + 1);
}

/// A heading of one sensor, then its lines.
template <class... Args>
void line(const char* label, fmt::format_string<Args...> text, Args&&... args) {
  fmt::print("  {:<17} {}\n", label, fmt::format(text, std::forward<Args>(args)...));
}

void print_stamps(const StampSummary& s) {
  line("records", "{}, {:.2f} Hz over {:.1f} s", s.count, s.rate(), to_seconds(s.duration()));
  if (s.gaps > 0) {
    line("gaps over 1 s", "{}, the longest {:.2f} s after {:.6f} s", s.gaps,
         to_seconds(s.longest_gap), to_seconds(s.longest_gap_after));
  }
  if (s.backwards > 0) {
    line("stamps back", "{} run backwards, by up to {:.3f} s", s.backwards,
         to_seconds(s.worst_backwards));
  }
  if (s.repeated > 0) line("stamps again", "{} equal the one before", s.repeated);
}

void print_laser(int number, const LaserSummary& l) {
  fmt::print("\n{}\n", laser_name(number));
  print_stamps(l.stamps);
  const std::string beams = l.fewest_beams == l.most_beams
                                ? fmt::format("{}", l.most_beams)
                                : fmt::format("{} to {}", l.fewest_beams, l.most_beams);
  line("beams x step", "{} x {:.4g} deg", beams, degrees(l.angle_step));
  line("field of view", "{:.4g} deg, from {:.4g} to {:.4g} deg", degrees(l.field_of_view()),
       degrees(l.start_angle), degrees(l.start_angle + l.field_of_view()));
  line("mounting", "x {:.3f} m, y {:.3f} m, turned {:.1f} deg", l.T_robot_laser.x,
       l.T_robot_laser.y, degrees(l.T_robot_laser.theta));
  line("range", "{:.2f} m and more is no return; the longest return is {:.2f} m", l.max_range,
       l.longest_return);
  line("no return", "{:.2f} % of {} beams", 100 * share(l.no_returns, l.beams), l.beams);
  line("invalid", "{:.2f} % of the beams", 100 * share(l.invalid, l.beams));
  if (l.with_intensities > 0) line("intensities", "in {} scans", l.with_intensities);
}

void print_path(const io::PathSummary& path) {
  line("path", "{:.1f} m, turned by {:.0f} deg in all", path.length, degrees(path.turned));
}

void print_others(const LogSummary& s) {
  fmt::print("\nodometry\n");
  if (s.odometry.count > 0) {
    print_stamps(s.odometry);
    print_path(s.odometry_path);
    line("velocities", "in {:.1f} % of the records",
         100 * share(s.odometry_with_speed, s.odometry.count));
  } else if (s.odometry_path.last) {
    line("records", "none of its own; the scans state it");
    print_path(s.odometry_path);
  } else {
    line("records", "none");
  }
  if (s.wheels.count > 0) {
    fmt::print("\nwheel speed and steering\n");
    print_stamps(s.wheels);
    line("path", "{:.1f} m", s.wheel_path);
  }
  if (s.gps.count > 0) {
    fmt::print("\nGPS\n");
    print_stamps(s.gps);
    line("extent", "{:.1f} m east-west, {:.1f} m north-south", s.gps_east[1] - s.gps_east[0],
         s.gps_north[1] - s.gps_north[0]);
  }
  if (s.truth.count > 0) {
    fmt::print("\ntrue poses\n");
    print_stamps(s.truth);
    print_path(s.truth_path);
  }
}

void print_skipped(const Report& report) {
  fmt::print("\nnoticed\n");
  if (report.empty()) fmt::print("  nothing: every record was read\n");
  for (const auto& [what, entry] : report.entries()) {
    const std::string first =
        entry.first_line > 0 ? fmt::format("  (first: line {})", entry.first_line) : "";
    fmt::print("  {:>8}  {}{}\n", entry.count, what, first);
  }
}

void print_for_people(const InfoOptions& options, const io::Source& source, const LogSummary& s) {
  fmt::print("{}: {}\n", options.log, source.format());
  fmt::print("{:.1f} s, from {:.6f} to {:.6f} s\n", to_seconds(s.latest() - s.earliest()),
             to_seconds(s.earliest()), to_seconds(s.latest()));
  for (const auto& [number, laser] : s.lasers) print_laser(number, laser);
  print_others(s);
  print_skipped(source.report());
}

Json to_json(const StampSummary& s) {
  return {{"records", s.count},
          {"rate_hz", s.rate()},
          {"duration_s", to_seconds(s.duration())},
          {"gaps_over_1_s", s.gaps},
          {"longest_gap_s", to_seconds(s.longest_gap)},
          {"stamps_backwards", s.backwards},
          {"worst_backwards_s", to_seconds(s.worst_backwards)},
          {"stamps_repeated", s.repeated}};
}

Json to_json(const LaserSummary& l) {
  Json json = to_json(l.stamps);
  json.update({{"beams", l.most_beams},
               {"fewest_beams", l.fewest_beams},
               {"angle_step_deg", degrees(l.angle_step)},
               {"start_angle_deg", degrees(l.start_angle)},
               {"field_of_view_deg", degrees(l.field_of_view())},
               {"mounting_x_m", l.T_robot_laser.x},
               {"mounting_y_m", l.T_robot_laser.y},
               {"mounting_deg", degrees(l.T_robot_laser.theta)},
               {"max_range_m", l.max_range},
               {"longest_return_m", l.longest_return},
               {"ranges", l.beams},
               {"no_returns", l.no_returns},
               {"invalid", l.invalid},
               {"scans_with_odometry", l.with_odometry},
               {"scans_with_intensities", l.with_intensities}});
  return json;
}

Json to_json(const InfoOptions& options, const io::Source& source, const LogSummary& s) {
  Json json{{"log", options.log},
            {"format", source.format()},
            {"duration_s", to_seconds(s.latest() - s.earliest())}};
  json["lasers"] = Json::array();
  for (const auto& [number, laser] : s.lasers) {
    Json entry{{"laser", number + 1}};
    entry.update(to_json(laser));
    json["lasers"].push_back(std::move(entry));
  }
  json["odometry"] = to_json(s.odometry);
  json["odometry"]["path_m"] = s.odometry_path.length;
  json["odometry"]["turned_deg"] = degrees(s.odometry_path.turned);
  json["odometry"]["records_with_velocity"] = s.odometry_with_speed;
  json["wheels"] = to_json(s.wheels);
  json["wheels"]["path_m"] = s.wheel_path;
  json["gps"] = to_json(s.gps);
  json["gps"]["east_m"] = s.gps_east[1] - s.gps_east[0];
  json["gps"]["north_m"] = s.gps_north[1] - s.gps_north[0];
  json["truth"] = to_json(s.truth);
  json["truth"]["path_m"] = s.truth_path.length;
  json["noticed"] = Json::array();
  for (const auto& [what, entry] : source.report().entries()) {
    json["noticed"].push_back(
        {{"what", what}, {"count", entry.count}, {"first_line", entry.first_line}});
  }
  return json;
}

void run(const InfoOptions& options) {
  if (options.log == "lms291") return print_lms291_sheet(options.json);
  const auto source = io::open_log(options.log, options.source);
  LogSummary summary;
  while (const auto event = source->next()) summary.add(*event);
  if (summary.scans() == 0 && summary.gps.count == 0) {
    std::string why;
    for (const auto& [what, entry] : source->report().entries()) {
      why = fmt::format("; {} {} (first: line {})", entry.count, what, entry.first_line);
      break;
    }
    throw Error(fmt::format("{}: {} without a single laser scan ({} other records{})", options.log,
                            source->format(), summary.events(), why));
  }
  if (options.json) {
    fmt::print(
        "{}\n",
        to_json(options, *source, summary).dump(2, ' ', false, Json::error_handler_t::replace));
  } else {
    print_for_people(options, *source, summary);
  }
}

}  // namespace

void add_info(CLI::App& app) {
  auto options = std::make_shared<InfoOptions>();
  CLI::App* command = app.add_subcommand(
      "info",
      "What is in a log: sensors, rates, gaps, path, what was skipped and why.\n\n"
      "Examples:\n"
      "  majak info intel.clf.bz2          what is in it\n"
      "  majak info victoria_park          a folder is a log, too\n"
      "  majak info robot.log --json       the same for a script\n"
      "  majak info lms291                 the sheet of this sensor\n");
  command->add_option("LOG", options->log, "a log, a recording or a folder; or lms291")->required();
  add_log_options(*command, options->source);
  command->add_flag("--json", options->json, "print JSON");
  command->callback([options] { run(*options); });
}

}  // namespace majak::app
