// SPDX-License-Identifier: Apache-2.0
#include "majak/io/victoria_park.hpp"
#include "tests/fuzz/fuzz.hpp"

/// The four files, one behind the other, with a line "---" between them.
MAJAK_FUZZ(files) {
  std::string parts[4];
  std::size_t begin = 0;
  for (std::string& part : parts) {
    const std::size_t end = std::min(files.find("---\n", begin), files.size());
    part = files.substr(begin, end - begin);
    begin = std::min(end + 4, files.size());
  }
  using majak::io::open_bytes_in_memory;
  majak::io::VictoriaPark park(
      {open_bytes_in_memory(parts[0]).bytes, open_bytes_in_memory(parts[1]).bytes,
       open_bytes_in_memory(parts[2]).bytes, open_bytes_in_memory(parts[3]).bytes});
  while (park.next()) {
  }
}
