// SPDX-License-Identifier: Apache-2.0
#include "majak/io/source.hpp"

#include "majak/core/error.hpp"

namespace majak::io {

Source::~Source() = default;

std::unique_ptr<Source> open_log(const std::filesystem::path& path) {
  throw Error(path.string() + ": not a log that can be read");
}

}  // namespace majak::io
