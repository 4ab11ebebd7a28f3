// SPDX-License-Identifier: Apache-2.0
// The SICK telegrams of the data folder: printed in manuals, generated, and recorded.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/data_folder.hpp"

namespace majak::sensor::testing {

using Bytes = std::vector<std::uint8_t>;

/// "02 80 D6" or "0280d6".
inline Bytes bytes(std::string_view hex) {
  Bytes out;
  std::string digits;
  for (const char c : hex) {
    if (c != ' ') digits += c;
  }
  for (std::size_t i = 0; i + 1 < digits.size(); i += 2) {
    out.push_back(static_cast<std::uint8_t>(std::stoi(digits.substr(i, 2), nullptr, 16)));
  }
  return out;
}

inline std::filesystem::path sick_folder() { return data_folder() / "sick"; }

inline bool have_sick_data() { return std::filesystem::exists(sick_folder() / "vectors.json"); }

/// What stands in quotes behind "key":, or the bare word; from `at` on, which moves behind it.
inline std::string json_value(const std::string& text, std::string_view key, std::size_t& at) {
  at = text.find('"' + std::string(key) + "\":", at);
  if (at == std::string::npos) return {};
  at = text.find_first_not_of(' ', at + key.size() + 3);
  const bool quoted = text[at] == '"';
  const std::size_t first = at + (quoted ? 1 : 0);
  at = text.find_first_of(quoted ? "\"" : ",\n}", first);
  return text.substr(first, at - first);
}

inline std::string read_sick(const char* name) {
  std::ifstream in(sick_folder() / name);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

struct Vector {
  std::string name;
  Bytes frame;
  bool crc_ok = false, length_ok = false;
};

inline std::vector<Vector> sick_vectors() {
  const std::string text = read_sick("vectors.json");
  std::vector<Vector> out;
  for (std::size_t at = 0;;) {
    Vector v;
    v.name = json_value(text, "name", at);
    if (at == std::string::npos) return out;
    v.frame = bytes(json_value(text, "hex", at));
    v.crc_ok = json_value(text, "crc_ok", at) == "true";
    v.length_ok = json_value(text, "length_ok", at) == "true";
    out.push_back(v);
  }
}

/// What an LMS-200 said, in the order of its log.
inline std::vector<Bytes> sick_recorded() {
  const std::string text = read_sick("lms200_real_telegrams.jsonl");
  std::vector<Bytes> out;
  for (std::size_t at = 0;;) {
    const std::string hex = json_value(text, "frame_hex", at);
    if (at == std::string::npos) return out;
    out.push_back(bytes(hex));
  }
}

#define MAJAK_NEEDS_SICK_DATA()                                   \
  if (!::majak::sensor::testing::have_sick_data()) {              \
    GTEST_SKIP() << "the data folder is absent (set MAJAK_DATA)"; \
  }

}  // namespace majak::sensor::testing
