// SPDX-License-Identifier: Apache-2.0
#include "majak/sensor/lms_configuration.hpp"

namespace majak::sensor {

double metres(Unit unit) {
  switch (unit) {
    case Unit::centimetre:
      return 0.01;
    case Unit::millimetre:
      return 0.001;
    case Unit::decimetre:
      return 0.1;
  }
  return 0;
}

LmsConfiguration LmsConfiguration::factory(std::size_t size) {
  LmsConfiguration c;
  c.raw.assign(size, 0);
  c.raw[2] = 0x46;
  c.raw[9] = c.raw[10] = 2;          // scans until a field counts as infringed; restart mode
  if (size == kSize) c.raw[32] = 2;  // scans until dazzle counts
  return c;
}

void LmsConfiguration::set_real_time_indices(bool on) {
  raw[4] = static_cast<std::uint8_t>(on ? raw[4] | 2 : raw[4] & ~2);
}

}  // namespace majak::sensor
