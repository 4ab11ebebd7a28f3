// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "majak/io/source.hpp"

namespace CLI {
class App;
}

namespace majak::app {

/// What to believe instead of what a recording says, for all commands that read one.
void add_log_options(CLI::App& command, io::SourceOptions& options);

}  // namespace majak::app
