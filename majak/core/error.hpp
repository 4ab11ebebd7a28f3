// SPDX-License-Identifier: Apache-2.0
// Error: the one exception for a bad file, option or device. what() is one line that says where and
// what to do; main() catches it once, prints it and exits with 1.
#pragma once

#include <stdexcept>

namespace majak {

struct Error : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace majak
