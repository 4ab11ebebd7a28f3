// SPDX-License-Identifier: Apache-2.0
#include "app/progress.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include <cstdio>

namespace majak::app {

using namespace std::chrono_literals;

Progress::Progress()
    : started_(std::chrono::steady_clock::now()),
      shown_(started_),
      terminal_(isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() { clear(); }

void Progress::show(const char* stage, std::int64_t count) {
  if (!terminal_) return;
  const auto now = std::chrono::steady_clock::now();
  if (now - started_ < 1s || now - shown_ < 100ms) return;
  shown_ = now;
  fmt::print(stderr, "\r\033[K{}: {} scans, {:.0f} s", stage, count,
             std::chrono::duration<double>(now - started_).count());
  std::fflush(stderr);
  dirty_ = true;
}

void Progress::clear() {
  if (!dirty_) return;
  fmt::print(stderr, "\r\033[K");
  dirty_ = false;
}

}  // namespace majak::app
