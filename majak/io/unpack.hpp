// SPDX-License-Identifier: Apache-2.0
// Packed pieces of recordings: bzip2, LZ4 frames and Zstandard frames.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace majak::io {

enum class ChunkPacking : std::uint8_t { none, bzip2, lz4, zstd };

/// Unpacks into `out` what `packed` holds, `limit` bytes at most; `out` grows with what really
/// comes out, so that no size stated in a file decides about memory. False when the bytes are
/// damaged, end early or hold more than the limit; `out` then has what came before that.
bool unpack(ChunkPacking packing, std::string_view packed, std::size_t limit, std::string& out);

/// Packs as one frame; nothing but Zstandard and LZ4.
std::string pack(ChunkPacking packing, std::string_view plain);

/// A gzip file's bytes; the same for the same input.
std::string gzip(std::string_view plain);

}  // namespace majak::io
