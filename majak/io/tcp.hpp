// SPDX-License-Identifier: Apache-2.0
// Bytes over TCP: to a device that listens, and, for emulators and tests, the listening side.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "majak/io/descriptor.hpp"

namespace majak::io {

/// "tcp://192.168.0.1:2112", "tcp://[fe80::1]:2111", "tcp://laser".
struct TcpAddress {
  std::string host;
  std::uint16_t port = 0;
};
/// Nothing if the text does not begin with tcp://. Throws Error when host or port are missing or
/// wrong; `port` stands in for one that is not stated, 0: it has to be.
std::optional<TcpAddress> parse_tcp(std::string_view text, std::uint16_t port = 0);

/// An open connection; closed when it goes.
class TcpConnection {
 public:
  TcpConnection(Descriptor fd, std::string peer);

  /// "192.168.0.1:2112"
  const std::string& peer() const { return peer_; }
  /// A peer that has closed is `yes` first, for what it said last; then read() tells.
  Descriptor::Ready wait_readable(Duration timeout) const { return fd_.wait_readable(timeout); }
  std::size_t read(std::span<std::uint8_t> bytes) const { return fd_.read(bytes, peer_.c_str()); }
  void write(std::span<const std::uint8_t> bytes) const { fd_.write(bytes, peer_.c_str()); }

 private:
  Descriptor fd_;
  std::string peer_;
};

class TcpClient : public TcpConnection {
 public:
  /// Throws Error, one line with what to do, when there is no such host, nobody listens at the port
  /// or nobody answers in time. Each of a host's addresses has its own time.
  TcpClient(const std::string& host, std::uint16_t port, Duration timeout = 3 * kSecond);
};

/// Listens on this machine only (127.0.0.1).
class TcpServer {
 public:
  /// `port` 0: any that is free. Throws Error when the port is taken.
  explicit TcpServer(std::uint16_t port = 0);

  std::uint16_t port() const { return port_; }
  /// The next one who connects, nothing if nobody does in time.
  std::optional<TcpConnection> accept(Duration timeout) const;

 private:
  Descriptor fd_;
  std::uint16_t port_ = 0;
};

}  // namespace majak::io
