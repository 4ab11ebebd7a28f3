// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <fstream>
#include <iterator>

#include "majak/io/atomic_file.hpp"
#include "majak/io/site_file.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace {

std::string whole_site(const std::string& path) {
  majak::Site site;
  site.scans.resize(3);
  for (majak::PosedScan& s : site.scans) s.scan.ranges = {1.0F, 2.5F, majak::kNoReturn};
  site.constraints.resize(2);
  site.truth.resize(1);
  majak::io::write_site(path, site);
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

/// A whole file with some bytes changed: each three bytes of input say where (16 bits) and to what.
MAJAK_FUZZ(patches) {
  static const std::string path = "/dev/shm/majak-fuzz-" + std::to_string(::getpid()) + ".majak";
  static const std::string whole = whole_site(path);
  std::string bytes = whole;
  for (std::size_t i = 0; i + 2 < patches.size(); i += 3) {
    const auto low = static_cast<unsigned char>(patches[i]);
    const auto high = static_cast<unsigned char>(patches[i + 1]);
    bytes[(low + 256U * high) % bytes.size()] = patches[i + 2];
  }
  majak::io::write_file_atomically(path, bytes);
  majak::io::read_site(path);
}
