// SPDX-License-Identifier: Apache-2.0
// The blob of a scan in the site file: what its row does not have as columns, bit by bit.
#pragma once

#include <string>
#include <string_view>

#include "majak/core/site.hpp"

namespace majak::io {

/// Appends the blob.
void pack_scan(const PosedScan& posed, std::string& out);

/// Fills in what pack_scan() stored; scan.time must be set. Throws Error for bytes that no
/// pack_scan() wrote.
void unpack_scan(std::string_view bytes, PosedScan& posed);

}  // namespace majak::io
