// SPDX-License-Identifier: Apache-2.0
// majak: one program, one subcommand a file. Errors are caught here, once.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>

#include "app/commands.hpp"
#include "majak/core/error.hpp"

int main(int argc, char** argv) {
  CLI::App app{"majak: where is my laser robot, and what does the place look like"};
  app.require_subcommand(1);
  majak::app::add_commands(app);
  try {
    app.parse(argc, argv);
    // What is still buffered may meet a full disk.
    if (std::fflush(stdout) != 0)
      throw majak::Error(fmt::format("the output cannot be written: {}", std::strerror(errno)));
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
