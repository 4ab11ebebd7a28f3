// SPDX-License-Identifier: Apache-2.0
#include "app/edit.hpp"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "app/named_rooms.hpp"
#include "app/progress.hpp"
#include "app/results.hpp"
#include "app/scan_pair.hpp"
#include "majak/core/error.hpp"
#include "majak/io/site_file.hpp"
#include "majak/map/edits.hpp"
#include "majak/slam/reoptimise.hpp"

namespace majak::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kHelp =
    "Corrections by hand: they stay with the run, go into all its files and can be undone.\n"
    "\n"
    "Examples:\n"
    "  majak edit hall --list                           what was corrected; or --closures\n"
    "  majak edit hall --erase \"1,2;3,2;3,4\"            traces of people inside do not count\n"
    "  majak edit hall --wall \"0,0;8,0\"                 glass, which the laser does not see\n"
    "  majak edit hall --forbid \"1,2;3,2;3,4\"           robots must not go there\n"
    "  majak edit hall --crop \"-5,-5;20,-5;20,15;-5,15\" only what lies inside counts\n"
    "  majak edit hall --upright                        walls along the axes; or --turn 12.5\n"
    "  majak edit hall --without-loop 151-945           a closure is wrong; --with-loop undoes it\n"
    "  majak edit hall --undo                           takes the last correction back\n"
    "\n"
    "Points are x,y in m of the map as it is. They move along when the map changes.\n";

struct EditCommand {
  std::string run;
  std::vector<std::string> erase, wall, forbid, crop, without_loops, with_loops;
  double turn = 0;  // degrees
  bool upright = false, undo = false, list = false, closures = false;
  int threads = 0;
};

std::vector<Vec2> points_of(const std::string& text, const char* what) {
  std::vector<Vec2> points;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(';', at), text.size());
    points.push_back(point_in(text.substr(at, end - at), what));
    at = end + 1;
  }
  return points;
}

std::string in_words(const Site& site, const Edit& edit) {
  std::string text = fmt::format("{:>4}  {}", edit.id, name_of(edit.kind));
  if (edit.kind == EditKind::turn) return text + fmt::format(" {:.2f} deg", degrees(edit.radians));
  if (edit.kind == EditKind::closure_off) return text + fmt::format(" {}-{}", edit.from, edit.to);
  for (const Vec2& p : map::points_in_map(site, edit))
    text += fmt::format(" {:.2f},{:.2f}", p.x(), p.y());
  return text;
}

void add_turn(Site& site, double radians) {
  Edit edit;
  edit.kind = EditKind::turn;
  edit.radians = radians;
  map::add_edit(site, std::move(edit));
}

void add_shapes(Site& site, const Site& shown, EditKind kind,
                const std::vector<std::string>& texts) {
  const std::string option = std::string("--") + name_of(kind);
  for (const std::string& text : texts)
    map::add_edit(site, map::anchored(shown, kind, points_of(text, option.c_str())));
}

/// Shapes before turns: their points are where the user saw them.
void apply(const EditCommand& o, Site& site) {
  if (o.undo && !map::undo_edit(site)) throw Error(o.run + ": there is nothing to undo");
  const Site shown = map::with_edits(site);
  add_shapes(site, shown, EditKind::erase, o.erase);
  add_shapes(site, shown, EditKind::wall, o.wall);
  add_shapes(site, shown, EditKind::forbidden, o.forbid);
  add_shapes(site, shown, EditKind::crop, o.crop);
  for (const std::string& pair : o.without_loops) {
    const auto [from, to] = scan_pair("--without-loop", pair);
    map::switch_closure(site, from, to, false);
  }
  for (const std::string& pair : o.with_loops) {
    const auto [from, to] = scan_pair("--with-loop", pair);
    map::switch_closure(site, from, to, true);
  }
  if (o.turn != 0) add_turn(site, radians(o.turn));
  if (!o.upright) return;
  const auto direction = map::main_direction(map::with_edits(site));
  if (!direction) throw Error(o.run + ": no straight wall tells which way is upright");
  add_turn(site, -*direction);
}

std::vector<std::pair<std::size_t, std::size_t>> switched_off(const Site& site) {
  std::vector<std::pair<std::size_t, std::size_t>> off;
  for (const Edit& edit : site.edits)
    if (edit.kind == EditKind::closure_off) off.emplace_back(edit.from, edit.to);
  return off;
}

void list_closures(const Site& site) {
  for (const Constraint& c : site.constraints)
    if (c.kind == ConstraintKind::closure)
      fmt::print("{}-{}  {}  agreement {:.2f}  chi2 {:.1f}\n", c.from, c.to,
                 slam::switched_off(site, c.from, c.to) ? "switched off"
                 : c.enabled                            ? "in use"
                                                        : "contradicted",
                 c.score, c.chi2);
}

void run_edit(const EditCommand& o) {
  const fs::path file = fs::is_directory(o.run) ? fs::path(o.run) / "site.majak" : fs::path(o.run);
  Stopwatch stopwatch;
  Site site = io::read_site_to_edit(file);
  stopwatch.lap("read");
  const std::vector<Edit> before = site.edits;
  const double turned_before = map::turn_of(site);
  const auto off_before = switched_off(site);
  apply(o, site);
  if (site.edits != before) {
    const RunOptions options = options_of(site);
    if (switched_off(site) != off_before) {
      site =
          slam::reoptimised(std::move(site), options.mapping.graph_slam, {thread_count(o.threads)});
      stopwatch.lap("reoptimise");
    }
    const fs::path folder = fs::absolute(file).parent_path();
    write_results(folder, site, options.grid, stopwatch);
    turn_labels(folder, angle_diff(map::turn_of(site), turned_before));
  } else if (!o.list && !o.closures) {
    throw Error("nothing to do; majak edit --help lists what can be corrected");
  }
  if (o.closures) return list_closures(site);
  const Site shown = map::with_edits(std::move(site));
  for (const Edit& edit : shown.edits) fmt::print("{}\n", in_words(shown, edit));
  if (shown.edits.empty()) fmt::print("no edits\n");
}

}  // namespace

void add_edit(CLI::App& app) {
  auto o = std::make_shared<EditCommand>();
  CLI::App* command = app.add_subcommand("edit", kHelp);
  command->add_option("RUN", o->run, "folder of a run, or its site.majak")->required();
  command->add_option("--erase", o->erase, "polygon x,y;x,y;... whose returns do not count");
  command->add_option("--wall", o->wall, "line x,y;x,y;... that is a wall");
  command->add_option("--forbid", o->forbid, "polygon where robots must not go");
  command->add_option("--crop", o->crop, "polygon outside which nothing counts");
  command->add_option("--turn", o->turn, "degrees, counter-clockwise");
  command->add_flag("--upright", o->upright, "turn so that the walls lie along the axes");
  command->add_option("--without-loop", o->without_loops,
                      "switch a closure off, FROM-TO as the report lists its scans");
  command->add_option("--with-loop", o->with_loops, "switch it on again");
  command->add_flag("--undo", o->undo, "take the last correction back");
  command->add_flag("--list", o->list, "only list the corrections");
  command->add_flag("--closures", o->closures, "list the closures");
  command
      ->add_option("--threads", o->threads,
                   "threads to use (default: all); the results do not depend on it")
      ->check(CLI::Range(1, 1024));
  command->callback([o] { run_edit(*o); });
}

}  // namespace majak::app
