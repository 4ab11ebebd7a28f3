// SPDX-License-Identifier: Apache-2.0
#include "app/export.hpp"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iterator>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "app/named_rooms.hpp"
#include "app/solid_log.hpp"
#include "app/write_figure.hpp"
#include "majak/core/error.hpp"
#include "majak/draw/face.hpp"
#include "majak/io/atomic_file.hpp"
#include "majak/io/known_map_files.hpp"
#include "majak/io/options_file.hpp"
#include "majak/io/topology_files.hpp"

namespace majak::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExportHelp =
    "What a run found out, for other people's programs.\n"
    "\n"
    "Examples:\n"
    "  majak export hall dxf                  for CAD: hall.dxf\n"
    "  majak export hall svg -o plan.svg      for browsers and drawing programs\n"
    "  majak export hall geojson              for GIS; also wkt\n"
    "  majak export hall glb                  walls raised to 2.5 m, for browsers; also wrl, ply\n"
    "  majak export hall graphml              rooms and doors as a graph; json: with outlines and "
    "cells\n"
    "  majak export hall glb --log my.log     planes that its second, upright laser saw; --look\n"
    "  majak export hall dxf --set refinement.min_returns=400  large walls only\n"
    "  majak export map.yaml dxf              the walls of a map that others made of cells\n"
    "\n"
    "Metres of the map's frame. A piece keeps the way from its begin to its end: it was seen from "
    "its\n"
    "left. The map is made of the run's final poses.\n";

struct ExportFormat {
  const char* name;
  const char* face;  ///< whose files have one that ends so
};
constexpr ExportFormat kFormats[] = {
    {"svg", "segments"}, {"dxf", "segments"},  {"geojson", "segments"},
    {"wkt", "segments"}, {"graphml", "rooms"}, {"json", "rooms"},
    {"wrl", "walls-3d"}, {"glb", "walls-3d"},  {"ply", "walls-3d"}};

struct ExportCommand {
  std::string run, format, output;
  double resolution = 0;
  std::vector<std::string> set;
  draw::FaceOptions options;
  SolidLog second;
};

const ExportFormat& format_called(const std::string& name) {
  const auto* found = std::find_if(std::begin(kFormats), std::end(kFormats),
                                   [&](const ExportFormat& f) { return f.name == name; });
  if (found != std::end(kFormats)) return *found;
  std::string names;
  for (const ExportFormat& f : kFormats)
    names += fmt::format("{}{}", names.empty() ? "" : ", ", f.name);
  throw Error(fmt::format("export: no format {}; there are {}", name, names));
}

draw::FacePage page_of(const ExportCommand& o, const ExportFormat& format) {
  const auto input = io::read_map(o.run, o.resolution);
  const bool solid = !o.second.log.empty() && std::string_view(format.face) == "walls-3d";
  const std::string face = solid ? "solid" : format.face;
  if (!input.site && face != "segments")
    throw Error(
        fmt::format("{}: a map alone has no {}; that takes the run it was made from", o.run, face));
  try {
    const auto cloud = input.site ? read_cloud(*input.site, o.second) : std::nullopt;
    draw::FaceOptions options = o.options;
    options.cloud = cloud ? &*cloud : nullptr;
    if (input.site) return draw::face(face).make(*input.site, options);
    return input.known ? draw::contours_page(*input.known, input.T_world_map)
                       : draw::segments_page(input.segments);
  } catch (const Error& e) {
    throw Error(fmt::format("{}: {}", o.run, e.what()));
  }
}

void run_export(ExportCommand& o) {
  const ExportFormat& format = format_called(o.format);
  OptionFields fields;
  describe(fields, o.options);
  describe(fields, o.second);
  for (const std::string& assignment : o.set) io::apply_option(fields, assignment);
  const std::string ending = "." + o.format;
  if (o.output.empty()) o.output = results_folder(o.run, ending.c_str());
  o.options.labels = io::read_labels(labels_path(o.run));
  const draw::FacePage page = page_of(o, format);
  const auto file = std::find_if(page.files.begin(), page.files.end(),
                                 [&](const auto& f) { return f.name.ends_with(ending); });
  io::write_file_atomically(o.output, file->bytes);
  fmt::print("{}:", o.output);
  for (const auto& [name, value] : page.figures) fmt::print(" {} {:.6g}", name, value);
  fmt::print("\n");
}

}  // namespace

void add_export(CLI::App& app) {
  auto o = std::make_shared<ExportCommand>();
  CLI::App* command = app.add_subcommand("export", kExportHelp);
  command
      ->add_option("RUN", o->run,
                   "folder of a run, its site.majak; or a map of others: a YAML, a picture")
      ->required();
  command->add_option("FORMAT", o->format, "svg, dxf, geojson, wkt, graphml, json, wrl, glb or ply")
      ->required();
  add_solid_log(*command, o->second);
  command->add_option("-o,--output", o->output,
                      "the file (default: the run's name and the format)");
  command->add_option("--map-resolution", o->resolution, "m a pixel, of a picture without a YAML");
  command->add_option("--set", o->set, "one option: name=value");
  command->callback([o] { run_export(*o); });
}

}  // namespace majak::app
