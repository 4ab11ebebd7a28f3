// SPDX-License-Identifier: Apache-2.0
// A host that talks to the emulator in simulated time, a millisecond a step, and hears everything.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "majak/sensor/lms_emulator.hpp"
#include "majak/sensor/telegram_framer.hpp"

namespace majak::sensor::testing {

inline constexpr Duration kMs = 1'000'000;

/// Every beam of every scan has this range.
inline LmsEmulator::Source all_at(double range) {
  return [range](Time, const Variant& v) {
    return std::vector<double>(static_cast<std::size_t>(v.beams()), range);
  };
}

struct Host {
  LmsEmulator device;
  TelegramFramer framer{TelegramFramer::Direction::device_to_host};
  int baud;
  Time now = 0;
  std::vector<Chunk> chunks;
  std::vector<Frame> frames;

  explicit Host(const LmsEmulatorOptions& options, LmsEmulator::Source source = all_at(2))
      : device(options, std::move(source), 0), baud(options.baud) {}

  /// Time goes on; what is heard is added to `frames` and `chunks`.
  void wait(Duration duration) {
    for (const Time end = now + duration; now < end;) {
      now += kMs;
      for (const Chunk& chunk : device.transmit(now, baud)) {
        framer.set_byte_time(chunk.byte_time);
        framer.push(chunk.bytes, chunk.end());
        chunks.push_back(chunk);
        collect();
      }
      framer.expire(now);
      collect();
    }
  }
  void collect() {
    while (auto frame = framer.next()) frames.push_back(*frame);
  }
  void say(const Telegram& command) { device.receive(encode(command), baud, now); }

  /// What is heard within so long after the command.
  std::vector<Frame> ask(const Telegram& command, Duration duration = 400 * kMs) {
    wait(kMs);
    frames.clear();
    say(command);
    wait(duration);
    return frames;
  }
  /// The one telegram that answers, behind an ACK; an empty one if it was not like this.
  Telegram answer(const Telegram& command, Duration duration = 400 * kMs) {
    const auto heard = ask(command, duration);
    if (heard.size() != 2 || heard[0].kind != Frame::Kind::ack) return {};
    return heard[1].telegram;
  }
  std::vector<Frame> telegrams(Reply code) const {
    std::vector<Frame> out;
    for (const Frame& f : frames) {
      if (f.kind == Frame::Kind::telegram && f.telegram.is(code)) out.push_back(f);
    }
    return out;
  }
};

inline LmsEmulatorOptions booted() {
  LmsEmulatorOptions o = lms291_s05();
  o.booted = true;
  return o;
}

}  // namespace majak::sensor::testing
