// SPDX-License-Identifier: Apache-2.0
// What pages of reports are made of: the fixed text of style sheet and script, sections, tiles,
// tables, and a map whose layers can be switched.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "majak/core/report.hpp"
#include "majak/draw/figure.hpp"
#include "majak/draw/map_layers.hpp"

namespace majak::draw {

std::string_view report_style();
std::string_view report_script();

/// The whole page: `body` is HTML, the rest plain text. Where it has an element with id "map" a
/// script moves and zooms it.
std::string page(const std::string& title, const std::string& lead, const std::string& body,
                 const std::string& footer);

/// Nothing for an empty body.
std::string section(const std::string& title, const std::string& body);
std::string list(const std::vector<std::string>& sentences);
std::string tile(const std::string& value, const std::string& label, const std::string& more);
/// Cells are plain text; the first column stands to the left. Nothing for no rows.
std::string table(const std::vector<std::string>& head,
                  const std::vector<std::vector<std::string>>& rows);
/// `what` it shows, for those who cannot see it.
std::string figure_in_page(const Figure& figure, const std::string& what);
std::string skipped_section(const Report& report);

/// "12:05 min", "1:02:03 h"; "4.2 cm", "61 cm", "3.1 m".
std::string clock(double seconds);
std::string metres(double value);

/// The map's `svg` with those layers hidden that start so, and switches below.
std::string switched_map(std::string svg, const std::vector<Layer>& layers);

}  // namespace majak::draw
