// SPDX-License-Identifier: Apache-2.0
// Logs one can see, and what is needed to read and pack them.
#pragma once

#include <bzlib.h>
#include <zlib.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "majak/io/carmen_reader.hpp"
#include "majak/io/source.hpp"
#include "tests/support/data_folder.hpp"

namespace majak::io::testing {

using majak::data_folder;

/// Everything that a log gives.
struct Read {
  std::vector<Event> events;
  Report report;

  template <class T>
  std::vector<T> all() const {
    std::vector<T> found;
    for (const Event& event : events) {
      if (const T* e = std::get_if<T>(&event)) found.push_back(*e);
    }
    return found;
  }
  std::int64_t noticed(std::string_view words) const {
    std::int64_t sum = 0;
    for (const auto& [what, entry] : report.entries()) {
      if (what.find(words) != std::string::npos) sum += entry.count;
    }
    return sum;
  }
  std::int64_t first_line(std::string_view words) const {
    for (const auto& [what, entry] : report.entries()) {
      if (what.find(words) != std::string::npos) return entry.first_line;
    }
    return -1;
  }
};

inline Read read_all(Source& source) {
  Read read;
  while (auto event = source.next()) read.events.push_back(std::move(*event));
  read.report = source.report();
  return read;
}

inline Read read_carmen(std::string text) {
  CarmenReader reader(open_bytes_in_memory(std::move(text)).bytes, "CARMEN log");
  return read_all(reader);
}

inline std::string gzip(const std::string& plain) {
  z_stream z{};
  deflateInit2(&z, 9, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY);
  std::string packed(deflateBound(&z, static_cast<uLong>(plain.size())) + 64, '\0');
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(plain.data()));
  z.avail_in = static_cast<uInt>(plain.size());
  z.next_out = reinterpret_cast<Bytef*>(packed.data());
  z.avail_out = static_cast<uInt>(packed.size());
  deflate(&z, Z_FINISH);
  packed.resize(z.total_out);
  deflateEnd(&z);
  return packed;
}

inline std::string bzip2(const std::string& plain) {
  std::string packed(plain.size() + plain.size() / 50 + 700, '\0');
  auto size = static_cast<unsigned>(packed.size());
  BZ2_bzBuffToBuffCompress(packed.data(), &size, const_cast<char*>(plain.data()),
                           static_cast<unsigned>(plain.size()), 9, 0, 0);
  packed.resize(size);
  return packed;
}

}  // namespace majak::io::testing
