// SPDX-License-Identifier: Apache-2.0
// MAJAK_FUZZ(text) { ... }: the body may throw majak::Error and nothing else.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "majak/core/error.hpp"

#define MAJAK_FUZZ(text)                                                           \
  static void fuzz(const std::string& text);                                       \
  extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t n) { \
    try {                                                                          \
      fuzz(std::string(reinterpret_cast<const char*>(data), n));                   \
    } catch (const majak::Error&) {                                                \
    }                                                                              \
    return 0;                                                                      \
  }                                                                                \
  static void fuzz(const std::string& text)
