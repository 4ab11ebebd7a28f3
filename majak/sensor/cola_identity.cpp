// SPDX-License-Identifier: Apache-2.0
#include "majak/sensor/cola_identity.hpp"

#include <array>

namespace majak::sensor {
namespace {

constexpr int kLengthBytes = 2;  // of the lengths before the texts

struct Reach {
  std::string_view begins;
  double range;  // m
};
// Those that say more come first. A family's name alone stands for the one that sees farthest: a
// return that is too far can be told later, one that was cut off is gone.
constexpr std::array<Reach, 16> kReach{{{"LMS1000", 64},
                                        {"LMS10", 20},
                                        {"LMS11", 20},
                                        {"LMS12", 20},
                                        {"LMS15", 50},
                                        {"LMS1xxx", 64},
                                        {"LMS1", 50},
                                        {"LMS5", 80},
                                        {"TiM24", 10},
                                        {"TiM31", 4},
                                        {"TiM32", 4},
                                        {"TiM3", 10},
                                        {"TiM55", 10},
                                        {"TiM56", 10},
                                        {"TiM5", 25},
                                        {"TiM7", 25}}};

}  // namespace

ColaIdentity decode_identity(const ColaTelegram& telegram) {
  ColaCursor in(telegram);
  ColaIdentity identity;
  identity.name = in.text("the device's name", kLengthBytes);
  identity.version = in.text("the firmware's version", kLengthBytes);
  return identity;
}

ColaWriter tell_identity(const ColaIdentity& identity, ColaDialect dialect) {
  ColaWriter out(dialect, "sRA DeviceIdent");
  out.text(identity.name, kLengthBytes).text(identity.version, kLengthBytes);
  return out;
}

std::optional<double> cola_reach(std::string_view name) {
  for (const Reach& reach : kReach)
    if (name.starts_with(reach.begins)) return reach.range;
  return {};
}

}  // namespace majak::sensor
