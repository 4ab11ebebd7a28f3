// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace CLI {
class App;
}

namespace majak::app {

/// `majak evaluate RUN`: how good a result is, against relations, against truth, or by itself.
void add_evaluate(CLI::App& app);

}  // namespace majak::app
