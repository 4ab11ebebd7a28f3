// SPDX-License-Identifier: Apache-2.0
#include "majak/io/atomic_file.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "majak/core/error.hpp"

namespace majak::io {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kBufferSize = 1 << 16;
constexpr int kMaxNames = 100;

[[noreturn]] void throw_error(const fs::path& path, const char* doing, int code) {
  throw Error(fmt::format("{}: cannot {}: {}", path.string(), doing,
                          std::error_code(code, std::generic_category()).message()));
}

/// Whether the file behind the descriptor is ours and still has this name: a live writer holds its
/// lock, a killed one no longer, and one that has finished has given the file its final name.
bool is_ours(int descriptor, const fs::path& path, bool made_here) {
  // Where the file system knows no locks nothing is taken over, and what we made is ours.
  if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) return made_here && errno != EWOULDBLOCK;
  struct stat opened {
  }, named{};
  return ::fstat(descriptor, &opened) == 0 && ::lstat(path.c_str(), &named) == 0 &&
         opened.st_ino == named.st_ino && opened.st_dev == named.st_dev;
}

/// A new temporary file, or the one that a killed writer left. -1 with errno; EEXIST: it is in use.
int open_or_take_over(const fs::path& path) {
  int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  const bool made_here = descriptor >= 0;
  if (!made_here && errno != EEXIST) return -1;
  if (!made_here) descriptor = ::open(path.c_str(), O_WRONLY | O_NOFOLLOW | O_CLOEXEC);
  if (descriptor >= 0) {
    if (is_ours(descriptor, path, made_here) && ::ftruncate(descriptor, 0) == 0) return descriptor;
    ::close(descriptor);
  }
  errno = EEXIST;
  return -1;
}

}  // namespace

AtomicFile::AtomicFile(fs::path path) : path_(std::move(path)), target_(path_) {
  std::error_code code;
  if (fs::is_symlink(path_, code)) {
    target_ = fs::weakly_canonical(path_, code);
    if (code) throw_error(path_, "follow the link", code.value());
  }
  const fs::file_status status = fs::status(target_, code);
  if (fs::is_directory(status)) throw_error(path_, "write", EISDIR);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    // Renaming onto a device or a pipe would replace it.
    descriptor_ = ::open(target_.c_str(), O_WRONLY | O_CLOEXEC);
    if (descriptor_ < 0) throw_error(path_, "open", errno);
    return;
  }
  open_temporary();
}

/// Under a name that is ours alone as long as we live: two writers of one path do not mix, the
/// later rename wins; what a killed writer left is used again, so that no litter grows.
void AtomicFile::open_temporary() {
  int cause = EEXIST;
  for (int i = 0; i < kMaxNames && cause == EEXIST; ++i) {
    temporary_ = target_;
    temporary_ += fmt::format(".partial-{}", i);
    descriptor_ = open_or_take_over(temporary_);
    if (descriptor_ >= 0) return;
    cause = errno;
  }
  temporary_.clear();
  throw_error(path_, "write", cause);
}

AtomicFile::~AtomicFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void AtomicFile::write(std::string_view bytes) {
  buffer_.append(bytes);
  if (buffer_.size() >= kBufferSize) flush();
}

void AtomicFile::commit() {
  flush();
  close_file();
  if (temporary_.empty()) return;
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) fail("rename the finished file");
  temporary_.clear();
  // The new name itself should outlive a power cut; not every file system can promise that.
  const fs::path folder = target_.has_parent_path() ? target_.parent_path() : fs::path(".");
  const int directory = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (directory >= 0) {
    ::fsync(directory);
    ::close(directory);
  }
}

void AtomicFile::flush() {
  std::string_view rest = buffer_;
  while (!rest.empty()) {
    const ssize_t written = ::write(descriptor_, rest.data(), rest.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail("write");
    rest.remove_prefix(static_cast<std::size_t>(written));
  }
  buffer_.clear();
}

void AtomicFile::close_file() {
  // Pipes and terminals have nothing to sync and say EINVAL.
  if (!temporary_.empty() && ::fsync(descriptor_) != 0) fail("flush to the disk");
  if (::close(std::exchange(descriptor_, -1)) != 0) fail("close");
}

void AtomicFile::fail(const char* doing) const { throw_error(path_, doing, errno); }

void write_file_atomically(const fs::path& path, std::string_view bytes) {
  AtomicFile file(path);
  file.write(bytes);
  file.commit();
}

}  // namespace majak::io
