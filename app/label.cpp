// SPDX-License-Identifier: Apache-2.0
#include "app/label.hpp"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <string>

#include "app/named_rooms.hpp"
#include "majak/core/error.hpp"
#include "majak/io/topology_files.hpp"

namespace majak::app {
namespace {

constexpr const char* kLabelHelp =
    "The rooms of a run, and what people call them.\n"
    "\n"
    "Examples:\n"
    "  majak label hall                    all rooms, their kinds and why, and the names given\n"
    "  majak label hall 12.5,3 kitchen     the room at x 12.5 m, y 3 m is the kitchen\n"
    "  majak label hall --remove kitchen\n"
    "\n"
    "Names are kept in labels.json beside the run, each with a point and the outline of its room "
    "in "
    "the\nmap's frame. When the map is made anew they go to the room that lies there then; a name "
    "that finds\nno room is reported and stays in the file.\n";

struct LabelCommand {
  std::string run, at, text, remove;
};

void list(const NamedRooms& rooms) {
  for (std::size_t i = 0; i < rooms.names.size(); ++i) {
    const map::Room& room = rooms.topology.rooms[i];
    fmt::print("{:<20} {:<9} at {:.2f},{:.2f}  {}\n", rooms.names[i], name_of(room.kind),
               room.widest_spot.x(), room.widest_spot.y(), evidence_of(room));
  }
  const auto matches = match_labels(rooms.topology, rooms.labels);
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const map::RoomLabel& label = rooms.labels[i];
    if (matches[i].fate == map::LabelFate::lost)
      fmt::print("lost: \"{}\" at {:.2f},{:.2f}: there is no room any more\n", label.text,
                 label.at.x(), label.at.y());
    if (matches[i].fate == map::LabelFate::moved)
      fmt::print("moved: \"{}\": {:.0f} % of its old room are in this one\n", label.text,
                 100 * matches[i].overlap);
  }
}

void run_label(const LabelCommand& o) {
  NamedRooms rooms = read_named_rooms(o.run);
  if (!o.remove.empty()) {
    const auto gone = std::erase_if(
        rooms.labels, [&](const map::RoomLabel& label) { return label.text == o.remove; });
    if (gone == 0) throw Error(fmt::format("{}: no label {}", o.run, o.remove));
  } else if (!o.at.empty()) {
    if (o.text.empty()) throw Error("label: no name given; write one after the point");
    rooms.labels.push_back(map::label_at(rooms.topology, point_in(o.at, "label"), o.text));
  } else {
    list(rooms);
    return;
  }
  io::write_labels(labels_path(o.run), rooms.labels);
  fmt::print("{}: {} names\n", labels_path(o.run).string(), rooms.labels.size());
}

}  // namespace

void add_label(CLI::App& app) {
  auto o = std::make_shared<LabelCommand>();
  CLI::App* command = app.add_subcommand("label", kLabelHelp);
  command->add_option("RUN", o->run, "folder of a run, or its site.majak")->required();
  command->add_option("AT", o->at, "a point x,y in the room, m of the map's frame");
  command->add_option("TEXT", o->text, "the room's name");
  command->add_option("--remove", o->remove, "forget this name");
  command->callback([o] { run_label(*o); });
}

}  // namespace majak::app
