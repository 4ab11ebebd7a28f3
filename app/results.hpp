// SPDX-License-Identifier: Apache-2.0
// The folder of a run: what `majak map` leaves there, and what leaves it there again after a
// correction.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "majak/core/site.hpp"
#include "majak/io/summary.hpp"
#include "majak/map/occupancy_grid.hpp"
#include "majak/methods/mappers.hpp"
#include "majak/motion/slip.hpp"

namespace majak::app {

/// All that a run's options.toml holds.
struct RunOptions {
  methods::MappingOptions mapping;
  map::OccupancyGridOptions grid;
};
void describe(OptionFields& fields, RunOptions& options);

/// Those that the run was made with, as its site states them. Throws Error.
RunOptions options_of(const Site& site);

/// CPU seconds by stage.
class Stopwatch {
 public:
  void lap(const char* stage);
  const std::vector<io::NamedFigure>& laps() const { return laps_; }

 private:
  double last_ = 0;
  std::vector<io::NamedFigure> laps_;
};

/// Names of rooms are kept in the map's frame: they go along when it is turned `by` so much more,
/// rad. Throws Error.
void turn_labels(const std::filesystem::path& folder, double by);

struct Results {
  std::string summary;                   ///< summary.json
  std::vector<motion::SlipEvent> slips;  ///< biggest first
};

/// Makes the folder where there is none and writes all files of a run. `kept`: the site as it is
/// kept, whose edits are applied here. Each file appears whole or not at all, site.majak the last
/// but the report and the summary.
Results write_results(const std::filesystem::path& folder, const Site& kept,
                      const map::OccupancyGridOptions& grid, Stopwatch& stopwatch);

}  // namespace majak::app
