// SPDX-License-Identifier: Apache-2.0
// Rooms and doors for other people's programs, and the names that people gave them.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "majak/map/room_labels.hpp"
#include "majak/map/topology.hpp"

namespace majak::io {

/// GraphML: rooms are nodes, doors are edges (several between two rooms are several edges). Reads
/// in networkx, yEd, Gephi. One name a room.
std::string topology_graphml(const map::Topology& topology, std::span<const std::string> names);

/// JSON: rooms with outlines and cells (runs [row, first column, count]), doors, furniture; metres
/// of the map's frame.
std::string topology_json(const map::Topology& topology, std::span<const std::string> names);

/// labels.json beside a run. No labels where there is no file. Throws Error (path, what is wrong).
std::vector<map::RoomLabel> read_labels(const std::filesystem::path& path);
void write_labels(const std::filesystem::path& path, std::span<const map::RoomLabel> labels);

}  // namespace majak::io
