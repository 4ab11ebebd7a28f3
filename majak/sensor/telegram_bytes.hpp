// SPDX-License-Identifier: Apache-2.0
// Reading and writing of the bytes between a telegram's code and its status.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace majak::sensor {

/// A 16-bit number, low byte first; i must be inside.
inline std::uint16_t get_16(std::span<const std::uint8_t> bytes, std::size_t i) {
  return static_cast<std::uint16_t>(bytes[i] | bytes[i + 1] << 8);
}

inline void set_16(std::span<std::uint8_t> bytes, std::size_t i, unsigned value) {
  bytes[i] = static_cast<std::uint8_t>(value & 0xFF);
  bytes[i + 1] = static_cast<std::uint8_t>(value >> 8 & 0xFF);
}

inline void put_16(std::vector<std::uint8_t>& bytes, unsigned value) {
  bytes.push_back(static_cast<std::uint8_t>(value & 0xFF));
  bytes.push_back(static_cast<std::uint8_t>(value >> 8 & 0xFF));
}

}  // namespace majak::sensor
