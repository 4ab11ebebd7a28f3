// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/table2_page.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "majak/draw/report_page.hpp"
#include "majak/draw/svg.hpp"

namespace majak::draw {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kStyle =
    "<style>main{max-width:none}.wide{overflow-x:auto}.two td,.two th{vertical-align:top;"
    "text-align:left;white-space:normal;min-width:118px;font-size:13px}.two td i{font-style:normal;"
    "color:var(--soft);display:block}.two td.differs i{color:var(--poor)}.two td.differs i::after{"
    "content:\" (measured otherwise)\"}</style>";

std::string cell_html(const eval::Table2Cell& cell) {
  const bool differs = cell.agrees && !*cell.agrees;
  std::string text =
      fmt::format("<td{} title=\"{}\">", differs ? " class=\"differs\"" : "", escape(cell.command));
  if (!cell.word.empty()) text += fmt::format("<i>{}</i>", escape(cell.word));
  return text + (cell.measured.empty() ? "&ndash;" : escape(cell.measured)) + "</td>";
}

std::string table_html(const eval::Table2& table) {
  std::string out = "<div class=\"wide\"><table class=\"two\"><thead><tr><th></th>";
  for (const auto& column : table.columns)
    out +=
        fmt::format("<th title=\"{}\">{}</th>", escape(column.in_the_thesis), escape(column.name));
  out += "</tr></thead><tbody>\n";
  for (const auto& row : table.rows) {
    out += fmt::format("<tr><th>{}<br><span class=\"soft\">{}</span></th>", escape(row.name),
                       escape(row.question));
    for (const auto& cell : row.cells) out += cell_html(cell);
    out += "</tr>\n";
  }
  return out + "</tbody></table></div>";
}

std::vector<std::string> figures_row(const eval::Table2Figures& f) {
  return {f.method,
          fmt::format("{} of {}", f.usable, f.runs),
          fmt::format("{:.3f}", f.rms),
          fmt::format("{:.3f}", f.worst),
          fmt::format("{:.3f}", f.map_error),
          f.relation ? fmt::format("{:.4f}", *f.relation) : "",
          f.nees ? fmt::format("{:.2f}", *f.nees) : "",
          fmt::format("{:.2f}", f.ms_a_scan),
          fmt::format("{:.1f}", f.bytes / 1e6)};
}

const std::vector<std::string> kFigures = {"method",      "usable",         "rms, m",
                                           "worst, m",    "map error, m",   "relations, m",
                                           "NEES (of 3)", "CPU, ms a scan", "memory, MB"};

std::vector<std::string> said(const eval::Table2& table) {
  std::vector<std::string> words;
  for (const auto& f : table.figures)
    for (const std::string& why : f.said) words.push_back(f.method + ": " + why);
  return words;
}

std::string markdown_row(const std::vector<std::string>& cells) {
  std::string row = "|";
  for (const std::string& cell : cells) row += " " + cell + " |";
  return row + "\n";
}

std::string markdown_table(const std::vector<std::string>& head,
                           const std::vector<std::vector<std::string>>& rows) {
  std::string out = markdown_row(head) + "|";
  for (std::size_t i = 0; i < head.size(); ++i) out += "---|";
  out += "\n";
  for (const auto& row : rows) out += markdown_row(row);
  return out;
}

}  // namespace

std::string table2_html(const eval::Table2& table) {
  std::vector<std::vector<std::string>> rows;
  for (const auto& f : table.figures)
    if (f.runs > 0) rows.push_back(figures_row(f));
  const std::string words = list(said(table));
  return page(
      "Table 2, measured",
      "Eight families of methods that make a map, and two of today: the word that the thesis "
      "has for each (grey; red where what was measured says otherwise), and below it the "
      "measurement. " +
          table.what,
      std::string(kStyle) + section("The table", table_html(table)) +
          section("In numbers, medians over the usual drives", draw::table(kFigures, rows)) +
          (said(table).empty() ? "" : section("What methods said that could not", words)),
      "Drawn by majak. Rest the pointer on a cell to see the command that measures it.");
}

std::string table2_markdown(const eval::Table2& table) {
  std::vector<std::string> head{""};
  for (const auto& column : table.columns) head.push_back(column.name);
  std::vector<std::vector<std::string>> rows, figures;
  for (const auto& row : table.rows) {
    rows.push_back({row.name});
    for (const auto& cell : row.cells)
      rows.back().push_back((cell.word.empty() ? "" : "*" + cell.word + "*: ") +
                            (cell.measured.empty() ? "–" : cell.measured) +
                            (cell.agrees && !*cell.agrees ? " (!)" : ""));
  }
  for (const auto& f : table.figures)
    if (f.runs > 0) figures.push_back(figures_row(f));
  std::string out = table.what + "\n\n" + markdown_table(head, rows) +
                    "\n(!): measured otherwise than the word says. Rows:\n\n";
  for (const auto& row : table.rows) out += "- " + row.name + ": " + row.question + "\n";
  out += "\n" + markdown_table(kFigures, figures);
  for (const std::string& why : said(table)) out += "\n- " + why;
  return out;
}

std::string table2_json(const eval::Table2& table) {
  Json json;
  json["what"] = table.what;
  for (const auto& row : table.rows) {
    Json cells = Json::object();
    for (std::size_t c = 0; c < row.cells.size(); ++c) {
      const auto& cell = row.cells[c];
      Json& out = cells[table.columns[c].name];
      out["word"] = cell.word, out["measured"] = cell.measured, out["command"] = cell.command;
      if (cell.agrees) out["agrees"] = *cell.agrees;
    }
    json["rows"].push_back({{"name", row.name}, {"question", row.question}, {"cells", cells}});
  }
  for (const auto& f : table.figures) {
    Json out = {{"method", f.method},
                {"runs", f.runs},
                {"usable", f.usable},
                {"rms_m", f.rms},
                {"worst_m", f.worst},
                {"map_error_m", f.map_error},
                {"cpu_ms_a_scan", f.ms_a_scan},
                {"memory_bytes", f.bytes},
                {"said", f.said}};
    if (f.relation) out["relation_error_m"] = *f.relation;
    if (f.nees) out["nees"] = *f.nees;
    json["figures"].push_back(out);
  }
  return json.dump(2) + "\n";
}

}  // namespace majak::draw
