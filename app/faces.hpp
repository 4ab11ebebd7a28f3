// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace CLI {
class App;
}

namespace majak::app {

/// majak faces RUN [NAME...]: the same place, looked at in many ways.
void add_faces(CLI::App& app);

}  // namespace majak::app
