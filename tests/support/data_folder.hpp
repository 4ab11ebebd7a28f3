// SPDX-License-Identifier: Apache-2.0
// Where real logs are: the data folder, which is not part of the project.
#pragma once

#include <cstdlib>
#include <filesystem>

namespace majak {

/// The environment's MAJAK_DATA, else the place beside the checkout. It may not be there: a test
/// that needs it is left out then, visibly.
inline std::filesystem::path data_folder() {
  if (const char* folder = std::getenv("MAJAK_DATA")) return folder;
  const auto root = std::filesystem::path(__FILE__).parent_path() / "../..";
  return root / "../shared/data";
}

}  // namespace majak
