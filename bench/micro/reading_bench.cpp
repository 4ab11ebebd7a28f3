// SPDX-License-Identifier: Apache-2.0
// Reading: one range by several ways, and a whole CARMEN log from memory.
//   cmake -S . -B build-bench -G Ninja -DMAJAK_BENCHMARKS=ON && ninja -C build-bench bench_reading
#include <benchmark/benchmark.h>

#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "majak/core/random.hpp"
#include "majak/io/carmen_reader.hpp"
#include "majak/io/number.hpp"

namespace {

constexpr int kRanges = 18000;

/// Ranges as a laser writes them: mostly below 10 m, sometimes above.
std::string ranges_text() {
  majak::RandomStream random(1);
  std::string text;
  for (int i = 0; i < kRanges; ++i) {
    char word[32];
    std::snprintf(word, sizeof word, "%.2f ", random.uniform(0.3, random.below(5) ? 9.9 : 25));
    text += word;
  }
  return text;
}

template <class Parse>
void parse_ranges(benchmark::State& state, Parse parse) {
  const std::string text = ranges_text();
  for (auto _ : state) {
    double sum = 0;
    for (const char *p = text.data(), *end = p + text.size() - 8; p < end; ++p) {
      double value = 0;
      p = parse(p, end, value);
      sum += value;
    }
    benchmark::DoNotOptimize(sum);
  }
  state.SetItemsProcessed(state.iterations() * kRanges);
}

void decimal(benchmark::State& state) {
  parse_ranges(state, [](const char* p, const char* end, double& value) {
    return majak::io::parse_decimal(p, end, value);
  });
}
BENCHMARK(decimal);

void from_chars(benchmark::State& state) {
  parse_ranges(state, [](const char* p, const char* end, double& value) {
    return std::from_chars(p, end, value).ptr;
  });
}
BENCHMARK(from_chars);

void strtod(benchmark::State& state) {
  parse_ranges(state, [](const char* p, const char*, double& value) -> const char* {
    char* stop = nullptr;
    value = std::strtod(p, &stop);
    return stop;
  });
}
BENCHMARK(strtod);

/// 500 scans of 180 beams with an ODOM line each.
void carmen_log(benchmark::State& state) {
  const std::string ranges = ranges_text();
  std::string log;
  std::size_t at = 0;
  for (int i = 0; i < 500; ++i) {
    log +=
        "ODOM 1.000000 2.000000 0.500000 0.000000 0.000000 0.000000 976052857.337284 nohost 0.1\n";
    log += "FLASER 180 ";
    for (int k = 0; k < 180; ++k) {
      if (at >= ranges.size()) at = 0;
      const std::size_t stop = ranges.find(' ', at) + 1;
      log.append(ranges, at, stop - at);
      at = stop;
    }
    log += "1.0 2.0 0.5 1.0 2.0 0.5 976052857.437284 nohost 0.2\n";
  }
  for (auto _ : state) {
    majak::io::CarmenReader reader(majak::io::open_bytes_in_memory(log).bytes, "CARMEN log");
    while (const auto event = reader.next()) benchmark::DoNotOptimize(event->index());
  }
  state.SetBytesProcessed(static_cast<std::int64_t>(state.iterations() * log.size()));
}
BENCHMARK(carmen_log);

}  // namespace

BENCHMARK_MAIN();
