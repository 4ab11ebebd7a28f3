// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace majak::app {

struct ViewerOptions;

/// `majak map LOG`: the main job, from a log to a map, a trajectory and a report.
void add_map(CLI::App& app);

/// Maps a log or a live device on a page in the browser, and leaves nothing behind.
void map_on_page(const std::string& log, const ViewerOptions& viewer);

}  // namespace majak::app
