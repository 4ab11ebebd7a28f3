// SPDX-License-Identifier: Apache-2.0
#include "app/commands.hpp"

#include <CLI/CLI.hpp>
#include <memory>
#include <sstream>
#include <string>

#include "app/calibrate.hpp"
#include "app/compare.hpp"
#include "app/convert.hpp"
#include "app/demo.hpp"
#include "app/edit.hpp"
#include "app/emulate.hpp"
#include "app/evaluate.hpp"
#include "app/export.hpp"
#include "app/faces.hpp"
#include "app/figure.hpp"
#include "app/info.hpp"
#include "app/label.hpp"
#include "app/localize.hpp"
#include "app/map.hpp"
#include "app/record.hpp"
#include "app/route.hpp"
#include "app/simulate.hpp"
#include "app/view.hpp"

namespace majak::app {

namespace {

/// The list of subcommands with the first line of each description; the examples that follow it
/// belong to the subcommand's own help.
class FirstLines : public CLI::Formatter {
  std::string make_subcommand(const CLI::App* command) const override {
    const std::string all = command->get_description();
    std::stringstream out;
    CLI::detail::format_help(out, command->get_name(), all.substr(0, all.find('\n')),
                             column_width_);
    return out.str();
  }
};

}  // namespace

void add_commands(CLI::App& app) {
  add_map(app);
  add_localize(app);
  add_view(app);
  add_compare(app);
  add_calibrate(app);
  add_info(app);
  add_record(app);
  add_convert(app);
  add_emulate(app);
  add_simulate(app);
  add_evaluate(app);
  add_faces(app);
  add_label(app);
  add_route(app);
  add_edit(app);
  add_export(app);
  add_figure(app);
  add_demo(app);
  app.formatter(std::make_shared<FirstLines>());
}

}  // namespace majak::app
