// SPDX-License-Identifier: Apache-2.0
#include "app/view.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>

#include "app/map.hpp"
#include "app/progress.hpp"
#include "app/run_view.hpp"
#include "app/viewer.hpp"
#include "majak/io/site_file.hpp"

namespace majak::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kViewHelp =
    "Show a run, a log or a live laser on a page in the browser.\n"
    "\n"
    "Examples:\n"
    "  majak view office               a run that majak map has made: look, judge, correct\n"
    "  majak view my.log               a log, mapped before your eyes; nothing is written\n"
    "  majak view /dev/ttyUSB0         a live laser, mapped while you carry it; nothing is "
    "written\n"
    "  majak map my.log --view         the same, and the run is kept\n"
    "\n"
    "It prints the page's address. Only this machine can open it; from another one use\n"
    "  ssh -L 8080:127.0.0.1:PORT this-machine      and open http://127.0.0.1:8080/\n"
    "or listen to others with --address, who then need the token that the address shows.\n"
    "What is corrected on the page is on the disk before the page says so.\n";

void run_view(const std::string& target, const ViewerOptions& options) {
  std::error_code none;
  fs::path file = target;
  if (fs::is_directory(file, none)) file /= "site.majak";
  if (file.extension() != ".majak") return map_on_page(target, options);
  Site kept = io::read_site_to_edit(file);
  Viewer viewer(options);
  const RunView view(viewer, std::move(kept), fs::absolute(file).parent_path(), {thread_count(0)});
  viewer.wait();
}

}  // namespace

void add_view(CLI::App& app) {
  struct Options {
    std::string target;
    ViewerOptions viewer;
  };
  const auto o = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("view", kViewHelp);
  command
      ->add_option("TARGET", o->target,
                   "folder of a run or its site.majak, a log, or a live device's serial port")
      ->required();
  add_viewer_options(*command, o->viewer);
  command->callback([o] { run_view(o->target, o->viewer); });
}

}  // namespace majak::app
