// SPDX-License-Identifier: Apache-2.0
#include "majak/io/serial_port.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <numeric>
#include <optional>
#include <vector>

#include "majak/core/error.hpp"

namespace majak::io {
namespace {

using testing::HasSubstr;

template <class End>
std::vector<std::uint8_t> take(const End& end, std::size_t count) {
  std::vector<std::uint8_t> got;
  std::array<std::uint8_t, 300> buffer;
  while (got.size() < count && end.wait_readable(kSecond) == Descriptor::Ready::yes) {
    const std::size_t n = end.read(buffer);
    got.insert(got.end(), buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(n));
  }
  return got;
}

std::vector<std::uint8_t> every_byte() {
  std::vector<std::uint8_t> bytes(256);
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
  return bytes;
}

// A bare chroot has no /dev/pts.
class Terminals : public testing::Test {
 protected:
  void SetUp() override {
    try {
      const PseudoTerminal any;
    } catch (const Error&) {
      GTEST_SKIP() << "skipped: this machine has no pseudo-terminals";
    }
  }
};
class SerialPortTest : public Terminals {};
class PseudoTerminalTest : public Terminals {};

TEST_F(SerialPortTest, CarriesEveryByteBothWays) {
  const PseudoTerminal device;
  const SerialPort host(device.device());
  const auto bytes = every_byte();
  host.write(bytes);
  EXPECT_EQ(take(device, 256), bytes);
  EXPECT_EQ(device.write(bytes), 256U);
  EXPECT_EQ(take(host, 256), bytes);
}

TEST_F(SerialPortTest, TellsTheOtherEndItsRate) {
  const PseudoTerminal device;
  SerialPort host(device.device());
  for (const int baud : {9600, 19200, 38400, 500000}) {
    host.set_baud(baud);
    EXPECT_EQ(device.baud(), baud);
  }
}

// A stream of an earlier program, or of the rate before: it would seem to be heard at this one.
TEST_F(SerialPortTest, WhatCameBeforeIsForgotten) {
  const PseudoTerminal device;
  const std::array<std::uint8_t, 1> byte{7};
  {
    const SerialPort earlier(device.device());
    device.write(byte);
    EXPECT_EQ(earlier.wait_readable(kSecond), Descriptor::Ready::yes);  // it has arrived, unread
  }
  SerialPort host(device.device());
  EXPECT_EQ(host.wait_readable(kSecond / 20), Descriptor::Ready::no);
  device.write(byte);
  EXPECT_EQ(host.wait_readable(kSecond), Descriptor::Ready::yes);
  host.set_baud(38400);
  EXPECT_EQ(host.wait_readable(kSecond / 20), Descriptor::Ready::no);
}

TEST_F(SerialPortTest, NothingToReadIsNothing) {
  const PseudoTerminal device;
  const SerialPort host(device.device());
  std::array<std::uint8_t, 8> buffer;
  EXPECT_EQ(host.wait_readable(0), Descriptor::Ready::no);
  EXPECT_EQ(device.read(buffer), 0U);
}

TEST_F(SerialPortTest, UnpluggedIsAnError) {
  std::optional<PseudoTerminal> device(std::in_place);
  const SerialPort host(device->device());
  device.reset();
  EXPECT_NE(host.wait_readable(kSecond), Descriptor::Ready::no);  // it is told, not waited out
  std::array<std::uint8_t, 8> buffer;
  EXPECT_THROW(host.read(buffer), Error);
  EXPECT_THROW(host.write(buffer), Error);
}

TEST_F(SerialPortTest, WhatCannotBeOpenedSaysWhatToDo) {
  const auto message = [](const char* device) {
    try {
      const SerialPort port(device);
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_THAT(message("/dev/no_such_port"), HasSubstr("is it plugged in?"));
  EXPECT_THAT(message("/dev/null"), HasSubstr("/dev/null: is no serial port"));
}

TEST_F(PseudoTerminalTest, ProgramsMayComeAndGo) {
  const PseudoTerminal device;
  for (int k = 0; k < 2; ++k) {
    const SerialPort host(device.device());
    host.write(every_byte());
    EXPECT_EQ(take(device, 256).size(), 256U);
  }
}

}  // namespace
}  // namespace majak::io
