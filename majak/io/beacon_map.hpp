// SPDX-License-Identifier: Apache-2.0
// Beacon map files: a line a beacon, `number x y [name]`, metres; '#' begins a comment.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "majak/beacon/beacon_map.hpp"

namespace majak::io {

/// `name` is used in messages. Throws Error (name:line) for a line that is none, a number or a
/// place that is there twice, and a file without beacons.
beacon::BeaconMap parse_beacon_map(std::string_view text, const std::string& name);

/// parse_beacon_map() of a file, plain, gzip or bzip2.
beacon::BeaconMap read_beacon_map(const std::filesystem::path& path);

}  // namespace majak::io
