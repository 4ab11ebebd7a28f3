// SPDX-License-Identifier: Apache-2.0
#include "app/results.hpp"

#include <fmt/core.h>

#include <optional>

#include "app/named_rooms.hpp"
#include "app/progress.hpp"
#include "app/write_figure.hpp"
#include "majak/draw/report.hpp"
#include "majak/io/atomic_file.hpp"
#include "majak/io/g2o.hpp"
#include "majak/io/map_files.hpp"
#include "majak/io/options_file.hpp"
#include "majak/io/site_file.hpp"
#include "majak/io/site_graph.hpp"
#include "majak/io/topology_files.hpp"
#include "majak/io/tum.hpp"
#include "majak/map/edits.hpp"

namespace majak::app {

void describe(OptionFields& fields, RunOptions& options) {
  methods::describe(fields, options.mapping);
  map::describe(fields, options.grid);
}

RunOptions options_of(const Site& site) {
  RunOptions options;
  OptionFields fields;
  describe(fields, options);
  io::apply_options(fields, site.options_toml, "the run's options");
  return options;
}

void Stopwatch::lap(const char* stage) {
  const double now = cpu_seconds();
  laps_.emplace_back(fmt::format("{}_cpu_s", stage), now - last_);
  last_ = now;
}

void turn_labels(const std::filesystem::path& folder, double by) {
  const std::filesystem::path path = labels_path(folder);
  std::vector<map::RoomLabel> labels = io::read_labels(path);
  if (by == 0 || labels.empty()) return;
  const Pose2 T{0, 0, by};
  for (map::RoomLabel& label : labels) {
    label.at = T * label.at;
    for (Vec2& p : label.outline) p = T * p;
  }
  io::write_labels(path, labels);
}

Results write_results(const std::filesystem::path& folder, const Site& kept,
                      const map::OccupancyGridOptions& grid_options, Stopwatch& stopwatch) {
  make_folder(folder);
  const std::optional<Site> edited =
      kept.edits.empty() ? std::nullopt : std::optional(map::with_edits(kept));
  const Site& site = edited ? *edited : kept;
  Results results;
  results.slips = motion::find_slips(site);
  motion::sort_by_size(results.slips);
  stopwatch.lap("slips");
  const auto grid = map::build_occupancy_grid(site, grid_options);
  stopwatch.lap("grid");
  io::write_map_files(folder, grid);
  io::write_keepout_files(folder, grid, site);
  io::write_file_atomically(folder / "trajectory.tum", io::tum_text(site));
  io::write_g2o(folder / "graph.g2o", io::graph_of(site));
  io::write_file_atomically(folder / "options.toml", site.options_toml);
  io::write_site(folder / "site.majak", kept);
  stopwatch.lap("write");
  draw::ReportExtras extras;
  extras.timing = stopwatch.laps();
  extras.slips = results.slips;
  io::write_file_atomically(folder / "report.html", draw::report_html(site, grid, extras));
  stopwatch.lap("report");
  results.summary = io::summary_json(site, grid, {}, stopwatch.laps(), results.slips);
  io::write_file_atomically(folder / "summary.json", results.summary);
  return results;
}

}  // namespace majak::app
