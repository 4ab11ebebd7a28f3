// SPDX-License-Identifier: Apache-2.0
// Options as they may be: what describe() says of them, asked for.
#pragma once

#include <string>
#include <variant>

#include "majak/core/error.hpp"
#include "majak/core/options.hpp"

namespace majak {

/// Throws Error (which one) when an option is not a number or out of its range.
template <class Options>
void require_in_range(Options options) {
  OptionFields fields;
  describe(fields, options);
  for (const OptionField& field : fields.list) {
    if (std::holds_alternative<bool*>(field.value)) continue;
    const auto* whole = std::get_if<int*>(&field.value);
    const double value = whole ? **whole : *std::get<double*>(field.value);
    if (!(value >= field.info.min && value <= field.info.max))
      throw Error("option " + field.name + " is out of its range");
  }
}

}  // namespace majak
