// SPDX-License-Identifier: Apache-2.0
#include "majak/io/descriptor.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "majak/core/error.hpp"

namespace majak::io {
namespace {

int milliseconds(Duration d) {
  return static_cast<int>(std::clamp<Duration>((d + 999'999) / 1'000'000, 0, 1'000'000));
}

// A socket whose peer has gone answers with a signal that ends the program, unless told not to.
ssize_t write_some(int fd, std::span<const std::uint8_t> bytes) {
  const ssize_t n = ::send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  return n < 0 && errno == ENOTSOCK ? ::write(fd, bytes.data(), bytes.size()) : n;
}

}  // namespace

Descriptor::~Descriptor() {
  if (fd_ >= 0) ::close(fd_);
}

Descriptor::Ready Descriptor::wait_readable(Duration timeout) const {
  pollfd p{fd_, POLLIN, 0};
  const int ready = ::poll(&p, 1, milliseconds(timeout));
  if (ready <= 0) return Ready::no;
  if (p.revents & POLLIN) return Ready::yes;  // what came before it went is still to be read
  return p.revents & (POLLHUP | POLLERR | POLLNVAL) ? Ready::gone : Ready::no;
}

std::size_t Descriptor::read(std::span<std::uint8_t> bytes, const char* what) const {
  const ssize_t n = ::read(fd_, bytes.data(), bytes.size());
  if (n > 0) return static_cast<std::size_t>(n);
  if (n < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR)) return 0;
  throw Error(
      fmt::format("{}: {}", what, n == 0 ? "the other side has gone" : std::strerror(errno)));
}

void Descriptor::write(std::span<const std::uint8_t> bytes, const char* what,
                       Duration patience) const {
  while (!bytes.empty()) {
    const ssize_t n = write_some(fd_, bytes);
    if (n > 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(n));
      continue;
    }
    if (n < 0 && errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR)
      throw Error(fmt::format("{}: {}", what, std::strerror(errno)));
    pollfd p{fd_, POLLOUT, 0};
    if (::poll(&p, 1, milliseconds(patience)) == 0)
      throw Error(fmt::format("{}: takes no more bytes", what));
  }
}

}  // namespace majak::io
