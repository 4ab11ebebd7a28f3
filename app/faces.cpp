// SPDX-License-Identifier: Apache-2.0
#include "app/faces.hpp"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "app/named_rooms.hpp"
#include "app/progress.hpp"
#include "app/solid_log.hpp"
#include "app/write_figure.hpp"
#include "majak/core/error.hpp"
#include "majak/draw/face.hpp"
#include "majak/io/atomic_file.hpp"
#include "majak/io/known_map_files.hpp"
#include "majak/io/options_file.hpp"
#include "majak/io/topology_files.hpp"
#include "majak/map/returns.hpp"

namespace majak::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFacesHelp =
    "One place, looked at in many ways: grids, walls, rooms, things that moved.\n"
    "\n"
    "Examples:\n"
    "  majak faces                          which faces there are\n"
    "  majak faces hall                     all of them: the folder hall-faces; open faces.html\n"
    "  majak faces hall segments occupancy  these two\n"
    "  majak faces hall --from 60 --to 120  of what was seen in the second minute\n"
    "  majak faces hall --near 12,3,5       of what was seen from within 5 m of (12, 3)\n"
    "  majak faces hall solid --log my.log --look up    of a second laser that stands upright\n"
    "  majak faces hall segments --known plan.dxf        walls that are known and still stand "
    "stay\n"
    "  majak faces hall inflated --set robot.radius=0.45\n"
    "\n"
    "The folder holds faces.html, each face as NAME.png and NAME.svg, and its files for other\n"
    "programs. What a face cannot show of this run, it says.\n";

struct FacesCommand {
  std::string run, output, near, known;
  std::vector<std::string> names, set;
  bool all = false;
  int threads = 0;
  map::ScanSelection selection;
  draw::FaceOptions options;
  SolidLog second;
};

void list_faces() {
  for (const draw::Face& f : draw::faces())
    fmt::print("{:>10}  {}{}\n", f.name, f.shows,
               *f.after ? fmt::format("; also {}", f.after) : "");
}

/// "x,y,radius".
void read_near(const std::string& text, map::ScanSelection& selection) {
  double x = 0, y = 0;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf,%lf%c", &x, &y, &selection.radius, &rest) != 3)
    throw Error(fmt::format("--near {}: x,y,radius in m is expected, as in --near 12,3,5", text));
  selection.near = Vec2(x, y);
}

Site site_of(FacesCommand& o) {
  if (!o.near.empty()) read_near(o.near, o.selection);
  auto input = io::read_map(o.run);
  if (!input.site)
    throw Error(o.run + ": no run; faces needs the folder that majak map left, or its site.majak");
  const bool whole = o.selection.from <= 0 && std::isinf(o.selection.to) && !o.selection.near;
  return whole ? std::move(*input.site) : map::selected(*input.site, o.selection);
}

/// Walls of a plan count as if they had been seen often enough.
std::vector<map::Segment> known_walls(const std::string& file, int min_scans) {
  std::vector<map::Segment> walls = io::read_map(file).segments;
  if (walls.empty())
    throw Error(file + ": no walls; a dxf, geojson, wkt or svg of lines is expected");
  for (map::Segment& wall : walls) wall.scans = static_cast<std::size_t>(min_scans);
  return walls;
}

draw::MadeFace made(const draw::Face& face, const Site& site, const draw::FaceOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  draw::MadeFace m{.face = &face};
  try {
    m.page = face.make(site, options);
  } catch (const Error& e) {
    m.error = e.what();
  }
  m.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return m;
}

void write(const fs::path& folder, const draw::MadeFace& m) {
  if (!m.error.empty()) return fmt::print("{:>10}  none: {}\n", m.face->name, m.error);
  write_figure(folder, m.face->name, m.page.figure);
  for (const draw::FaceFile& file : m.page.files)
    io::write_file_atomically(folder / file.name, file.bytes);
  fmt::print("{:>10}  {:.2f} s, {:.1f} kB\n", m.face->name, m.seconds,
             1e-3 * static_cast<double>(m.page.bytes));
}

void run_faces(FacesCommand& o) {
  if (o.run.empty()) return list_faces();
  if (o.all) o.names.clear();
  std::vector<const draw::Face*> chosen;
  for (const std::string& name : o.names) chosen.push_back(&draw::face(name));
  if (chosen.empty())
    for (const draw::Face& f : draw::faces()) chosen.push_back(&f);
  OptionFields fields;
  describe(fields, o.options);
  describe(fields, o.second);
  for (const std::string& assignment : o.set) io::apply_option(fields, assignment);
  o.options.threads = {thread_count(o.threads)};
  const Site site = site_of(o);
  o.options.labels = io::read_labels(labels_path(o.run));
  if (!o.known.empty()) o.options.known_walls = known_walls(o.known, o.options.segments.min_scans);
  const auto cloud = read_cloud(site, o.second);
  o.options.cloud = cloud ? &*cloud : nullptr;
  if (o.output.empty()) o.output = results_folder(o.run, "-faces");
  const fs::path folder = o.output;
  make_folder(folder);
  Progress progress;
  std::vector<draw::MadeFace> all;
  for (const draw::Face* face : chosen) {
    progress.show(face->name, static_cast<std::int64_t>(all.size() + 1));
    all.push_back(made(*face, site, o.options));
    progress.clear();
    write(folder, all.back());
    std::fflush(stdout);  // one may take a minute
  }
  io::write_file_atomically(folder / "faces.html", draw::faces_html(site.source_name, all));
  io::write_file_atomically(folder / "options.toml", io::options_toml(fields));
  fmt::print("{}\n", (folder / "faces.html").string());
  if (o.names.size() == 1 && !all.front().error.empty()) throw Error(all.front().error);
}

}  // namespace

void add_faces(CLI::App& app) {
  auto o = std::make_shared<FacesCommand>();
  CLI::App* command = app.add_subcommand("faces", kFacesHelp);
  command->add_option("RUN", o->run, "folder of a run, or its site.majak");
  command->add_option("NAME", o->names, "faces; without one, all");
  command->add_flag("--all", o->all, "every face");
  command->add_option("--from", o->selection.from, "only scans from so many s after the first");
  command->add_option("--to", o->selection.to, "only scans until so many s after the first");
  command->add_option("--near", o->near, "only scans taken there: x,y,radius in m");
  add_solid_log(*command, o->second);
  command->add_option("--known", o->known,
                      "walls that the segments begin with: dxf, geojson, wkt, svg (map's frame)");
  command->add_option("-o,--output", o->output, "folder (default: the run's name-faces)");
  command->add_option("--threads", o->threads, "0: as many as there are");
  command->add_option("--set", o->set, "one option: name=value");
  command->callback([o] { run_faces(*o); });
}

}  // namespace majak::app
