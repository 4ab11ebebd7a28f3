// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/thesis_figures.hpp"

#include <algorithm>
#include <string>

#include "majak/core/error.hpp"

namespace majak::draw {
namespace {

const ThesisFigure kFigures[] = {
    {"2", "Ackermann: all wheels turn about one point on the line of the fixed axle", false,
     figure_ackermann},
    {"3", "differential drive: straight, arc, spin", false, figure_differential},
    {"4", "omnidirectional drive: three wheels, and a motion that no other can make", false,
     figure_omnidirectional},
    {"5", "dead reckoning: its ellipses along a path, and robots that drove it", true,
     figure_dead_reckoning},
    {"6", "trilateration: two circles meet in two places; a third decides", false,
     figure_trilateration},
    {"7", "triangulation, and its error over the plane with the danger circle", false,
     figure_triangulation},
    {"8", "Kalman filter: prediction by wheels, correction by fixes, and the gain of one number",
     false, figure_kalman},
    {"9", "Monte Carlo localization: particles anywhere, after the first scan, after 15", false,
     figure_monte_carlo},
    {"10", "Markov localization in a corridor: sees a door, moves, sees a door again", false,
     figure_markov},
    {"12", "time of flight: the mirror turns, pulses come back, the contour grows", true,
     figure_mirror},
    {"13", "odometry of a mis-measured robot: true and believed trajectory, error by distance",
     true, figure_drift},
    {"14", "a large ring: scan by scan its ends do not meet; with its loop closed they do", false,
     figure_ring},
    {"15", "SLAM: scans and motions go in, the path and the map come out together", false,
     figure_slam},
    {"16", "EKF-SLAM under water: ellipses of fourteen features shrink as the loop closes", false,
     figure_sonar},
    {"17", "an office building mapped by matching alone, beside the truth", false, figure_office},
    {"18", "obstacle inflation: a grid's obstacles grow by the robot's size, in both meanings",
     false, figure_inflation},
    {"19",
     "a corridor with doorways seen by wide beams: each cell by itself, and the forward model",
     false, figure_forward},
    {"20", "a map of objects: the planes that an upright laser saw in rooms, as polygons", false,
     figure_solid},
    {"21", "Dogma: nine grids of a room over time, what stays, and the objects that move", false,
     figure_dogma},
    {"22", "one place as a grid of 144400 cells and as segments, and what each takes", false,
     figure_segments},
    {"22b", "the demonstration in a park: route and trunks, true and as seen; errors over range",
     false, figure_park},
};

}  // namespace

std::span<const ThesisFigure> thesis_figures() { return kFigures; }

const ThesisFigure& thesis_figure(std::string_view name) {
  const auto found = std::find_if(std::begin(kFigures), std::end(kFigures),
                                  [&](const ThesisFigure& f) { return name == f.name; });
  if (found != std::end(kFigures)) return *found;
  std::string names;
  for (const ThesisFigure& f : kFigures) names += (names.empty() ? "" : ", ") + std::string(f.name);
  throw Error("no figure " + std::string(name) + "; there are: " + names);
}

}  // namespace majak::draw
