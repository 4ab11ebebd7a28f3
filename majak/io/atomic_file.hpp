// SPDX-License-Identifier: Apache-2.0
// AtomicFile: a file that appears under its name whole or not at all. Bytes go to a temporary
// file beside it; commit() flushes it to the disk and renames it. Killed before that, the old
// file (or none) is what stays, and the next writer of the path takes the temporary file over.
//
//   AtomicFile file(folder / "trajectory.tum");
//   file.write(line);
//   file.commit();
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace majak::io {

class AtomicFile {
 public:
  /// Opens the temporary file. A path that names a pipe or a device is written directly, a
  /// symbolic link is followed. Throws Error (path, cause) when that is not possible.
  explicit AtomicFile(std::filesystem::path path);
  /// Removes the temporary file unless commit() was reached.
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Appends bytes (buffered). Throws Error, for example on a full disk.
  void write(std::string_view bytes);

  /// Everything reaches the disk, then the name. Throws Error; the old file then is untouched.
  void commit();

 private:
  void open_temporary();
  void flush();
  void close_file();
  [[noreturn]] void fail(const char* doing) const;

  std::filesystem::path path_;       ///< as the caller named it, for messages
  std::filesystem::path target_;     ///< where the link leads
  std::filesystem::path temporary_;  ///< empty when written directly
  int descriptor_ = -1;
  std::string buffer_;
};

/// AtomicFile, write, commit in one call.
void write_file_atomically(const std::filesystem::path& path, std::string_view bytes);

}  // namespace majak::io
