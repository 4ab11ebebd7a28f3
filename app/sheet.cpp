// SPDX-License-Identifier: Apache-2.0
#include "app/sheet.hpp"

#include <fmt/core.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "majak/sensor/lms291.hpp"
#include "majak/sensor/lms_telegrams.hpp"

namespace majak::app {
namespace {

using Json = nlohmann::ordered_json;
using sensor::kBauds;
using sensor::kLms291;
using sensor::kVariants;

Json sheet_json() {
  Json json = {{"sensor", "SICK LMS-291"},
               {"mirror_hz", kLms291.mirror_rate},
               {"resolution_m", kLms291.resolution},
               {"systematic_error_m", kLms291.systematic_error},
               {"statistical_error_m", kLms291.statistical_error},
               {"range_cm_mode_m", kLms291.range_cm_mode},
               {"range_mm_mode_m", kLms291.range_mm_mode},
               {"range_at_10_percent_m", kLms291.range_at_10_percent},
               {"spot_at_window_m", kLms291.spot_at_window},
               {"divergence_rad", kLms291.divergence},
               {"wavelength_m", kLms291.wavelength},
               {"supply_v", kLms291.supply},
               {"supply_tolerance", kLms291.supply_tolerance},
               {"power_w", kLms291.power},
               {"mass_kg", kLms291.mass},
               {"size_m", kLms291.size},
               {"variants", Json::array()}};
  for (const sensor::Variant& v : kVariants) {
    Json rates = Json::object();
    for (const int baud : kBauds) rates[std::to_string(baud)] = sensor::delivered_rate(v, baud);
    json["variants"].push_back({{"field_of_view_deg", v.field_of_view},
                                {"resolution_deg", v.resolution / 100.0},
                                {"beams", v.beams()},
                                {"scan_hz", kLms291.mirror_rate / v.turns()},
                                {"delivered_hz", rates}});
  }
  return json;
}

template <class... Args>
void sheet_line(const char* label, fmt::format_string<Args...> text, Args&&... args) {
  fmt::print("  {:<18} {}\n", label, fmt::format(text, std::forward<Args>(args)...));
}

void print_for_people() {
  const auto& s = kLms291;
  fmt::print("SICK LMS-291, 2-D laser range-finder by time of flight: distance = c t / 2\n\n");
  sheet_line("range",
             "{:.0f} m in centimetres, {:.0f} m in millimetres; {:.0f} m on a target of 10 %",
             s.range_cm_mode, s.range_mm_mode, s.range_at_10_percent);
  sheet_line("errors", "systematic +-{:.0f} mm, statistical {:.0f} mm (1 sigma), 1 ... 20 m",
             1e3 * s.systematic_error, 1e3 * s.statistical_error);
  sheet_line("resolution", "{:.0f} mm", 1e3 * s.resolution);
  sheet_line("sensitivity", "standard 30 m, medium 25 m, low 20 m, high 42 m on a target of 10 %");
  sheet_line("mirror",
             "{:.0f} Hz; a scan takes {:.0f}, {:.0f} or {:.0f} ms at 1, 0.5, 0.25 degrees",
             s.mirror_rate, 1e3 / s.mirror_rate, 2e3 / s.mirror_rate, 4e3 / s.mirror_rate);
  sheet_line("beam", "{:.0f} nm, {:.0f} mm at the window, spreads by {:.1f} mm a metre",
             1e9 * s.wavelength, 1e3 * s.spot_at_window, 1e3 * s.divergence);
  sheet_line("serial", "RS-232 to 38400 Bd, RS-422 to 500000 Bd; 8N1; telegrams with CRC");
  sheet_line("supply", "{:.0f} V +-{:.0f} %, {:.0f} W", s.supply, 100 * s.supply_tolerance,
             s.power);
  sheet_line("mass, size", "{:.1f} kg, {:.0f} x {:.0f} x {:.0f} mm", s.mass, 1e3 * s.size[0],
             1e3 * s.size[1], 1e3 * s.size[2]);
  fmt::print("\n  variant            beams   scans a second; that arrive at");
  for (const int baud : kBauds) fmt::print(" {:>7}", baud);
  fmt::print(" Bd\n");
  for (const sensor::Variant& v : kVariants) {
    fmt::print("  {} deg / {:<5.4g} deg  {:>4}   {:>14.2f}               ", v.field_of_view,
               v.resolution / 100.0, v.beams(), s.mirror_rate / v.turns());
    for (const int baud : kBauds) fmt::print(" {:>7.2f}", sensor::delivered_rate(v, baud));
    fmt::print("\n");
  }
  fmt::print("\nWiring, modes and rescue: docs/SENSOR.md\n");
}

}  // namespace

void print_lms291_sheet(bool json) {
  if (json)
    fmt::print("{}\n", sheet_json().dump(2));
  else
    print_for_people();
}

}  // namespace majak::app
