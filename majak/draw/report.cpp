// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "majak/draw/chart.hpp"
#include "majak/draw/findings.hpp"
#include "majak/draw/map_figure.hpp"
#include "majak/draw/report_page.hpp"
#include "majak/draw/site_view.hpp"
#include "majak/draw/svg.hpp"
#include "majak/draw/viewer_page.hpp"
#include "majak/io/unpack.hpp"

namespace majak::draw {

namespace {

constexpr std::size_t kClosureRows = 400, kSlipRows = 10;
constexpr std::size_t kViewedScans = 4000;  // so that the page of a long run still opens

std::string tiles(const io::Figures& f) {
  std::string out = "<div class=\"tiles\">\n";
  out += tile(metres(f.path_m), "driven", "in " + clock(f.duration_s));
  out += tile(grouped(std::llround(f.known_area_m2)) + " m²", "seen",
              fmt::format("on {} x {} m", number(f.width_m, 0), number(f.height_m, 0)));
  out += tile(grouped(static_cast<long long>(f.scans)), "scans",
              fmt::format("{} key scans", f.key_scans));
  out += tile(grouped(static_cast<long long>(f.closures)),
              f.closures == 1 ? "loop closure" : "loop closures",
              fmt::format("{} more rejected", f.closures_rejected));
  out += tile("±" + metres(f.position_sigma_median_m), "sure of the place",
              "worst ±" + metres(f.position_sigma_max_m));
  out += tile(fmt::format("±{}°", number(degrees(f.heading_sigma_median_rad), 2)),
              "sure of the heading",
              fmt::format("worst ±{}°", number(degrees(f.heading_sigma_max_rad), 2)));
  return out + "</div>\n";
}

std::string map_section(const Site& site, const map::OccupancyGrid& grid, const Paths& paths) {
  const MapFigure figure = map_figure(site, grid, paths);
  return section("The map", switched_map(figure.svg, figure.layers) +
                                "<p class=\"soft\">Drag to move; double click or Ctrl and the "
                                "wheel to zoom; closures and ellipses tell "
                                "more under the pointer.</p>\n");
}

/// What majak view shows, with the run in it; nothing where the program was built without.
std::string viewer_section(const Site& site, const map::OccupancyGrid& grid) {
  const ViewerPage viewer = viewer_page();
  if (viewer.script.empty() || site.scans.empty()) return "";
  const std::shared_ptr<const Site> borrowed(&site, [](const Site*) {});
  const SiteView view(borrowed, {.keys_only = true, .most_scans = kViewedScans});
  std::string script(viewer.script);
  for (std::size_t at = 0; (at = script.find("</script", at)) != std::string::npos; at += 2)
    script.insert(at + 1, "\\");
  std::string out = "<div class=\"wide\"><div id=\"majak-viewer\"></div></div>\n<style>";
  out += viewer.style;
  out += "</style>\n<script type=\"application/octet-stream;base64\" id=\"majak-data\">";
  out += base64(io::gzip(view_stream(view, grid)));
  out += "</script>\n<script data-mount=\"majak-viewer\">" + script + "</script>\n";
  return out;
}

std::string path_section(const Paths& paths) {
  if (paths.final.size() < 2) return "";
  std::string key = "<div class=\"keys\">\n";
  const auto add = [&](const std::vector<Point>& path, const char* style, const char* label) {
    if (path.empty()) return;
    key += fmt::format("<span><i class=\"swatch\" style=\"--c:var(--{})\"></i> {}</span>\n", style,
                       label);
  };
  add(paths.odometry, "odometry", "odometry alone");
  add(paths.front_end, "before", "before loop closing");
  add(paths.truth, "truth", "truth");
  add(paths.final, "after", "after");
  return section("Before and after", path_figure(paths) + key + "</div>\n");
}

/// Stretches that are not ok, in minutes since the first scan.
std::vector<Band> health_bands(const Site& site, Time start) {
  std::vector<Band> bands;
  Health last = Health::ok;
  for (const PosedScan& posed : site.scans) {
    const Health health = posed.estimate.health;
    const double minutes = to_seconds(posed.scan.time - start) / 60;
    if (last != Health::ok && !bands.empty()) bands.back().to = std::max(bands.back().to, minutes);
    if (health != last && health != Health::ok) {
      bands.push_back({minutes, minutes, health == Health::lost ? "lost" : "weak"});
    }
    last = health;
  }
  return bands;
}

/// Bands too near to be told apart become one, the worse one; so a flickering log stays small.
std::vector<Band> joined(const std::vector<Band>& bands, double gap) {
  std::vector<Band> out;
  for (const Band& band : bands) {
    if (!out.empty() && band.from - out.back().to < gap) {
      out.back().to = std::max(out.back().to, band.to);
      if (band.style == "lost") out.back().style = "lost";
    } else {
      out.push_back(band);
    }
  }
  return out;
}

template <class Value>
std::string chart_of(const Site& site, Time start, Chart chart, Value value) {
  for (const PosedScan& posed : site.scans) {
    chart.points.push_back({to_seconds(posed.scan.time - start) / 60, value(posed)});
  }
  return chart_svg(chart);
}

std::string chart_section(const Site& site, const io::Figures& f) {
  if (site.scans.size() < 2) return "";
  Time start = site.scans.front().scan.time;
  for (const PosedScan& posed : site.scans) start = std::min(start, posed.scan.time);
  const std::vector<Band> bands = joined(health_bands(site, start), f.duration_s / 60 / 400);
  std::string out =
      chart_of(site, start, {"Position, one sigma (larger axis)", "cm", {}, bands, 0},
               [](const PosedScan& p) { return 100 * least_known(p.estimate.covariance).sigma; });
  out += chart_of(site, start, {"Heading, one sigma", "degrees", {}, bands, 0},
                  [](const PosedScan& p) {
                    return degrees(std::sqrt(std::max(0.0, p.estimate.covariance(2, 2))));
                  });
  out += chart_of(site, start, {"Share of the beams that fit the map", "", {}, bands, 1},
                  [](const PosedScan& p) { return static_cast<double>(p.match_score); });
  if (!bands.empty()) {
    out +=
        "<div class=\"keys\"><span><i class=\"swatch\" style=\"--c:var(--weak)\"></i> weakly "
        "held</span>"
        "<span><i class=\"swatch\" style=\"--c:var(--lost)\"></i> lost</span></div>\n";
  }
  return section("Over time", out);
}

std::string closure_row(const Site& site, std::size_t index) {
  const Constraint& c = site.constraints[index];
  const double apart = to_seconds(site.scans[c.to].scan.time - site.scans[c.from].scan.time);
  const Pose2 found =
      between(site.scans[c.from].estimate.T_map_robot, site.scans[c.to].estimate.T_map_robot);
  const Pose2 left = between(c.T_from_to, found);
  constexpr const char* kVerdicts[] = {"fits", "under strain", "fits badly", "rejected"};
  const Fit fit = fit_of(c);
  const char* colour = fit == Fit::rejected ? "odometry" : style_of(fit);
  return fmt::format(
      "<tr data-closure=\"c{}\"><td class=\"l\"><i class=\"dot\" "
      "style=\"--c:var(--{})\"></i>{}</td><td>{}</td><td>{}</td>"
      "<td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
      index, colour, kVerdicts[static_cast<std::size_t>(fit)], c.from, c.to,
      number(std::abs(apart), 0), number(100 * c.score, 0), number(100 * c.overlap, 0),
      number(100 * left.translation().norm(), 1), number(degrees(std::abs(left.theta)), 2),
      number(c.chi2, 1));
}

std::string closure_section(const Site& site, const io::Figures& f) {
  std::vector<std::size_t> closures;
  for (std::size_t i = 0; i < site.constraints.size(); ++i) {
    if (site.constraints[i].kind == ConstraintKind::closure) closures.push_back(i);
  }
  if (closures.empty())
    return section("Loop closures", "<p class=\"soft\">None: no place was recognised again.</p>\n");
  std::string out = fmt::format(
      "<p class=\"soft\">{} accepted, {} rejected. The residual is what is left between the "
      "measured "
      "and the final relative pose.</p>\n",
      f.closures, f.closures_rejected);
  out +=
      "<div class=\"scroll\"><table class=\"sort\"><thead><tr><th "
      "class=\"l\">verdict</th><th>from</th><th>to</th><th>apart, "
      "s</th><th>fit, %</th><th>overlap, %</th><th>residual, cm</th><th>residual, "
      "°</th><th>chi²</th></tr></thead><tbody>\n";
  const std::size_t rows = std::min(closures.size(), kClosureRows);
  for (std::size_t i = 0; i < rows; ++i) out += closure_row(site, closures[i]);
  out += "</tbody></table></div>\n";
  if (rows < closures.size()) {
    out += fmt::format("<p class=\"soft\">The first {}; the other {} are in site.majak.</p>\n",
                       rows, closures.size() - rows);
  }
  return section("Loop closures", out);
}

std::string slip_table(const Site& site, const std::vector<motion::SlipEvent>& slips) {
  if (slips.empty()) return "";
  std::string out = fmt::format(
      "<p class=\"soft\">Slips and bumps, where wheels and laser disagree by more than their "
      "noise: "
      "{}{}.</p>\n<table><thead><tr><th class=\"l\">what</th><th>at, s</th><th>for, "
      "s</th><th>off by, cm</th><th>and, °</th></tr></thead><tbody>\n",
      grouped(static_cast<long long>(slips.size())),
      slips.size() > kSlipRows ? fmt::format("; the {} biggest", kSlipRows) : "");
  const Time start = site.scans.front().scan.time;
  for (std::size_t i = 0; i < std::min(slips.size(), kSlipRows); ++i) {
    const motion::SlipEvent& e = slips[i];
    out += fmt::format(
        "<tr><td class=\"l\">{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
        motion::name_of(e.kind), number(to_seconds(e.begin - start), 1),
        number(to_seconds(e.end - e.begin), 1), number(100 * e.way, 0), number(degrees(e.turn), 1));
  }
  return out + "</tbody></table>\n";
}

std::string figure_section(const std::string& title, const std::vector<io::NamedFigure>& figures) {
  std::vector<std::vector<std::string>> rows;
  for (const auto& [name, value] : figures) rows.push_back({name, number(value, 4)});
  return section(title, table({}, rows));
}

std::string options_section(const Site& site) {
  if (site.options_toml.empty()) return "";
  return fmt::format(
      "<section><details><summary>Options used</summary><pre>{}</pre></details></section>\n",
      escape(site.options_toml));
}

}  // namespace

std::string report_html(const Site& site, const map::OccupancyGrid& grid,
                        const ReportExtras& extras) {
  const io::Figures figures = io::figures_of(site, grid);
  const Paths paths = paths_of(site);
  std::string out = tiles(figures);
  out += viewer_section(site, grid);
  out += map_section(site, grid, paths);
  out += section("The odometry", list(odometry_in_words(site)) + slip_table(site, extras.slips));
  out += path_section(paths);
  out += chart_section(site, figures);
  out += closure_section(site, figures);
  out += figure_section("Measured against a reference", extras.evaluation);
  out += skipped_section(site.report);
  out += figure_section("Time it took", extras.timing);
  out += options_section(site);
  return page(site.source_name.empty() ? "the map" : site.source_name,
              verdict_in_words(site, figures), out,
              fmt::format("Drawn by majak{}{}. Grid of {} cm.", extras.version.empty() ? "" : " ",
                          extras.version, number(100 * grid.resolution(), 1)));
}

}  // namespace majak::draw
