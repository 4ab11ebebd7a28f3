// SPDX-License-Identifier: Apache-2.0
// A driver and an emulated device at the two ends of a line, in a time of their own.
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "majak/sensor/lms_driver.hpp"
#include "majak/sensor/lms_emulator.hpp"

namespace majak::sensor {

/// What the device measured and what arrived.
class Wire {
 public:
  explicit Wire(const LmsEmulatorOptions& laser = {}, const LmsDriverOptions& wanted = {},
                const LmsFaults& faults = {})
      : device(
            laser, [this](Time t, const Variant& v) { return measure(t, v); }, 0),
        driver(wanted, 0) {
    device.set_faults(faults);
  }

  /// Until then, or until as many scans have arrived.
  void run(Time until, std::size_t scans = SIZE_MAX) {
    while (now < until && arrived.size() < scans) step();
  }

  struct Arrival {
    LmsDelivery delivery;
    Scan scan;
    Time at = 0;
  };

  /// s, how far the stamp of a scan is off the measured one nearest in time; infinite for a scan
  /// that the device did not measure like this.
  double off(const Arrival& a) const {
    double best = INFINITY;
    const auto from = truth.lower_bound(a.scan.time - kSecond / 50);
    for (auto it = from; it != truth.end() && it->first < a.scan.time + kSecond / 50; ++it)
      if (same(it->second, a.scan))
        best = std::min(best, std::abs(to_seconds(a.scan.time - it->first)));
    return best;
  }
  /// Anywhere among what the device measured?
  bool was_measured(const Arrival& a) const {
    return std::any_of(truth.begin(), truth.end(),
                       [&](const auto& t) { return same(t.second, a.scan); });
  }

  LmsEmulator device;
  LmsDriver driver;
  Time now = 0;
  std::vector<Arrival> arrived;
  std::map<Time, std::vector<double>> truth;  ///< by first beam
  double digit = 0.01;                        ///< m, to which the device rounds

 private:
  void step() {
    const bool plugged = !device.unplugged(now);
    if (plugged && !plugged_) driver.reopened(now);
    plugged_ = plugged;
    if (const auto out = driver.take_output(); !out.empty() && plugged)
      device.receive(out, driver.baud(), now);
    for (const Chunk& chunk : device.transmit(now, driver.baud()))
      driver.receive(chunk.bytes, chunk.end());
    driver.advance(now);
    while (auto d = driver.next()) {
      const LmsConfiguration configuration =
          driver.device().configuration.value_or(LmsConfiguration::factory());
      arrived.push_back(
          {*d, to_scan(d->scan, configuration, driver.device().variant, d->stamp), now});
    }
    now = std::max(now + 50'000, std::min(device.next_event(), driver.wake_at()));
  }

  // Every scan has ranges of its own, by its number.
  std::vector<double> measure(Time first_beam, const Variant& variant) {
    std::vector<double> ranges(static_cast<std::size_t>(variant.beams()));
    const auto number = static_cast<std::size_t>(first_beam / 13'320'000);
    for (std::size_t i = 0; i < ranges.size(); ++i)
      ranges[i] = 1.0 + 0.01 * static_cast<double>((number * 37 + i * (1 + number % 5)) % 600);
    truth[first_beam] = ranges;
    return ranges;
  }
  bool same(const std::vector<double>& ranges, const Scan& scan) const {
    if (ranges.size() != scan.ranges.size()) return false;
    for (std::size_t i = 0; i < ranges.size(); ++i)
      if (!(std::abs(ranges[i] - static_cast<double>(scan.ranges[i])) < 0.51 * digit)) return false;
    return true;
  }

  bool plugged_ = true;
};

}  // namespace majak::sensor
