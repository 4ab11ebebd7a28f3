// SPDX-License-Identifier: Apache-2.0
#include "majak/sensor/telegram.hpp"

#include <gmock/gmock.h>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "sick_data.hpp"

namespace majak::sensor {
namespace {

using testing::Bytes;
using testing::bytes;

/// The four steps of the manual, one after the other.
std::uint16_t slow_crc(const Bytes& frame) {
  std::uint16_t crc = 0;
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const bool top = (crc & 0x8000) != 0;
    crc = static_cast<std::uint16_t>(crc << 1);
    if (top) crc = static_cast<std::uint16_t>(crc ^ 0x8005);
    const std::uint8_t before = i == 0 ? 0 : frame[i - 1];
    crc = static_cast<std::uint16_t>(crc ^ (before << 8 | frame[i]));
  }
  return crc;
}

Telegram random_telegram(RandomStream& random, std::size_t most = 40) {
  Telegram t;
  const bool device = random.below(2) == 0;
  t.address = static_cast<std::uint8_t>(random.below(128) + (device ? 128 : 0));
  t.code = static_cast<std::uint8_t>(random.below(128) + (device ? 128 : 0));
  t.data.resize(random.below(most));
  for (std::uint8_t& b : t.data) b = static_cast<std::uint8_t>(random.below(256));
  if (device) t.status = static_cast<std::uint8_t>(random.below(256));
  return t;
}

TEST(Telegram, CrcIsTheManualsStepByStep) {
  RandomStream random(1);
  for (int i = 0; i < 200; ++i) {
    Bytes frame(random.below(60));
    for (std::uint8_t& b : frame) b = static_cast<std::uint8_t>(random.below(256));
    EXPECT_EQ(telegram_crc(frame), slow_crc(frame));
  }
  EXPECT_EQ(telegram_crc(bytes("02 00 01 00 31")), 0x1215);
  EXPECT_EQ(telegram_crc({}), 0);
}

TEST(Telegram, EncodedAsPrinted) {
  Telegram status;
  status.code = 0x31;
  EXPECT_EQ(encode(status), bytes("02 00 01 00 31 15 12"));
  Telegram mode;
  mode.address = 0x81;
  mode.code = 0xA0;
  mode.data = {0};
  mode.status = 0x10;
  EXPECT_EQ(encode(mode), bytes("02 81 03 00 A0 00 10 36 1A"));
}

TEST(Telegram, DecodingUndoesEncoding) {
  RandomStream random(2);
  for (int i = 0; i < 500; ++i) {
    const Telegram t = random_telegram(random);
    EXPECT_EQ(decode(encode(t)), t);
  }
}

TEST(Telegram, EveryWrongByteIsNoticed) {
  RandomStream random(3);
  for (int i = 0; i < 50; ++i) {
    const Bytes right = encode(random_telegram(random));
    for (std::size_t at = 0; at < right.size(); ++at) {
      Bytes wrong = right;
      wrong[at] ^= static_cast<std::uint8_t>(1 + random.below(255));
      EXPECT_FALSE(decode(wrong).has_value());
    }
  }
}

TEST(Telegram, NoPartOfOneIsOne) {
  RandomStream random(4);
  const Bytes right = encode(random_telegram(random));
  for (std::size_t n = 0; n < right.size(); ++n) {
    EXPECT_FALSE(decode(std::span(right).first(n)).has_value());
  }
  Bytes longer = right;
  longer.push_back(0);
  EXPECT_FALSE(decode(longer).has_value());
}

TEST(Telegram, ADeviceAlwaysHasAStatus) {
  Telegram t;  // a device's address, but only a code
  t.address = 0x80;
  t.code = 0x91;
  EXPECT_FALSE(decode(encode(t)).has_value());
}

TEST(Telegram, TooLongIsAnError) {
  Telegram t;
  t.data.resize(kLongestTelegramLength - 1);
  EXPECT_TRUE(decode(encode(t)).has_value());
  t.data.push_back(0);
  EXPECT_THROW(encode(t), Error);
}

TEST(Telegram, VectorsOfTheDataFolder) {
  MAJAK_NEEDS_SICK_DATA();
  int right = 0, wrong = 0;
  for (const testing::Vector& v : testing::sick_vectors()) {
    const auto t = decode(v.frame);
    EXPECT_EQ(t.has_value(), v.crc_ok && v.length_ok) << v.name;
    ++(t ? right : wrong);
    if (!t) continue;
    EXPECT_EQ(encode(*t), v.frame) << v.name;
  }
  EXPECT_EQ(right, 59);
  EXPECT_EQ(wrong, 6);
}

TEST(Telegram, RecordedOnesComeBackByteForByte) {
  MAJAK_NEEDS_SICK_DATA();
  const auto recorded = testing::sick_recorded();
  EXPECT_EQ(recorded.size(), 34u);
  for (const Bytes& frame : recorded) {
    const auto t = decode(frame);
    ASSERT_TRUE(t.has_value());
    EXPECT_EQ(encode(*t), frame);
  }
}

}  // namespace
}  // namespace majak::sensor
