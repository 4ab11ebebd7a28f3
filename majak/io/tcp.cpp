// SPDX-License-Identifier: Apache-2.0
#include "majak/io/tcp.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <memory>

#include "majak/core/error.hpp"

namespace majak::io {
namespace {

constexpr std::string_view kScheme = "tcp://";

std::string name_of(const std::string& host, int port) {
  const bool is_ipv6 = host.find(':') != std::string::npos;
  return is_ipv6 ? fmt::format("[{}]:{}", host, port) : fmt::format("{}:{}", host, port);
}

std::string remedy(int error) {
  switch (error) {
    case ECONNREFUSED:
      return "nobody listens there; is it the right port (SICK: 2111 or 2112), and has the device "
             "started?";
    case ETIMEDOUT:
      return "no answer; is the device on and its cable plugged in, and is this computer in the "
             "same network (SICK's default is 192.168.0.1)?";
    case EHOSTUNREACH:
    case ENETUNREACH:
      return "no way there; give this computer an address in the device's network, such as "
             "192.168.0.2 with mask 255.255.255.0";
    default:
      return std::strerror(error);
  }
}

using Addresses = std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)>;

Addresses look_up(const std::string& host, std::uint16_t port) {
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_NUMERICSERV;
  addrinfo* list = nullptr;
  const int failed = ::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &list);
  if (failed != 0)
    throw Error(fmt::format("{}: there is no such host ({}); try its number, such as 192.168.0.1",
                            name_of(host, port), ::gai_strerror(failed)));
  return {list, &::freeaddrinfo};
}

// 0 when it went well. Interrupted waits count as time passed: a signal does not prolong it much.
int finish_connecting(int fd, Duration timeout) {
  pollfd p{fd, POLLOUT, 0};
  const auto ms = static_cast<int>(std::clamp<Duration>(timeout / 1'000'000, 0, 1'000'000));
  int ready = 0;
  do ready = ::poll(&p, 1, ms);
  while (ready < 0 && errno == EINTR);
  if (ready == 0) return ETIMEDOUT;
  int error = 0;
  socklen_t size = sizeof error;
  if (ready < 0 || ::getsockopt(fd, SOL_SOCKET, SO_ERROR, &error, &size) != 0) return errno;
  return error;
}

// Small commands go out at once, and a device that was unplugged is noticed some day.
void tune(int fd) {
  const int on = 1, idle = 10, interval = 5, probes = 3;  // s
  ::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  ::setsockopt(fd, SOL_SOCKET, SO_KEEPALIVE, &on, sizeof on);
  ::setsockopt(fd, IPPROTO_TCP, TCP_KEEPIDLE, &idle, sizeof idle);
  ::setsockopt(fd, IPPROTO_TCP, TCP_KEEPINTVL, &interval, sizeof interval);
  ::setsockopt(fd, IPPROTO_TCP, TCP_KEEPCNT, &probes, sizeof probes);
}

constexpr int kSocketFlags = SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC;

Descriptor connect_to(const std::string& host, std::uint16_t port, Duration timeout) {
  const Addresses addresses = look_up(host, port);
  int error = ENETUNREACH;
  for (const addrinfo* a = addresses.get(); a != nullptr; a = a->ai_next) {
    Descriptor fd(::socket(a->ai_family, kSocketFlags, 0));
    if (!fd) {
      error = errno;
      continue;
    }
    error = ::connect(fd.get(), a->ai_addr, a->ai_addrlen) == 0 ? 0 : errno;
    if (error == EINPROGRESS) error = finish_connecting(fd.get(), timeout);
    if (error == 0) return fd;
  }
  throw Error(fmt::format("{}: {}", name_of(host, port), remedy(error)));
}

}  // namespace

std::optional<TcpAddress> parse_tcp(std::string_view text, std::uint16_t port) {
  if (!text.starts_with(kScheme)) return {};
  const auto refuse = [&](const char* why) {
    return Error(fmt::format("{}: {}; write tcp://192.168.0.1:2112", text, why));
  };
  std::string_view host = text.substr(kScheme.size()), digits;
  const std::size_t bracket = host.starts_with('[') ? host.find(']') : 0;
  if (bracket == std::string_view::npos) throw refuse("the bracket is not closed");
  const std::size_t colon = host.find(':', bracket);
  if (colon != std::string_view::npos) {
    digits = host.substr(colon + 1);
    host = host.substr(0, colon);
    const auto [stop, error] = std::from_chars(digits.data(), digits.data() + digits.size(), port);
    if (error != std::errc{} || stop != digits.data() + digits.size() || port == 0)
      throw refuse("the port is no number from 1 to 65535");
  }
  if (bracket > 0) {
    if (host.size() != bracket + 1) throw refuse("only a port may follow the bracket");
    host = host.substr(1, bracket - 1);
  }
  if (host.empty()) throw refuse("there is no host");
  if (port == 0) throw refuse("there is no port");
  return TcpAddress{std::string(host), port};
}

TcpConnection::TcpConnection(Descriptor fd, std::string peer)
    : fd_(std::move(fd)), peer_(std::move(peer)) {
  tune(fd_.get());
}

TcpClient::TcpClient(const std::string& host, std::uint16_t port, Duration timeout)
    : TcpConnection(connect_to(host, port, timeout), name_of(host, port)) {}

TcpServer::TcpServer(std::uint16_t port) : fd_(::socket(AF_INET, kSocketFlags, 0)) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  auto* const generic = reinterpret_cast<sockaddr*>(&address);
  const int on = 1;
  if (fd_) ::setsockopt(fd_.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  if (!fd_ || ::bind(fd_.get(), generic, size) != 0 || ::listen(fd_.get(), 4) != 0 ||
      ::getsockname(fd_.get(), generic, &size) != 0)
    throw Error(
        fmt::format("port {}: {}; choose another one, or 0 for any", port, std::strerror(errno)));
  port_ = ntohs(address.sin_port);
}

std::optional<TcpConnection> TcpServer::accept(Duration timeout) const {
  if (fd_.wait_readable(timeout) != Descriptor::Ready::yes) return {};
  sockaddr_in address{};
  socklen_t size = sizeof address;
  Descriptor fd(::accept4(fd_.get(), reinterpret_cast<sockaddr*>(&address), &size,
                          SOCK_NONBLOCK | SOCK_CLOEXEC));
  if (!fd) return {};  // it has gone again
  char host[INET_ADDRSTRLEN] = {};
  ::inet_ntop(AF_INET, &address.sin_addr, host, sizeof host);
  return TcpConnection(std::move(fd), name_of(host, ntohs(address.sin_port)));
}

}  // namespace majak::io
