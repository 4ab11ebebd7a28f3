// SPDX-License-Identifier: Apache-2.0
#include "app/commands.hpp"

#include <CLI/CLI.hpp>

#include "app/evaluate.hpp"
#include "app/info.hpp"
#include "app/simulate.hpp"

namespace majak::app {

void add_commands(CLI::App& app) {
  add_info(app);
  add_simulate(app);
  add_evaluate(app);
}

}  // namespace majak::app
