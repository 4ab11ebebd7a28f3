// SPDX-License-Identifier: Apache-2.0
#include "majak/sensor/telegram.hpp"

#include <string>

#include "majak/core/error.hpp"
#include "majak/sensor/telegram_bytes.hpp"

namespace majak::sensor {

std::uint16_t telegram_crc(std::span<const std::uint8_t> bytes) {
  unsigned crc = 0, previous = 0;
  for (const unsigned byte : bytes) {
    crc = crc & 0x8000u ? ((crc << 1) ^ 0x8005u) & 0xFFFFu : crc << 1;
    crc ^= previous << 8 | byte;
    previous = byte;
  }
  return static_cast<std::uint16_t>(crc);
}

std::vector<std::uint8_t> encode(const Telegram& telegram) {
  const std::size_t length = 1 + telegram.data.size() + (telegram.status ? 1 : 0);
  if (length > kLongestTelegramLength) {
    throw Error("a telegram of " + std::to_string(length) + " bytes is too long: at most " +
                std::to_string(kLongestTelegramLength));
  }
  std::vector<std::uint8_t> frame;
  frame.reserve(length + kTelegramEnvelope);
  frame.push_back(kStx);
  frame.push_back(telegram.address);
  put_16(frame, static_cast<unsigned>(length));
  frame.push_back(telegram.code);
  frame.insert(frame.end(), telegram.data.begin(), telegram.data.end());
  if (telegram.status) frame.push_back(*telegram.status);
  put_16(frame, telegram_crc(frame));
  return frame;
}

std::optional<Telegram> decode(std::span<const std::uint8_t> frame) {
  if (frame.size() <= kTelegramEnvelope || frame[0] != kStx) return std::nullopt;
  const std::size_t length = frame[2] | frame[3] << 8;
  if (length + kTelegramEnvelope != frame.size() || length > kLongestTelegramLength) {
    return std::nullopt;
  }
  const unsigned crc = frame[frame.size() - 2] | frame[frame.size() - 1] << 8;
  if (telegram_crc(frame.first(frame.size() - 2)) != crc) return std::nullopt;
  const bool from_device = (frame[1] & kDeviceBit) != 0;
  if (from_device && length < 2) return std::nullopt;
  Telegram telegram;
  telegram.address = frame[1];
  telegram.code = frame[4];
  const auto data = frame.subspan(5, length - (from_device ? 2 : 1));
  telegram.data.assign(data.begin(), data.end());
  if (from_device) telegram.status = frame[4 + length - 1];
  return telegram;
}

}  // namespace majak::sensor
