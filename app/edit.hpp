// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace CLI {
class App;
}

namespace majak::app {

/// `majak edit RUN`: corrections by hand, which stay with the run.
void add_edit(CLI::App& app);

}  // namespace majak::app
