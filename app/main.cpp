// SPDX-License-Identifier: Apache-2.0
// majak: one program, one subcommand a file. Errors are caught here, once.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <exception>

#include "app/commands.hpp"

int main(int argc, char** argv) {
  CLI::App app{"majak: where is my laser robot, and what does the place look like"};
  app.require_subcommand(1);
  majak::app::add_commands(app);
  try {
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);  // --help
    fmt::print(stderr, "majak: {} (see majak --help)\n", e.what());
    return 1;
  } catch (const std::exception& e) {
    fmt::print(stderr, "majak: {}\n", e.what());
    return 1;
  }
}
