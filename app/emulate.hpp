// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace CLI {
class App;
}

namespace majak::app {

/// `majak emulate`: an LMS-2xx on a pseudo-terminal.
void add_emulate(CLI::App& app);

}  // namespace majak::app
