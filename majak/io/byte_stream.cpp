// SPDX-License-Identifier: Apache-2.0
#include "majak/io/byte_stream.hpp"

#include <bzlib.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>
#include <vector>

#include "majak/core/error.hpp"

namespace majak::io {

ByteStream::~ByteStream() = default;

namespace {

constexpr std::size_t kPackedBlock = std::size_t{1} << 16;
const char* const kEndsEarly = "compressed file ends early; kept what could be unpacked";
const char* const kDamaged = "compressed data are damaged; kept what could be unpacked";
const char* const kTrailing = "bytes after the end of the compressed data; left out";

Error file_error(const std::filesystem::path& path, const char* what, int code) {
  return Error(path.string() + ": " + what + ": " + std::strerror(code));
}

class FileStream final : public ByteStream {
 public:
  explicit FileStream(const std::filesystem::path& path) : path_(path), fd_(open_file(path)) {}
  FileStream(const FileStream&) = delete;
  FileStream& operator=(const FileStream&) = delete;
  ~FileStream() override { ::close(fd_); }

  std::size_t read(char* to, std::size_t size) override {
    for (;;) {
      const ssize_t got = ::read(fd_, to, size);
      if (got >= 0) return static_cast<std::size_t>(got);
      if (errno != EINTR) throw file_error(path_, "cannot be read", errno);
    }
  }

 private:
  static int open_file(const std::filesystem::path& path) {
    const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (fd < 0) throw file_error(path, "cannot be opened", errno);
    struct stat info {};
    if (::fstat(fd, &info) == 0 && S_ISDIR(info.st_mode)) {
      ::close(fd);
      throw file_error(path, "cannot be read as a file", EISDIR);
    }
    ::posix_fadvise(fd, 0, 0, POSIX_FADV_SEQUENTIAL);
    return fd;
  }

  std::filesystem::path path_;
  int fd_;
};

class MemoryStream final : public ByteStream {
 public:
  explicit MemoryStream(std::string content) : content_(std::move(content)) {}
  std::size_t read(char* to, std::size_t size) override {
    const std::size_t n = std::min(size, content_.size() - at_);
    if (n > 0) std::memcpy(to, content_.data() + at_, n);
    at_ += n;
    return n;
  }

 private:
  std::string content_;
  std::size_t at_ = 0;
};

class PrependedStream final : public ByteStream {
 public:
  PrependedStream(std::string head, std::unique_ptr<ByteStream> tail)
      : head_(std::move(head)), tail_(std::move(tail)) {
    report_ = tail_->report();
  }
  std::size_t read(char* to, std::size_t size) override {
    if (const std::size_t n = head_.read(to, size); n > 0) return n;
    const std::size_t n = tail_->read(to, size);
    report_ = tail_->report();
    return n;
  }

 private:
  MemoryStream head_;
  std::unique_ptr<ByteStream> tail_;
};

enum class Step { more, end, damaged };

/// Feeds packed bytes to a Decoder, which knows one packing: init(), step(), end() and the field
/// `stream` with next_in/avail_in/next_out/avail_out, named alike in zlib and libbz2.
template <class Decoder>
class UnpackedStream final : public ByteStream {
 public:
  explicit UnpackedStream(std::unique_ptr<ByteStream> packed)
      : packed_(std::move(packed)), block_(kPackedBlock) {
    decoder_.init();
  }
  UnpackedStream(const UnpackedStream&) = delete;
  UnpackedStream& operator=(const UnpackedStream&) = delete;
  ~UnpackedStream() override { decoder_.end(); }

  std::size_t read(char* to, std::size_t size) override {
    auto& z = decoder_.stream;
    decoder_.set_output(to, size);
    while (!done_ && z.avail_out == size) {
      if (z.avail_in == 0 && !refill()) {
        if (inside_) report_.count(kEndsEarly);
        done_ = true;
        break;
      }
      if (!inside_ && !start_member()) break;
      switch (decoder_.step()) {
        case Step::more:
          break;
        case Step::end:
          inside_ = false;
          break;
        case Step::damaged:
          report_.count(kDamaged);
          done_ = true;
          break;
      }
    }
    return size - z.avail_out;
  }

 private:
  bool refill() {
    const std::size_t n = packed_->read(block_.data(), block_.size());
    decoder_.set_input(block_.data(), n);
    return n > 0;
  }

  /// After the end of a member another one may follow; anything else is left out.
  bool start_member() {
    if (!first_) {
      if (!decoder_.starts_member()) {
        report_.count(kTrailing);
        done_ = true;
        return false;
      }
      decoder_.restart();
    }
    first_ = false;
    inside_ = true;
    return true;
  }

  std::unique_ptr<ByteStream> packed_;
  std::vector<char> block_;
  Decoder decoder_;
  bool first_ = true;
  bool inside_ = false;
  bool done_ = false;
};

struct GzipDecoder {
  z_stream stream{};

  void init() {
    if (inflateInit2(&stream, 15 + 16) != Z_OK) throw Error("gzip: out of memory");
  }
  void end() { inflateEnd(&stream); }
  void restart() { inflateReset(&stream); }
  bool starts_member() const { return stream.next_in[0] == 0x1f; }
  void set_input(char* data, std::size_t n) {
    stream.next_in = reinterpret_cast<Bytef*>(data);
    stream.avail_in = static_cast<uInt>(n);
  }
  void set_output(char* data, std::size_t n) {
    stream.next_out = reinterpret_cast<Bytef*>(data);
    stream.avail_out = static_cast<uInt>(n);
  }
  Step step() {
    const int status = inflate(&stream, Z_NO_FLUSH);
    if (status == Z_STREAM_END) return Step::end;
    return status == Z_OK || status == Z_BUF_ERROR ? Step::more : Step::damaged;
  }
};

struct Bzip2Decoder {
  bz_stream stream{};

  void init() {
    if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) throw Error("bzip2: out of memory");
  }
  void end() { BZ2_bzDecompressEnd(&stream); }
  void restart() {
    const bz_stream at = stream;
    end();
    stream = {};
    init();
    stream.next_in = at.next_in;
    stream.avail_in = at.avail_in;
    stream.next_out = at.next_out;
    stream.avail_out = at.avail_out;
  }
  bool starts_member() const { return stream.next_in[0] == 'B'; }
  void set_input(char* data, std::size_t n) {
    stream.next_in = data;
    stream.avail_in = static_cast<unsigned>(n);
  }
  void set_output(char* data, std::size_t n) {
    stream.next_out = data;
    stream.avail_out = static_cast<unsigned>(n);
  }
  Step step() {
    const int status = BZ2_bzDecompress(&stream);
    if (status == BZ_STREAM_END) return Step::end;
    return status == BZ_OK ? Step::more : Step::damaged;
  }
};

Packing packing_of(const std::string& head) {
  if (head.starts_with("\x1f\x8b")) return Packing::gzip;
  const bool bzip2 =
      head.size() >= 4 && head.starts_with("BZh") && head[3] >= '1' && head[3] <= '9';
  return bzip2 ? Packing::bzip2 : Packing::none;
}

OpenedBytes unpack(std::unique_ptr<ByteStream> raw) {
  std::string head(4, '\0');
  std::size_t have = 0;
  while (have < head.size()) {
    const std::size_t n = raw->read(head.data() + have, head.size() - have);
    if (n == 0) break;
    have += n;
  }
  head.resize(have);
  const Packing packing = packing_of(head);
  auto whole = prepend(std::move(head), std::move(raw));
  if (packing == Packing::gzip)
    return {std::make_unique<UnpackedStream<GzipDecoder>>(std::move(whole)), packing};
  if (packing == Packing::bzip2)
    return {std::make_unique<UnpackedStream<Bzip2Decoder>>(std::move(whole)), packing};
  return {std::move(whole), packing};
}

}  // namespace

const char* packing_suffix(Packing packing) {
  switch (packing) {
    case Packing::gzip:
      return ", gzip";
    case Packing::bzip2:
      return ", bzip2";
    case Packing::none:
      break;
  }
  return "";
}

OpenedBytes open_bytes(const std::filesystem::path& path) {
  return unpack(std::make_unique<FileStream>(path));
}

OpenedBytes open_bytes_in_memory(std::string content) {
  return unpack(std::make_unique<MemoryStream>(std::move(content)));
}

std::unique_ptr<ByteStream> prepend(std::string head, std::unique_ptr<ByteStream> tail) {
  return std::make_unique<PrependedStream>(std::move(head), std::move(tail));
}

}  // namespace majak::io
