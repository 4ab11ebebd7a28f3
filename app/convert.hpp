// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace CLI {
class App;
}

namespace majak::app {

/// `majak convert A B`: a log or recording in another format.
void add_convert(CLI::App& app);

}  // namespace majak::app
