// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace CLI {
class App;
}

namespace majak::app {

void add_route(CLI::App& app);

}  // namespace majak::app
