// SPDX-License-Identifier: Apache-2.0
#include "majak/io/serial_port.hpp"

// The kernel's own header, for termios2: rates that are none of the classical ones. It and
// <termios.h> exclude each other.
#include <asm/termbits.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <linux/serial.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "majak/core/error.hpp"

namespace majak::io {
namespace {

std::string remedy(int error, const std::string& device) {
  if (error == EACCES)
    return fmt::format(
        "{}: no permission; add yourself to the group that owns it (dialout, as a "
        "rule) and log in again",
        device);
  if (error == ENOENT) return fmt::format("{}: there is no such device; is it plugged in?", device);
  return fmt::format("{}: {}", device, std::strerror(error));
}

// Bytes as they are: no echo, no line discipline, no flow control.
void make_raw(termios2& t) {
  t.c_iflag = IGNBRK;
  t.c_oflag = 0;
  t.c_lflag = 0;
  t.c_cflag = CS8 | CREAD | CLOCAL;
  t.c_cc[VMIN] = 0;
  t.c_cc[VTIME] = 0;
}

void set_rate(int fd, int baud, const std::string& device) {
  termios2 t{};
  if (::ioctl(fd, TCGETS2, &t) != 0) throw Error(fmt::format("{}: is no serial port", device));
  make_raw(t);
  t.c_cflag |= BOTHER;
  t.c_ispeed = t.c_ospeed = static_cast<speed_t>(baud);
  if (::ioctl(fd, TCSETSF2, &t) != 0)
    throw Error(fmt::format("{}: does not do {} baud", device, baud));
}

// USB adapters hold bytes back for 16 ms unless told not to; where this does not work it does no
// harm.
void ask_for_low_latency(int fd) {
  serial_struct serial{};
  if (::ioctl(fd, TIOCGSERIAL, &serial) != 0) return;
  serial.flags |= ASYNC_LOW_LATENCY;
  ::ioctl(fd, TIOCSSERIAL, &serial);
}

}  // namespace

SerialPort::SerialPort(const std::string& device)
    : device_(device), fd_(::open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)) {
  if (!fd_) throw Error(remedy(errno, device));
  set_rate(fd_.get(), 9600, device);
  ::ioctl(fd_.get(), TIOCEXCL);
  ask_for_low_latency(fd_.get());
}

void SerialPort::set_baud(int baud) { set_rate(fd_.get(), baud, device_); }

PseudoTerminal::PseudoTerminal() : fd_(::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)) {
  char name[128];
  if (!fd_ || ::grantpt(fd_.get()) != 0 || ::unlockpt(fd_.get()) != 0 ||
      ::ptsname_r(fd_.get(), name, sizeof name) != 0)
    throw Error(fmt::format("no pseudo-terminal: {}", std::strerror(errno)));
  device_ = name;
  other_ = Descriptor(::open(name, O_RDWR | O_NOCTTY | O_CLOEXEC));
  if (!other_) throw Error(remedy(errno, device_));
  set_rate(other_.get(), 9600, device_);
}

int PseudoTerminal::baud() const {
  termios2 t{};
  return ::ioctl(fd_.get(), TCGETS2, &t) == 0 ? static_cast<int>(t.c_ospeed) : 0;
}

std::size_t PseudoTerminal::read(std::span<std::uint8_t> bytes) const {
  const ssize_t n = ::read(fd_.get(), bytes.data(), bytes.size());
  return n > 0 ? static_cast<std::size_t>(n) : 0;
}

std::size_t PseudoTerminal::write(std::span<const std::uint8_t> bytes) const {
  const ssize_t n = ::write(fd_.get(), bytes.data(), bytes.size());
  return n > 0 ? static_cast<std::size_t>(n) : 0;
}

}  // namespace majak::io
