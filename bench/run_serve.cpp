// SPDX-License-Identifier: Apache-2.0
// What it costs to show a live run to several pages, and how late they see it.
//   run_serve [SECONDS]
// A hub is fed like a mapping run: 37.5 records a second of 1500 bytes, 24 kB of particles with
// each, a map of 400 kB a second. Clients sit in a process of their own; of ten, one reads nothing.
// Cost is that of the feeding process with its server.
#include <fmt/core.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <ctime>
#include <fstream>
#include <mutex>
#include <thread>
#include <vector>

#include "majak/serve/server.hpp"
#include "tests/unit/serve/client.hpp"

namespace {

using namespace majak::serve;

enum Kind : std::uint32_t { kRecord, kParticles, kMap, kEnd };
struct Head {
  double sent;  // s
  std::uint32_t size, kind;
};

double now() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double cpu() {
  rusage u{};
  getrusage(RUSAGE_SELF, &u);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(u.ru_utime) + seconds(u.ru_stime);
}

double resident_mb() {
  std::ifstream in("/proc/self/statm");
  double total = 0, resident = 0;
  in >> total >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

std::string value(Kind kind, std::uint32_t size) {
  std::string bytes(size, '\0');
  const Head head{now(), size, kind};
  std::memcpy(bytes.data(), &head, sizeof head);
  return bytes;
}

/// How old each record was when it came, until the end is said.
std::vector<double> listen(std::uint16_t port) {
  std::vector<double> ages;
  test::Client client(port);
  if (client.open() != 101) return ages;
  for (;;) {
    const auto message = client.message();
    if (message.opcode != 2) return ages;
    const double came = now();
    for (std::size_t at = 0; at < message.bytes.size();) {
      Head head{};
      std::memcpy(&head, message.bytes.data() + at, sizeof head);
      if (head.kind == kEnd) return ages;
      if (head.kind == kRecord) ages.push_back(came - head.sent);
      at += head.size;
    }
  }
}

/// In a process of its own: all clients; their ages go down the pipe.
[[noreturn]] void be_clients(std::uint16_t port, int count, bool stalled, int out) {
  std::vector<double> all;
  std::mutex mutex;
  std::vector<std::thread> threads;
  test::Client reads_nothing(port, 4096);
  if (stalled) reads_nothing.open();
  for (int i = 0; i < count - stalled; ++i)
    threads.emplace_back([&] {
      const std::vector<double> ages = listen(port);
      const std::lock_guard lock(mutex);
      all.insert(all.end(), ages.begin(), ages.end());
    });
  for (std::thread& thread : threads) thread.join();
  for (std::size_t at = 0; at < all.size();) {
    const ssize_t n = write(out, all.data() + at, (all.size() - at) * sizeof(double));
    if (n <= 0) break;
    at += static_cast<std::size_t>(n) / sizeof(double);
  }
  _exit(0);
}

void feed(Hub& hub, double seconds) {
  const double begin = now();
  for (int i = 0; i < static_cast<int>(37.5 * seconds); ++i) {
    const double wait = begin + i / 37.5 - now();
    if (wait > 0) usleep(static_cast<useconds_t>(1e6 * wait));
    hub.append(value(kRecord, 1500));
    hub.set("/particles", value(kParticles, 24000));
    if (i % 37 == 0) hub.set("/map", value(kMap, 400000));
  }
  hub.append(value(kEnd, sizeof(Head)));
}

void trial(int clients, bool stalled, double seconds) {
  Hub hub("");
  int ends[2];
  if (pipe(ends) != 0) return;
  // The child is made before there are threads, and told the port.
  int ports[2];
  if (pipe(ports) != 0) return;
  const pid_t child = fork();
  if (child == 0) {
    std::uint16_t port = 0;
    if (read(ports[0], &port, sizeof port) != sizeof port) _exit(1);
    close(ends[0]);
    be_clients(port, clients, stalled, ends[1]);
  }
  close(ends[1]);
  std::vector<double> ages;
  {
    const Server server({}, {}, hub);
    const std::uint16_t port = server.port();
    if (write(ports[1], &port, sizeof port) != sizeof port) return;
    while (server.statistics().clients < static_cast<std::size_t>(clients)) usleep(1000);
    const double cpu_before = cpu(), memory_before = resident_mb();
    feed(hub, seconds);
    double age = 0;
    while (read(ends[0], &age, sizeof age) == sizeof age) ages.push_back(age);
    const double used = cpu() - cpu_before;
    std::sort(ages.begin(), ages.end());
    const auto quantile = [&](double q) {
      return ages.empty()
                 ? 0
                 : 1e3 * ages[static_cast<std::size_t>(q * static_cast<double>(ages.size() - 1))];
    };
    const ServerStatistics s = server.statistics();
    fmt::print("| {}{} | {:.2f} | {:.1f} | {:.1f} | {:.2f} | {:.2f} | {} | {} | {:.1f} |\n",
               clients, stalled ? ", one stalled" : "", 100 * used / seconds, resident_mb(),
               resident_mb() - memory_before, quantile(0.5), quantile(0.99), ages.size(), s.skipped,
               static_cast<double>(s.bytes) / 1e6);
  }
  close(ends[0]);
  close(ports[0]);
  close(ports[1]);
  waitpid(child, nullptr, 0);
}

}  // namespace

int main(int argc, char** argv) {
  const double seconds = argc > 1 ? std::stod(argv[1]) : 20;
  fmt::print(
      "| clients | CPU, % of one core | MB resident | MB grown | ms until seen, median | 99 % | "
      "records seen | values skipped | MB sent |\n"
      "|---|---|---|---|---|---|---|---|---|\n");
  trial(0, false, seconds);
  trial(1, false, seconds);
  trial(10, false, seconds);
  trial(10, true, seconds);
}
