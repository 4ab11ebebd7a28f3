// SPDX-License-Identifier: Apache-2.0
// The viewer's files (viewer/), which the program carries in itself.
#pragma once

#include <string_view>

namespace majak::draw {

struct ViewerPage {
  std::string_view html, script, style;
};

/// All of it empty where the program was built without npm.
ViewerPage viewer_page();

}  // namespace majak::draw
