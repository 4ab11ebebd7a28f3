// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace CLI {
class App;
}

namespace majak::app {

/// `majak calibrate LOG`: what is wrong with wheels, mounting and clock, and an options file that
/// mends it.
void add_calibrate(CLI::App& app);

}  // namespace majak::app
