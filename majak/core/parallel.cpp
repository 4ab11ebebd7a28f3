// SPDX-License-Identifier: Apache-2.0
#include "majak/core/parallel.hpp"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

namespace majak {

void parallel_for(Threads threads, std::size_t n, const std::function<void(std::size_t)>& body) {
  if (threads.count <= 1 || n < 2) {
    for (std::size_t i = 0; i < n; ++i) body(i);
    return;
  }
  // As many as were asked for, also where there are fewer cores.
  const oneapi::tbb::global_control allowed(oneapi::tbb::global_control::max_allowed_parallelism,
                                            static_cast<std::size_t>(threads.count));
  oneapi::tbb::task_arena arena(threads.count);
  arena.execute([&] { oneapi::tbb::parallel_for(std::size_t{0}, n, body); });
}

}  // namespace majak
