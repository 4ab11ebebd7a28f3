// SPDX-License-Identifier: Apache-2.0
// The bricks of SVG and HTML text: numbers, escapes, paths, embedded bytes. Equal input, equal
// bytes.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace majak::draw {

struct Point {
  double x = 0, y = 0;
  bool operator==(const Point&) const = default;
};

/// Fixed decimals without idle zeros ("1.5", "0", never "-0"); not-a-number and infinities print as
/// 0.
std::string number(double value, int decimals = 2);

/// Whole numbers with thin gaps between the thousands, as HTML.
std::string grouped(long long value);

/// & < > " ' as entities, control characters as spaces.
std::string escape(std::string_view text);

/// RFC 4648.
std::string base64(std::string_view bytes);

/// The points needed so that no dropped one is farther than the tolerance from the line through the
/// kept ones; first and last stay (Douglas and Peucker 1973).
std::vector<Point> simplify(const std::vector<Point>& points, double tolerance);

/// "M1 2L3 4...": the d of an SVG path; empty for no points.
std::string path_data(const std::vector<Point>& points, int decimals = 1);

}  // namespace majak::draw
