// SPDX-License-Identifier: Apache-2.0
// Pose graphs in g2o's text format: VERTEX_SE2 id x y theta, EDGE_SE2 from to x y theta and the
// upper triangle of the information, FIX id. Plain, gzip or bzip2, told apart by content.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "majak/core/report.hpp"
#include "majak/graph/pose_graph.hpp"

namespace majak::io {

struct G2oGraph {
  graph::PoseGraph graph;
  std::vector<std::int64_t> ids;  ///< the file's name of each pose, ascending
  bool has_poses = true;          ///< false: the file held edges only, poses were made from them
};

/// Poses are numbered by ascending id. The fixed pose is the first FIX, else the first pose;
/// records of other kinds and further FIX lines are counted in the report. Throws Error (name:line)
/// for a malformed record, a repeated vertex, an edge to a vertex that the file does not define.
G2oGraph parse_g2o(std::string_view text, const std::string& name, Report& report);

/// The same from a file. Throws Error also if the file cannot be read or what it is packed in is
/// damaged.
G2oGraph read_g2o(const std::filesystem::path& path, Report& report);

/// Every number has the digits that bring it back exactly. `ids` may be empty: 0, 1, 2 ...
std::string g2o_text(const graph::PoseGraph& graph, const std::vector<std::int64_t>& ids = {});
void write_g2o(const std::filesystem::path& path, const graph::PoseGraph& graph,
               const std::vector<std::int64_t>& ids = {});

}  // namespace majak::io
