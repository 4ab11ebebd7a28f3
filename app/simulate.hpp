// SPDX-License-Identifier: Apache-2.0
// majak simulate: a robot with an LMS-291 drives through a world; an ordinary log comes out.
#pragma once

namespace CLI {
class App;
}

namespace majak::app {

void add_simulate(CLI::App& app);

}  // namespace majak::app
