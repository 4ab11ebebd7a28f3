// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace CLI {
class App;
}

namespace majak::app {

/// `majak compare LOG --map MAP`: all methods of localization on a known map, side by side.
void add_compare(CLI::App& app);

}  // namespace majak::app
