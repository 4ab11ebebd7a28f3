// SPDX-License-Identifier: Apache-2.0
// The subcommands. Each adds itself to the command line and runs from CLI11's callback.
#pragma once

namespace CLI {
class App;
}

namespace majak::app {

void add_commands(CLI::App& app);

}  // namespace majak::app
