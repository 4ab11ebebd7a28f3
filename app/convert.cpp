// SPDX-License-Identifier: Apache-2.0
#include "app/convert.hpp"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>

#include "app/log_options.hpp"
#include "app/progress.hpp"
#include "majak/core/error.hpp"
#include "majak/io/carmen_writer.hpp"
#include "majak/io/mcap_log_writer.hpp"
#include "majak/io/source.hpp"

namespace majak::app {
namespace {

namespace fs = std::filesystem;

struct ConvertOptions {
  std::string from, to;
  io::SourceOptions source;
};

template <class Writer>
std::int64_t copy(io::Source& source, Writer& writer) {
  Progress progress;
  std::int64_t scans = 0;
  while (const auto event = source.next()) {
    writer.write(*event);
    scans += std::holds_alternative<Scan>(*event);
    progress.show("converting", scans);
  }
  return scans;
}

void print_report(const Report& report) {
  for (const auto& [what, entry] : report.entries()) fmt::print("  {} x {}\n", entry.count, what);
}

void run(const ConvertOptions& o) {
  std::error_code error;
  if (fs::equivalent(o.from, o.to, error))
    throw Error(fmt::format("{}: this is the log itself; name another file", o.to));
  const std::string extension = fs::path(o.to).extension().string();
  const bool mcap = extension == ".mcap";
  if (!mcap && extension != ".log" && extension != ".clf")
    throw Error(
        fmt::format("{}: the name has to end in .mcap (ROS 2), .log or .clf (CARMEN)", o.to));
  const auto source = io::open_log(o.from, o.source);
  std::int64_t scans = 0;
  Report left_out;
  if (mcap) {
    io::McapLogWriter writer(o.to);
    scans = copy(*source, writer);
    writer.close();
    left_out = writer.report();
  } else {
    io::CarmenWriter writer(
        o.to, fmt::format("converted by majak from {}", fs::path(o.from).filename().string()));
    scans = copy(*source, writer);
    writer.commit();
    left_out = writer.report();
  }
  fmt::print("{} scans: {}\n", scans, o.to);
  print_report(source->report());
  print_report(left_out);
}

}  // namespace

void add_convert(CLI::App& app) {
  auto options = std::make_shared<ConvertOptions>();
  CLI::App* command = app.add_subcommand(
      "convert",
      "A log or recording in another format.\n\n"
      "Examples:\n"
      "  majak convert hall.mcap hall.log       a recording for programs that read CARMEN logs\n"
      "  majak convert intel.clf.bz2 intel.mcap   an old log for the tools of ROS 2\n"
      "  majak convert old.bag new.mcap --topic /base_scan\n");
  command->add_option("FROM", options->from, "any log or recording that majak reads")->required();
  command->add_option("TO", options->to, "ends in .mcap, .log or .clf")->required();
  add_log_options(*command, options->source);
  command->callback([options] { run(*options); });
}

}  // namespace majak::app
