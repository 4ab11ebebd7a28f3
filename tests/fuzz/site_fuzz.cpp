// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include "majak/io/atomic_file.hpp"
#include "majak/io/site_file.hpp"
#include "tests/fuzz/fuzz.hpp"

MAJAK_FUZZ(bytes) {
  static const std::string path = "/dev/shm/majak-fuzz-" + std::to_string(::getpid()) + ".majak";
  majak::io::write_file_atomically(path, bytes);
  majak::io::read_site(path);
}
