// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/core.h>

#include <charconv>
#include <cstddef>
#include <string>
#include <utility>

#include "majak/core/error.hpp"

namespace majak::app {

/// "151-945": the scans that a closure joins. Throws Error that names the option.
inline std::pair<std::size_t, std::size_t> scan_pair(const char* option, const std::string& text) {
  std::size_t from = 0, to = 0;
  const char *begin = text.data(), *end = begin + text.size();
  const auto first = std::from_chars(begin, end, from);
  const bool dash = first.ec == std::errc{} && first.ptr != end && *first.ptr == '-';
  const auto second = dash ? std::from_chars(first.ptr + 1, end, to) : first;
  if (!dash || second.ec != std::errc{} || second.ptr != end)
    throw Error(fmt::format("{} {}: two scan numbers are expected, as in 151-945", option, text));
  return {from, to};
}

}  // namespace majak::app
