// SPDX-License-Identifier: Apache-2.0
#include "app/export.hpp"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iterator>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "app/write_figure.hpp"
#include "majak/core/error.hpp"
#include "majak/io/atomic_file.hpp"
#include "majak/io/known_map_files.hpp"
#include "majak/io/options_file.hpp"
#include "majak/io/segment_files.hpp"
#include "majak/map/segment_map.hpp"

namespace majak::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kHelp =
    "The walls of a run as straight pieces, for other people's programs.\n"
    "\n"
    "Examples:\n"
    "  majak export hall dxf                  for CAD: hall.dxf\n"
    "  majak export hall svg -o plan.svg      for browsers and drawing programs\n"
    "  majak export hall geojson              for GIS; also wkt\n"
    "  majak export hall dxf --set segments.min_length=0.2     shorter pieces, too\n"
    "\n"
    "Metres of the map's frame. A piece keeps the way from its begin to its end: it was seen from "
    "its\n"
    "left. The map is made of the run's final poses.\n";

struct ExportFormat {
  const char* name;
  std::string (*text)(std::span<const map::Segment>);
};
constexpr ExportFormat kFormats[] = {{"svg", io::segments_svg},
                                     {"dxf", io::segments_dxf},
                                     {"geojson", io::segments_geojson},
                                     {"wkt", io::segments_wkt}};

struct ExportCommand {
  std::string run, format, output;
  std::vector<std::string> set;
  map::SegmentMapOptions segments;
};

const ExportFormat& format_called(const std::string& name) {
  const auto* found = std::find_if(std::begin(kFormats), std::end(kFormats),
                                   [&](const ExportFormat& f) { return f.name == name; });
  if (found == std::end(kFormats))
    throw Error("export: no format " + name + "; there are svg, dxf, geojson and wkt");
  return *found;
}

void run_export(ExportCommand& o) {
  const ExportFormat& format = format_called(o.format);
  OptionFields fields;
  map::describe(fields, o.segments);
  for (const std::string& assignment : o.set) io::apply_option(fields, assignment);
  const auto input = io::read_map(o.run);
  if (!input.site)
    throw Error(o.run + ": no run; export needs the folder that majak map left, or its site.majak");
  const auto walls = map::build_segments(*input.site, o.segments).walls();
  if (walls.empty())
    throw Error(o.run + ": no straight piece is long enough; try --set segments.min_length=0.2");
  if (o.output.empty()) o.output = results_folder(o.run, ("." + o.format).c_str());
  io::write_file_atomically(o.output, format.text(walls));
  double length = 0;
  for (const map::Segment& wall : walls) length += wall.length();
  fmt::print("{}: {} segments, {:.0f} m\n", o.output, walls.size(), length);
}

}  // namespace

void add_export(CLI::App& app) {
  auto o = std::make_shared<ExportCommand>();
  CLI::App* command = app.add_subcommand("export", kHelp);
  command->add_option("RUN", o->run, "folder of a run, or its site.majak")->required();
  command->add_option("FORMAT", o->format, "svg, dxf, geojson or wkt")->required();
  command->add_option("-o,--output", o->output,
                      "the file (default: the run's name and the format)");
  command->add_option("--set", o->set, "one option: name=value");
  command->callback([o] { run_export(*o); });
}

}  // namespace majak::app
