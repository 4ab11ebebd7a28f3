// SPDX-License-Identifier: Apache-2.0
// A session and a device on one wire, in a time of their own.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "majak/core/random.hpp"
#include "majak/sensor/cola_emulator.hpp"
#include "majak/sensor/cola_session.hpp"

namespace majak::sensor {

inline constexpr std::array kDialects = {ColaDialect::a, ColaDialect::b};

/// A room whose walls move, so that no two scans are equal.
inline std::vector<double> moving_room(Time time, int beams = 271) {
  std::vector<double> ranges;
  for (int i = 0; i < beams; ++i)
    ranges.push_back(3 + std::sin(i * 0.1) + 0.5 * std::sin(to_seconds(time) * 2));
  return ranges;
}

struct ColaWire {
  enum class Chunks { whole, bytes, random };
  static constexpr Duration kTransit = 300'000;  // ns, each way

  ColaWire(const ColaSessionOptions& host, const ColaEmulatorOptions& laser, Time at = 0)
      : session(host),
        device(
            laser, [n = laser.beams](Time t) { return moving_room(t, n); }, at),
        now(at) {
    session.start(now);
  }

  /// Until `end`, or until `enough` says so.
  void run(
      Time end, const std::function<bool()>& enough = [] { return false; }) {
    while (now < end && !enough()) {
      if (session.wants_connection()) {
        ++connections;
        device.connected();
        session.start(now);
      }
      session.advance(now);
      device.advance(now);
      exchange();
      const Time next = std::min({session.wake_at(), device.wake_at(), end});
      now = std::max(next, now + 1000);
    }
  }
  bool streaming() const { return session.state() == ColaSession::State::streaming; }

  void exchange() {
    for (auto asked = session.take_output(); !asked.empty(); asked = session.take_output()) {
      if (plugged) feed(asked, [&](auto bytes) { device.receive(bytes, now); });
      auto said = device.take_output();
      if (change) change(said);
      if (plugged) feed(said, [&](auto bytes) { session.receive(bytes, now + kTransit); });
    }
    auto said = device.take_output();
    if (change) change(said);
    if (plugged) feed(said, [&](auto bytes) { session.receive(bytes, now + kTransit); });
    while (auto delivery = session.next()) scans.push_back(std::move(*delivery));
  }

  void feed(std::span<const std::uint8_t> bytes,
            const std::function<void(std::span<const std::uint8_t>)>& to) {
    while (!bytes.empty()) {
      std::size_t n = bytes.size();
      if (chunks == Chunks::bytes) n = 1;
      if (chunks == Chunks::random) n = std::min<std::size_t>(n, 1 + random.below(200));
      to(bytes.first(n));
      bytes = bytes.subspan(n);
    }
  }

  ColaSession session;
  ColaEmulator device;
  Time now = 0;
  Chunks chunks = Chunks::whole;
  bool plugged = true;
  std::function<void(std::vector<std::uint8_t>&)> change;  ///< of what the device says
  RandomStream random{7};
  int connections = 1;
  std::vector<ColaDelivery> scans;
};

}  // namespace majak::sensor
