// SPDX-License-Identifier: Apache-2.0
#include "majak/io/tcp.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "majak/core/error.hpp"

namespace majak::io {
namespace {

using testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;

Bytes take(const TcpConnection& end, std::size_t count) {
  Bytes got;
  std::array<std::uint8_t, 4096> buffer;
  while (got.size() < count && end.wait_readable(kSecond) == Descriptor::Ready::yes) {
    const std::size_t n = end.read(buffer);
    got.insert(got.end(), buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(n));
  }
  return got;
}

std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

struct Pair {
  TcpServer server;
  TcpClient client{"127.0.0.1", server.port()};
  std::optional<TcpConnection> accepted = server.accept(kSecond);
};

TEST(Tcp, CarriesEveryByteBothWays) {
  const Pair pair;
  ASSERT_TRUE(pair.accepted);
  Bytes bytes;
  for (int i = 0; i < 20'000; ++i) bytes.push_back(static_cast<std::uint8_t>(i * 7 + i / 256));
  pair.client.write(bytes);
  EXPECT_EQ(take(*pair.accepted, bytes.size()), bytes);
  pair.accepted->write(bytes);
  EXPECT_EQ(take(pair.client, bytes.size()), bytes);
}

TEST(Tcp, NamesBothEnds) {
  const Pair pair;
  EXPECT_EQ(pair.client.peer(), "127.0.0.1:" + std::to_string(pair.server.port()));
  EXPECT_THAT(pair.accepted->peer(), HasSubstr("127.0.0.1:"));
}

TEST(Tcp, NothingToReadIsNothing) {
  const Pair pair;
  std::array<std::uint8_t, 8> buffer;
  EXPECT_EQ(pair.client.wait_readable(0), Descriptor::Ready::no);
  EXPECT_EQ(pair.client.read(buffer), 0U);
}

TEST(Tcp, WhatWasSaidLastIsReadBeforeTheEnd) {
  Pair pair;
  pair.accepted->write(Bytes{1, 2, 3});
  pair.accepted.reset();
  EXPECT_EQ(take(pair.client, 3), (Bytes{1, 2, 3}));
  ASSERT_NE(pair.client.wait_readable(kSecond), Descriptor::Ready::no);
  std::array<std::uint8_t, 8> buffer;
  EXPECT_THAT(message_of([&] { pair.client.read(buffer); }),
              HasSubstr(pair.client.peer() + ": the other side has gone"));
}

TEST(Tcp, WritingToOneWhoHasGoneIsAnErrorAndNotTheEndOfTheProgram) {
  Pair pair;
  pair.accepted.reset();
  const std::string message = message_of([&] {
    for (int i = 0; i < 1000; ++i) pair.client.write(Bytes(1000));
  });
  EXPECT_THAT(message, HasSubstr(pair.client.peer()));
}

TEST(Tcp, NobodyListens) {
  std::uint16_t port = 0;
  {
    const TcpServer server;
    port = server.port();
  }
  const std::string message = message_of([&] { TcpClient("127.0.0.1", port); });
  EXPECT_THAT(message, HasSubstr("127.0.0.1:" + std::to_string(port) + ": nobody listens there"));
  EXPECT_THAT(message, HasSubstr("2111 or 2112"));
}

TEST(Tcp, NoSuchHost) {
  const std::string message = message_of([] { TcpClient("no.such.host.invalid", 2112); });
  EXPECT_THAT(message, HasSubstr("no.such.host.invalid:2112: there is no such host"));
}

TEST(Tcp, NobodyAnswersInTime) {
  // Those who wait to be accepted fill the queue; then the system answers nobody.
  const TcpServer server;
  std::vector<TcpClient> waiting;
  const std::string message = message_of([&] {
    for (int i = 0; i < 20; ++i) waiting.emplace_back("127.0.0.1", server.port(), kSecond / 20);
  });
  EXPECT_THAT(message, HasSubstr("no answer; is the device on"));
}

TEST(Tcp, NobodyConnects) {
  const TcpServer server;
  EXPECT_FALSE(server.accept(0));
  EXPECT_FALSE(server.accept(kSecond / 100));
}

TEST(Tcp, APortIsForOne) {
  const TcpServer server;
  const std::string message = message_of([&] { TcpServer again(server.port()); });
  EXPECT_THAT(message, HasSubstr("port " + std::to_string(server.port())));
  EXPECT_THAT(message, HasSubstr("choose another one, or 0 for any"));
}

TEST(Tcp, ReadsAddresses) {
  const auto parsed = [](const char* text, std::uint16_t port = 0) {
    const auto address = parse_tcp(text, port);
    return address ? address->host + " " + std::to_string(address->port) : "none";
  };
  EXPECT_EQ(parsed("tcp://192.168.0.1:2112"), "192.168.0.1 2112");
  EXPECT_EQ(parsed("tcp://laser", 2111), "laser 2111");
  EXPECT_EQ(parsed("tcp://laser:65535", 2111), "laser 65535");
  EXPECT_EQ(parsed("tcp://[fe80::1]:2111"), "fe80::1 2111");
  EXPECT_EQ(parsed("tcp://[::1]", 7), "::1 7");
  EXPECT_EQ(parsed("/dev/ttyUSB0"), "none");
  for (const char* bad : {"tcp://", "tcp://:2112", "tcp://laser", "tcp://laser:", "tcp://laser:0",
                          "tcp://laser:65536", "tcp://laser:21x", "tcp://laser:-1", "tcp://[::1",
                          "tcp://[::1]x", "tcp://[]:1", "tcp://::1:2112"}) {
    EXPECT_THAT(message_of([&] { parse_tcp(bad); }), HasSubstr("write tcp://192.168.0.1:2112"))
        << bad;
  }
}

}  // namespace
}  // namespace majak::io
