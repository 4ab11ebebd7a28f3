// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace CLI {
class App;
}

namespace majak::app {

/// `majak view RUN|LOG|PORT`: a page in the browser.
void add_view(CLI::App& app);

}  // namespace majak::app
