// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace CLI {
class App;
}

namespace majak::app {

/// `majak export RUN FORMAT`: a run for other people's programs.
void add_export(CLI::App& app);

}  // namespace majak::app
