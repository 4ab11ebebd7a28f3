// SPDX-License-Identifier: Apache-2.0
#include "app/progress.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <thread>

namespace majak::app {

using namespace std::chrono_literals;

double resident_megabytes() {
  long pages = 0, resident = 0;
  std::FILE* file = std::fopen("/proc/self/statm", "r");
  if (file == nullptr) return 0;
  const int read = std::fscanf(file, "%ld %ld", &pages, &resident);
  std::fclose(file);
  return read == 2
             ? static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6
             : 0;
}

int thread_count(int wanted) {
  return wanted > 0 ? wanted : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
}

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

Progress::Progress()
    : started_(std::chrono::steady_clock::now()),
      shown_(started_),
      terminal_(isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() { clear(); }

bool Progress::due() {
  if (!terminal_) return false;
  const auto now = std::chrono::steady_clock::now();
  if (now - started_ < 1s || now - shown_ < 100ms) return false;
  shown_ = now;
  return true;
}

void Progress::print(const std::string& what) {
  fmt::print(stderr, "\r\033[K{}, {:.0f} s", what,
             std::chrono::duration<double>(shown_ - started_).count());
  std::fflush(stderr);
  dirty_ = true;
}

void Progress::show(const char* stage, std::int64_t count) {
  if (due()) print(fmt::format("{}: {} scans", stage, count));
}

void Progress::show(const char* stage, std::size_t done, std::size_t all) {
  if (due()) print(fmt::format("{}: {} of {}", stage, done, all));
}

void Progress::show(const io::LiveStatus& status) {
  if (!due()) return;
  std::string what = status.activity;
  if (status.scans > 0) what += fmt::format(": {} scans", status.scans);
  if (status.skipped > 0) what += fmt::format(", {} skipped", status.skipped);
  print(what);
}

void Progress::clear() {
  if (!dirty_) return;
  fmt::print(stderr, "\r\033[K");
  dirty_ = false;
}

}  // namespace majak::app
