// SPDX-License-Identifier: Apache-2.0
// Parallel loops whose result does not depend on the number of threads: body(i) writes only to what
// belongs to i, and whoever reduces does it afterwards in index order.
#pragma once

#include <cstddef>
#include <functional>

namespace majak {

/// How many threads a call may use. Value type, handed down; there is no global setting.
struct Threads {
  int count = 1;  ///< 1 ... hardware
};

/// body(i) for i in [0, n), on threads.count threads; exceptions reach the caller.
void parallel_for(Threads threads, std::size_t n, const std::function<void(std::size_t)>& body);

}  // namespace majak
