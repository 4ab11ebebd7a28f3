// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace CLI {
class App;
}

namespace majak::app {

/// `majak record PORT`: a live device into a recording.
void add_record(CLI::App& app);

}  // namespace majak::app
