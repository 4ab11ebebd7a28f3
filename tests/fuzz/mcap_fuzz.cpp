// SPDX-License-Identifier: Apache-2.0
#include "majak/io/mcap_reader.hpp"
#include "majak/io/ros_source.hpp"
#include "tests/fuzz/fuzz.hpp"

/// Any bytes as an MCAP file, read to the end as messages and as events.
MAJAK_FUZZ(bytes) {
  using namespace majak::io;
  const OpenMessages open = [&](Depth depth) {
    return std::make_unique<McapReader>(open_bytes_in_memory(bytes).bytes, depth);
  };
  const auto log = open(Depth::messages);
  Message message;
  while (log->next(message)) log->topics().at(message.topic);
  RosSource source(open, "mcap", {});
  while (source.next()) {
  }
}
