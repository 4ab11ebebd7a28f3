// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdlib>

#include "majak/io/ros1_bag.hpp"
#include "majak/io/ros_source.hpp"
#include "tests/fuzz/fuzz.hpp"

/// Any bytes as a ROS 1 bag, read to the end as messages and as events; ranges are what Scan
/// promises.
MAJAK_FUZZ(bytes) {
  using namespace majak;
  const io::OpenMessages open = [&](io::Depth depth) {
    return std::make_unique<io::Ros1Bag>(io::open_bytes_in_memory(bytes).bytes, depth);
  };
  const auto log = open(io::Depth::messages);
  io::Message message;
  while (log->next(message)) log->topics().at(message.topic);
  io::RosSource source(open, "bag", {});
  while (const auto event = source.next()) {
    const Scan* scan = std::get_if<Scan>(&*event);
    if (scan == nullptr) continue;
    for (const float range : scan->ranges) {
      const bool sound =
          std::isnan(range) || range == kNoReturn || (range > 0 && range < scan->max_range);
      if (!sound) std::abort();
    }
  }
}
