// SPDX-License-Identifier: Apache-2.0
// The random streams of a simulated run: RandomStream(seed, one of these + step, index). Each
// purpose has its own, so that switching one error off leaves the draws of the others alone.
#pragma once

#include <cstdint>

namespace majak::sim {

inline constexpr std::uint64_t kWheelRun = 1ULL << 40;
inline constexpr std::uint64_t kWheelNoise = 2ULL << 40;  // index: tick
inline constexpr std::uint64_t kLaserRun = 3ULL << 40;
inline constexpr std::uint64_t kBeam = 4ULL << 40;         // + scan, index: beam
inline constexpr std::uint64_t kWalker = 5ULL << 40;       // index: person
inline constexpr std::uint64_t kStamps = 6ULL << 40;       // index: scan
inline constexpr std::uint64_t kDisturbance = 7ULL << 40;  // index: its number
inline constexpr std::uint64_t kBurst = 8ULL << 40;        // 0: lengths, index - 1: burst
inline constexpr std::uint64_t kFix = 9ULL << 40;          // index: fix
inline constexpr std::uint64_t kFixJump = 10ULL << 40;
inline constexpr std::uint64_t kFelled = 11ULL << 40;      // index: disc
inline constexpr std::uint64_t kVehicle = 12ULL << 40;     // index: vehicle
inline constexpr std::uint64_t kFurnishing = 13ULL << 40;  // + visit, index: attempt
inline constexpr std::uint64_t kDoorRun = 14ULL << 40;     // index: door
inline constexpr std::uint64_t kSecondBeam = 15ULL << 40;  // + scan, index: beam

}  // namespace majak::sim
