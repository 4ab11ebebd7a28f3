// SPDX-License-Identifier: Apache-2.0
// Letters made of strokes, for pictures: Latin, digits, and the signs and Greek letters that
// figures need. No font file is needed, and equal text gives equal pixels everywhere.
#pragma once

#include <string_view>
#include <vector>

#include "majak/draw/svg.hpp"

namespace majak::draw {

/// Lines of a text set in UTF-8 at `size` (the height of an em), from (0, 0) on the baseline to the
/// right, y downwards. A dot is a line of no length; unknown letters are small boxes.
std::vector<std::vector<Point>> letter_strokes(std::string_view text, double size);

/// Its width.
double text_width(std::string_view text, double size);

/// Width of the pen that suits the size.
inline double letter_pen(double size) { return 0.085 * size; }

}  // namespace majak::draw
