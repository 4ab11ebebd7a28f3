// SPDX-License-Identifier: Apache-2.0
#include "majak/io/options_file.hpp"
#include "majak/map/occupancy_grid.hpp"
#include "tests/fuzz/fuzz.hpp"

/// What is accepted is written and accepted again.
MAJAK_FUZZ(toml) {
  majak::map::OccupancyGridOptions options;
  majak::OptionFields fields;
  describe(fields, options);
  majak::io::apply_options(fields, toml, "fuzz");
  majak::io::apply_options(fields, majak::io::options_toml(fields), "again");
}
