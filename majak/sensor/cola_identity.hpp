// SPDX-License-Identifier: Apache-2.0
// Who an LMS1xx, LMS5xx or TiM says it is, and how far such a device sees.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "majak/sensor/cola.hpp"

namespace majak::sensor {

struct ColaIdentity {
  std::string name;     ///< "LMS10x_FieldEval", "TiM561" ...
  std::string version;  ///< of the firmware
  bool operator==(const ColaIdentity&) const = default;
};

/// Reads "sRA DeviceIdent". Throws Error as ColaCursor does.
ColaIdentity decode_identity(const ColaTelegram& telegram);
ColaWriter tell_identity(const ColaIdentity& identity, ColaDialect dialect);

/// m, the longest range of the data sheet, by how the name begins: a telegram could state 65 m or
/// more whatever the device sees. Nothing for a name that is not known.
std::optional<double> cola_reach(std::string_view name);

}  // namespace majak::sensor
