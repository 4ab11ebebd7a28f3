// SPDX-License-Identifier: Apache-2.0
// The thesis's figures, drawn from our own models: one file a figure, one row in the table.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "majak/core/event.hpp"
#include "majak/draw/figure.hpp"

namespace majak::draw {

struct ThesisFigure {
  const char* name;  ///< its number; where the thesis uses one twice, a letter tells which
  const char* shows;
  bool takes_log;  ///< can also be drawn from the events of a log
  /// `events`: of a log, in its order; empty: the built-in example.
  Figure (*make)(const std::vector<Event>& events);
};

/// By number.
std::span<const ThesisFigure> thesis_figures();

/// "5", "22b"; throws Error that lists the names there are.
const ThesisFigure& thesis_figure(std::string_view name);

Figure figure_ackermann(const std::vector<Event>& events);        // 2
Figure figure_differential(const std::vector<Event>& events);     // 3
Figure figure_omnidirectional(const std::vector<Event>& events);  // 4
Figure figure_dead_reckoning(const std::vector<Event>& events);   // 5
Figure figure_trilateration(const std::vector<Event>& events);    // 6
Figure figure_triangulation(const std::vector<Event>& events);    // 7
Figure figure_kalman(const std::vector<Event>& events);           // 8
Figure figure_monte_carlo(const std::vector<Event>& events);      // 9
Figure figure_markov(const std::vector<Event>& events);           // 10
Figure figure_mirror(const std::vector<Event>& events);           // 12
Figure figure_drift(const std::vector<Event>& events);            // 13
Figure figure_ring(const std::vector<Event>& events);             // 14
Figure figure_slam(const std::vector<Event>& events);             // 15
Figure figure_sonar(const std::vector<Event>& events);            // 16
Figure figure_office(const std::vector<Event>& events);           // 17
Figure figure_inflation(const std::vector<Event>& events);        // 18
Figure figure_forward(const std::vector<Event>& events);          // 19
Figure figure_solid(const std::vector<Event>& events);            // 20
Figure figure_dogma(const std::vector<Event>& events);            // 21
Figure figure_segments(const std::vector<Event>& events);         // 22
Figure figure_park(const std::vector<Event>& events);             // 22b

}  // namespace majak::draw
