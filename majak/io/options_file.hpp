// SPDX-License-Identifier: Apache-2.0
// Options to and from TOML. What options_toml() writes, apply_options() reads back to the same
// bits. Precedence is the caller's order of calls: defaults, then files, then flags.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "majak/core/options.hpp"

namespace majak::io {

/// All options with unit, range and help as comments, grouped into tables in their order.
std::string options_toml(const OptionFields& fields);

/// Sets the options that the text names. `name` is used in messages. Throws Error with name:line
/// for broken TOML, an unknown option, a wrong type or a value out of its range; then none is set.
void apply_options(OptionFields& fields, std::string_view toml, const std::string& name);

/// apply_options() of a file's text. Throws Error also when it cannot be read.
void apply_options_file(OptionFields& fields, const std::filesystem::path& path);

/// One assignment as on the command line: "table.key=value".
void apply_option(OptionFields& fields, std::string_view assignment);

}  // namespace majak::io
