// SPDX-License-Identifier: Apache-2.0
// The fixed text of the report: its style sheet and its script.
#pragma once

#include <string_view>

namespace majak::draw {

std::string_view report_style();
std::string_view report_script();

}  // namespace majak::draw
