// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace CLI {
class App;
}

namespace majak::app {

/// `majak map LOG`: the main job, from a log to a map, a trajectory and a report.
void add_map(CLI::App& app);

}  // namespace majak::app
