// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace CLI {
class App;
}

namespace majak::app {

/// `majak localize LOG`: where the robot was, by any one method of localization.
void add_localize(CLI::App& app);

}  // namespace majak::app
