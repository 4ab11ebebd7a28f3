// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "majak/io/atomic_file.hpp"
#include "majak/io/site_file.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace {

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

struct Whole {
  std::string site, edits;
};

/// A site with everything in it, and the edits beside it.
Whole whole_site(const std::string& path) {
  majak::Site site;
  site.scans.resize(3);
  site.scans[1].key = true;
  site.key_links.resize(1);
  site.edits.resize(2);
  site.edits[0].id = 1;
  site.edits[0].points.resize(3);
  site.edits[1].id = 2;
  site.edits[1].kind = majak::EditKind::turn;
  site.edits[1].radians = 0.5;
  for (majak::PosedScan& s : site.scans) s.scan.ranges = {1.0F, 2.5F, majak::kNoReturn};
  site.constraints.resize(2);
  site.truth.resize(1);
  majak::io::write_site(path, site);
  majak::io::write_edits(path, site);
  return {bytes_of(path), bytes_of(majak::io::edits_file(path))};
}

}  // namespace

/// A whole file with some bytes changed, the site or the edits beside it by the first byte: each
/// three bytes of input say where (16 bits) and to what.
MAJAK_FUZZ(patches) {
  static const std::string path = "/dev/shm/majak-fuzz-" + std::to_string(::getpid()) + ".majak";
  static const Whole whole = whole_site(path);
  const bool edits = !patches.empty() && (patches[0] & 1);
  std::string bytes = edits ? whole.edits : whole.site;
  for (std::size_t i = 0; i + 2 < patches.size(); i += 3) {
    const auto low = static_cast<unsigned char>(patches[i]);
    const auto high = static_cast<unsigned char>(patches[i + 1]);
    bytes[(low + 256U * high) % bytes.size()] = patches[i + 2];
  }
  majak::io::write_file_atomically(path, edits ? whole.site : bytes);
  majak::io::write_file_atomically(majak::io::edits_file(path), edits ? bytes : whole.edits);
  majak::io::read_site(path);
}
