// SPDX-License-Identifier: Apache-2.0
#include "majak/io/unpack.hpp"

#include <bzlib.h>
#include <lz4frame.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <new>

#include "majak/core/error.hpp"

namespace majak::io {

namespace {

constexpr std::size_t kPiece = std::size_t{1} << 16;

enum class Step { more, end, damaged };

/// Room behind the `used` bytes of `out`: doubled as it fills, up to one byte beyond the limit, by
/// which too much is recognised.
void make_room(std::string& out, std::size_t used, std::size_t limit) {
  if (used < out.size()) return;
  out.resize(std::min(std::max(kPiece, 2 * used), limit + 1));
}

/// Runs a decoder: step(in, in_size, out, out_size) sets both sizes to what was used.
template <class Decoder>
bool run(Decoder&& decoder, std::string_view in, std::size_t limit, std::string& out) {
  std::size_t used = 0;
  Step step = Step::more;
  out.clear();
  while (step == Step::more && used <= limit) {
    make_room(out, used, limit);
    std::size_t in_size = in.size(), out_size = out.size() - used;
    step = decoder.step(in.data(), in_size, out.data() + used, out_size);
    in.remove_prefix(in_size);
    used += out_size;
    if (step == Step::more && in_size == 0 && out_size == 0) break;  // ends early
  }
  out.resize(std::min(used, limit));
  return step == Step::end && used <= limit;
}

struct Bzip2 {
  bz_stream stream{};
  Bzip2() {
    if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) throw Error("bzip2: out of memory");
  }
  Bzip2(const Bzip2&) = delete;
  Bzip2& operator=(const Bzip2&) = delete;
  ~Bzip2() { BZ2_bzDecompressEnd(&stream); }

  Step step(const char* in, std::size_t& in_size, char* out, std::size_t& out_size) {
    constexpr std::size_t kMost = std::numeric_limits<unsigned>::max();
    stream.next_in = const_cast<char*>(in);  // it does not write there
    stream.avail_in = static_cast<unsigned>(std::min(in_size, kMost));
    stream.next_out = out;
    stream.avail_out = static_cast<unsigned>(std::min(out_size, kMost));
    const int status = BZ2_bzDecompress(&stream);
    in_size = static_cast<std::size_t>(stream.next_in - in);
    out_size = static_cast<std::size_t>(stream.next_out - out);
    if (status == BZ_STREAM_END) return Step::end;
    return status == BZ_OK ? Step::more : Step::damaged;
  }
};

struct Lz4 {
  LZ4F_dctx* context = nullptr;
  Lz4() {
    if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION)))
      throw Error("lz4: out of memory");
  }
  Lz4(const Lz4&) = delete;
  Lz4& operator=(const Lz4&) = delete;
  ~Lz4() { LZ4F_freeDecompressionContext(context); }

  Step step(const char* in, std::size_t& in_size, char* out, std::size_t& out_size) const {
    const std::size_t hint = LZ4F_decompress(context, out, &out_size, in, &in_size, nullptr);
    if (LZ4F_isError(hint)) {
      in_size = out_size = 0;
      return Step::damaged;
    }
    return hint == 0 ? Step::end : Step::more;
  }
};

struct Zstd {
  std::unique_ptr<ZSTD_DStream, std::size_t (*)(ZSTD_DStream*)> stream{ZSTD_createDStream(),
                                                                       ZSTD_freeDStream};
  Zstd() {
    if (!stream) throw Error("zstd: out of memory");
  }

  Step step(const char* in, std::size_t& in_size, char* out, std::size_t& out_size) const {
    ZSTD_inBuffer from{in, in_size, 0};
    ZSTD_outBuffer to{out, out_size, 0};
    const std::size_t hint = ZSTD_decompressStream(stream.get(), &to, &from);
    in_size = from.pos;
    out_size = to.pos;
    if (ZSTD_isError(hint)) return Step::damaged;
    return hint == 0 ? Step::end : Step::more;
  }
};

std::string pack_lz4(std::string_view plain) {
  LZ4F_preferences_t preferences{};
  preferences.frameInfo.contentChecksumFlag = LZ4F_contentChecksumEnabled;
  std::string packed(LZ4F_compressFrameBound(plain.size(), &preferences), '\0');
  const std::size_t size =
      LZ4F_compressFrame(packed.data(), packed.size(), plain.data(), plain.size(), &preferences);
  if (LZ4F_isError(size)) throw Error("lz4: out of memory");
  packed.resize(size);
  return packed;
}

std::string pack_zstd(std::string_view plain) {
  std::string packed(ZSTD_compressBound(plain.size()), '\0');
  const std::size_t size =
      ZSTD_compress(packed.data(), packed.size(), plain.data(), plain.size(), 3);
  if (ZSTD_isError(size)) throw Error("zstd: out of memory");
  packed.resize(size);
  return packed;
}

}  // namespace

bool unpack(ChunkPacking packing, std::string_view packed, std::size_t limit, std::string& out) {
  switch (packing) {
    case ChunkPacking::bzip2:
      return run(Bzip2(), packed, limit, out);
    case ChunkPacking::lz4:
      return run(Lz4(), packed, limit, out);
    case ChunkPacking::zstd:
      return run(Zstd(), packed, limit, out);
    case ChunkPacking::none:
      break;
  }
  out.assign(packed.substr(0, limit));
  return packed.size() <= limit;
}

std::string pack(ChunkPacking packing, std::string_view plain) {
  if (packing == ChunkPacking::lz4) return pack_lz4(plain);
  if (packing == ChunkPacking::zstd) return pack_zstd(plain);
  if (packing != ChunkPacking::none) throw Error("only lz4 and zstd are packed");
  return std::string(plain);
}

std::string gzip(std::string_view plain) {
  z_stream stream{};
  constexpr int kGzip = 16 + MAX_WBITS;
  if (deflateInit2(&stream, 6, Z_DEFLATED, kGzip, 8, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::bad_alloc();
  std::string out(deflateBound(&stream, plain.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(plain.data()));
  stream.avail_in = static_cast<uInt>(plain.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  const int result = deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  if (result != Z_STREAM_END) throw Error("more than gzip can pack at once");
  return out;
}

}  // namespace majak::io
