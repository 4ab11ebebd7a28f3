// SPDX-License-Identifier: Apache-2.0
// Lines of blank-separated numbers, shared by the readers of this layer.
#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

namespace majak::eval {

/// The fields of a line; none for a blank line or a comment (#).
inline std::vector<std::string_view> split_fields(std::string_view line) {
  constexpr std::string_view kBlank = " \t\r\n,";
  std::vector<std::string_view> fields;
  std::size_t begin = line.find_first_not_of(kBlank);
  while (begin != std::string_view::npos) {
    if (fields.empty() && line[begin] == '#') return {};
    const std::size_t end = std::min(line.find_first_of(kBlank, begin), line.size());
    fields.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kBlank, end);
  }
  return fields;
}

/// N finite numbers from fields[first] on, or nothing.
template <std::size_t N>
std::optional<std::array<double, N>> parse_numbers(const std::vector<std::string_view>& fields,
                                                   std::size_t first) {
  if (fields.size() < first + N) return std::nullopt;
  std::array<double, N> values{};
  for (std::size_t i = 0; i < N; ++i) {
    const std::string_view text = fields[first + i];
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, values[i]);
    if (error != std::errc{} || stop != end || !std::isfinite(values[i])) return std::nullopt;
  }
  return values;
}

}  // namespace majak::eval
