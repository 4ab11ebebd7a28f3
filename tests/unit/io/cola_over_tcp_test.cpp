// SPDX-License-Identifier: Apache-2.0
// A session and a device at the two ends of a real socket that cuts and joins their bytes.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "majak/core/random.hpp"
#include "majak/io/tcp.hpp"
#include "majak/sensor/cola_emulator.hpp"
#include "majak/sensor/cola_session.hpp"

namespace majak::io {
namespace {

using namespace majak::sensor;

// Everything that is there; the socket delivers at once on this machine, mostly.
template <class Receiver>
void pump(const TcpConnection& from, Receiver& to, Time now) {
  std::array<std::uint8_t, 700> buffer;
  while (from.wait_readable(0) == Descriptor::Ready::yes) {
    const std::size_t n = from.read(buffer);
    to.receive(std::span(buffer).first(n), now);
  }
}

void write_in_pieces(const TcpConnection& to, std::span<const std::uint8_t> bytes,
                     RandomStream& random) {
  while (!bytes.empty()) {
    const auto n = std::min<std::size_t>(bytes.size(), 1 + random.below(500));
    to.write(bytes.first(n));
    bytes = bytes.subspan(n);
  }
}

TEST(ColaOverTcp, EveryScanComesThrough) {
  for (const ColaDialect dialect : {ColaDialect::a, ColaDialect::b}) {
    const TcpServer server;
    const TcpClient host("127.0.0.1", server.port());
    const auto laser = server.accept(kSecond);
    ASSERT_TRUE(laser);
    ColaEmulator device(
        {.dialect = dialect, .mirror_rate = 50, .beams = 181},
        [](Time t) { return std::vector<double>(181, 1 + to_seconds(t)); }, 0);
    ColaSession session({.patience = 0});
    RandomStream random(1);
    session.start(0);
    std::int64_t scans = 0;
    for (Time now = 0; now < 8 * kSecond; now += kSecond / 100) {
      session.advance(now);
      write_in_pieces(host, session.take_output(), random);
      pump(*laser, device, now);
      device.advance(now);
      write_in_pieces(*laser, device.take_output(), random);
      pump(host, session, now);
      while (const auto delivery = session.next()) {
        ++scans;
        EXPECT_EQ(delivery->scans_missed, 0);
        const Scan scan = to_scan(delivery->scan);
        EXPECT_NEAR(scan.ranges[0], 1 + to_seconds(scan.time), 0.05);
      }
    }
    EXPECT_GT(scans, 200);
    EXPECT_LE(device.scans_sent() - scans, 2) << "on their way";
    EXPECT_EQ(session.counts().unreadable, 0);
  }
}

}  // namespace
}  // namespace majak::io
