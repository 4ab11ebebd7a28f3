// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>

#include "majak/io/ros_messages.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace {

/// What is accepted is written, accepted again, and then has the same bytes.
template <class M>
void there_and_back(const std::string& bytes, majak::io::ros::Encoding encoding) {
  M message;
  decode(bytes, encoding, message);
  const std::string once = encode(message, encoding);
  M again;
  decode(once, encoding, again);
  if (encode(again, encoding) != once) std::abort();
}

}  // namespace

/// The first byte says which message and which serialisation.
MAJAK_FUZZ(bytes) {
  using namespace majak::io::ros;
  if (bytes.empty()) return;
  const std::string rest = bytes.substr(1);
  const Encoding encoding = (bytes[0] & 4) != 0 ? Encoding::cdr : Encoding::ros1;
  switch (bytes[0] & 3) {
    case 0:
      return there_and_back<LaserScan>(rest, encoding);
    case 1:
      return there_and_back<Odometry>(rest, encoding);
    case 2:
      return there_and_back<TransformList>(rest, encoding);
    default:
      return there_and_back<NavSatFix>(rest, encoding);
  }
}
