// SPDX-License-Identifier: Apache-2.0
#include "app/figure.hpp"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "app/log_options.hpp"
#include "app/write_figure.hpp"
#include "majak/core/error.hpp"
#include "majak/draw/thesis_figures.hpp"
#include "majak/io/source.hpp"

namespace majak::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFigureHelp =
    "The figures of the thesis, drawn from majak's own models: figureN.svg and figureN.png.\n"
    "\n"
    "Examples:\n"
    "  majak figure                  which figures there are\n"
    "  majak figure 5                ellipses of dead reckoning, from a built-in drive\n"
    "  majak figure 5 my.log -o out  the same from your own log, into the folder out\n";

struct FigureCommand {
  std::string name, log, output = ".";
  io::SourceOptions source;
};

void list_figures() {
  for (const draw::ThesisFigure& f : draw::thesis_figures())
    fmt::print("{:>3}  {}{}\n", f.name, f.shows, f.takes_log ? " [also of a LOG]" : "");
}

/// Without the scans' beams, which no figure of a path needs.
std::vector<Event> events_of(const FigureCommand& o) {
  std::vector<Event> events;
  const auto source = io::open_log(o.log, o.source);
  while (auto event = source->next()) {
    if (auto* scan = std::get_if<Scan>(&*event)) scan->ranges.clear(), scan->intensities.clear();
    events.push_back(std::move(*event));
  }
  if (events.empty()) throw Error(o.log + ": nothing is in this log");
  return events;
}

void run_figure(const FigureCommand& o) {
  if (o.name.empty()) return list_figures();
  const draw::ThesisFigure& figure = draw::thesis_figure(o.name);
  if (!o.log.empty() && !figure.takes_log)
    throw Error(fmt::format("figure {} is not drawn from a log; leave {} out", o.name, o.log));
  const auto events = o.log.empty() ? std::vector<Event>{} : events_of(o);
  const fs::path folder = o.output;
  make_folder(folder);
  const std::string name = "figure" + o.name;
  write_figure(folder, name, figure.make(events));
  fmt::print("{}, {}\n", (folder / (name + ".svg")).string(), (folder / (name + ".png")).string());
}

}  // namespace

void add_figure(CLI::App& app) {
  auto o = std::make_shared<FigureCommand>();
  CLI::App* command = app.add_subcommand("figure", kFigureHelp);
  command->add_option("N", o->name, "number of the figure; without it they are listed");
  command->add_option("LOG", o->log, "a log of any kind, for figures of a path");
  add_log_options(*command, o->source);
  command->add_option("-o,--output", o->output, "folder for the files (default: this one)");
  command->callback([o] { run_figure(*o); });
}

}  // namespace majak::app
