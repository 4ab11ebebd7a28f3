// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "majak/io/number.hpp"

namespace majak::eval {

/// A line that says nothing: blank, or one that begins with #.
inline bool is_comment(std::string_view line) {
  const std::string_view first = io::Fields(line).word();
  return first.empty() || first.front() == '#';
}

}  // namespace majak::eval
