// SPDX-License-Identifier: Apache-2.0
#include "app/route.hpp"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "app/named_rooms.hpp"
#include "app/write_figure.hpp"
#include "majak/core/error.hpp"
#include "majak/draw/topology_figure.hpp"
#include "majak/io/options_file.hpp"
#include "majak/map/route.hpp"

namespace majak::app {
namespace {

constexpr const char* kRouteHelp =
    "The way from one place of a run to another: through which rooms and doors, how long, and a "
    "picture.\n"
    "\n"
    "Examples:\n"
    "  majak route hall --from 2,3 --to 30,12.5\n"
    "  majak route hall --from kitchen --to \"room 7\" -o ways    names as majak label lists them\n"
    "  majak route hall --from 2,3 --to kitchen --set route.radius=0.4\n"
    "\n"
    "The way keeps the robot's radius clear of all that is not known to be free, and more where "
    "there\nis room.\n";

struct RouteCommand {
  std::string run, from, to, output;
  std::vector<std::string> set;
  map::RouteOptions route;
  map::TopologyOptions rooms;
};

/// A point, or the widest spot of the room of that name.
Vec2 place_called(const NamedRooms& rooms, const std::string& text, const char* what) {
  if (looks_like_point(text)) return point_in(text, what);
  const auto found = std::find(rooms.names.begin(), rooms.names.end(), text);
  if (found == rooms.names.end())
    throw Error(fmt::format("{} {}: no such room; majak label lists them", what, text));
  return rooms.topology.rooms[found - rooms.names.begin()].widest_spot;
}

void print(const NamedRooms& rooms, const map::Route& route) {
  for (std::size_t i = 0; i < route.rooms.size(); ++i) {
    fmt::print("{}\n", rooms.names[route.rooms[i]]);
    if (i >= route.doors.size() || route.doors[i] < 0) continue;
    const map::Doorway& d = rooms.topology.doors[route.doors[i]];
    fmt::print("  through {} at {:.2f},{:.2f}, {:.2f} m wide\n",
               d.opening ? "an opening" : "a door", d.centre.x(), d.centre.y(), d.width);
  }
  fmt::print("{:.1f} m, at the narrowest {:.2f} m from an obstacle\n", route.length,
             route.narrowest);
}

void run_route(RouteCommand& o) {
  OptionFields fields;
  map::describe(fields, o.route);
  map::describe(fields, o.rooms);
  for (const std::string& assignment : o.set) io::apply_option(fields, assignment);
  const NamedRooms rooms = read_named_rooms(o.run, o.rooms);
  const map::Route route =
      find_route(rooms.allowed, rooms.topology, place_called(rooms, o.from, "--from"),
                 place_called(rooms, o.to, "--to"), o.route);
  if (!route.found)
    throw Error(fmt::format("{}: no way from {} to {} for a robot of {} m radius", o.run, o.from,
                            o.to, o.route.radius));
  print(rooms, route);
  if (o.output.empty()) o.output = results_folder(o.run, "-route");
  make_folder(o.output);
  write_figure(o.output, "route",
               draw::topology_figure(rooms.known, rooms.topology, rooms.names, &route));
  fmt::print("{}\n", (std::filesystem::path(o.output) / "route.png").string());
}

}  // namespace

void add_route(CLI::App& app) {
  auto o = std::make_shared<RouteCommand>();
  CLI::App* command = app.add_subcommand("route", kRouteHelp);
  command->add_option("RUN", o->run, "folder of a run, or its site.majak")->required();
  command->add_option("--from", o->from, "x,y in m of the map's frame, or a room's name")
      ->required();
  command->add_option("--to", o->to, "x,y in m of the map's frame, or a room's name")->required();
  command->add_option("-o,--output", o->output, "folder (default: the run's name and -route)");
  command->add_option("--set", o->set, "one option: name=value");
  command->callback([o] { run_route(*o); });
}

}  // namespace majak::app
