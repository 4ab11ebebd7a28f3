// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace CLI {
class App;
}

namespace majak::app {

/// `majak info LOG`: what is in a log, and what was skipped and why.
void add_info(CLI::App& app);

}  // namespace majak::app
