// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace CLI {
class App;
}

namespace majak::app {

/// `majak demo thesis`: the closing demonstration of the thesis, on real or simulated data.
void add_demo(CLI::App& app);

}  // namespace majak::app
