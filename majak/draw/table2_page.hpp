// SPDX-License-Identifier: Apache-2.0
// Table 2 of the thesis with what was measured: as a page, as Markdown and for programs.
#pragma once

#include <string>

#include "majak/eval/table2.hpp"

namespace majak::draw {

/// One file; the command that measures a cell shows where the pointer rests on it.
std::string table2_html(const eval::Table2& table);

std::string table2_markdown(const eval::Table2& table);

std::string table2_json(const eval::Table2& table);

}  // namespace majak::draw
