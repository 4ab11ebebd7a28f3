// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace CLI {
class App;
}

namespace majak::app {

/// `majak figure N`: the figures of the thesis, from our own models and data.
void add_figure(CLI::App& app);

}  // namespace majak::app
