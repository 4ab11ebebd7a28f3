// SPDX-License-Identifier: Apache-2.0
// The subcommands, one file each: add_<name>() describes the command line and sets a callback that
// runs it. A callback throws majak::Error for what the user can mend; main() prints it.
#pragma once

namespace CLI {
class App;
}

namespace majak::app {

/// All subcommands, in the order of --help.
void add_commands(CLI::App& app);

}  // namespace majak::app
