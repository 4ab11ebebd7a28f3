// SPDX-License-Identifier: Apache-2.0
#include "app/commands.hpp"

#include <CLI/CLI.hpp>

namespace majak::app {

void add_commands(CLI::App&) {}

}  // namespace majak::app
