// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace majak::app {

/// `majak info lms291`: the sensor's sheet, for people or as JSON.
void print_lms291_sheet(bool json);

}  // namespace majak::app
