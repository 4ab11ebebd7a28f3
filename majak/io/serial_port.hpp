// SPDX-License-Identifier: Apache-2.0
// A serial port as SICK's devices want it: 8 data bits, no parity, 1 stop bit, no flow control, any
// baud rate (500000 is none of the classical ones).
#pragma once

#include <string>

#include "majak/io/descriptor.hpp"

namespace majak::io {

class SerialPort {
 public:
  /// Throws Error, one line with what to do, when there is no such device, when it may not be
  /// opened, or when it is no terminal.
  explicit SerialPort(const std::string& device);

  /// What was sent is waited for, so that no byte goes out at the wrong rate; what came in at the
  /// old rate and was not read is forgotten, as it is on opening.
  void set_baud(int baud);

  const std::string& device() const { return device_; }
  Descriptor::Ready wait_readable(Duration timeout) const { return fd_.wait_readable(timeout); }
  std::size_t read(std::span<std::uint8_t> bytes) const { return fd_.read(bytes, device_.c_str()); }
  void write(std::span<const std::uint8_t> bytes) const { fd_.write(bytes, device_.c_str()); }

 private:
  std::string device_;
  Descriptor fd_;
};

/// The device's end of a pseudo-terminal: programs open device() as they would a serial port.
class PseudoTerminal {
 public:
  PseudoTerminal();

  const std::string& device() const { return device_; }
  /// The baud rate to which the other end is set; 0 if it states none. A pseudo-terminal carries
  /// bytes at any rate, so whoever plays the device has to mind it.
  int baud() const;
  Descriptor::Ready wait_readable(Duration timeout) const { return fd_.wait_readable(timeout); }
  /// 0 also while nobody has the other end open.
  std::size_t read(std::span<std::uint8_t> bytes) const;
  /// As much as fits: bytes that nobody takes are lost, as on a wire. Returns how many went.
  std::size_t write(std::span<const std::uint8_t> bytes) const;

 private:
  Descriptor fd_, other_;  // the other end is held open, so that programs may come and go
  std::string device_;
};

}  // namespace majak::io
