// SPDX-License-Identifier: Apache-2.0
// LmsUart: the emulated device's way out. It knows when every byte leaves: ten bits at the baud, at
// most so many bytes a turn of the mirror, and the damage that a bad cable does on the way.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "majak/core/random.hpp"
#include "majak/core/time.hpp"

namespace majak::sensor {

/// Bytes that followed each other on the line without a pause.
struct Chunk {
  Time begin = 0;  ///< start bit of the first one
  Duration byte_time = 0;
  std::vector<std::uint8_t> bytes;

  /// When byte i has left.
  Time left(std::size_t i) const { return begin + static_cast<Duration>(i + 1) * byte_time; }
  Time end() const { return begin + static_cast<Duration>(bytes.size()) * byte_time; }
};

/// Rates at which single bytes are damaged.
struct ByteFaults {
  double drop = 0;
  double duplicate = 0;
  double flip = 0;  ///< one bit
};

class LmsUart {
 public:
  enum class After { nothing, set_baud, reset };
  struct Output {
    std::vector<std::uint8_t> bytes;
    Time ready = 0;          ///< not before
    bool handshake = false;  ///< a new command does not cut it off
    After after = After::nothing;
    int baud = 0;  ///< for set_baud
  };
  /// An output of which the last byte has left.
  struct Done {
    Time at;
    After after;
    int baud;
  };
  struct Pace {
    Time begin;     ///< of some turn of the mirror
    Duration turn;  ///< ns
    int bytes_per_turn;
  };

  LmsUart(const Pace& pace, RandomStream random) : pace_(pace), random_(random) {}

  static constexpr Duration byte_time_of(int baud) { return baud > 0 ? 10 * kSecond / baud : 0; }
  void set_baud(int baud) { byte_time_ = byte_time_of(baud); }
  void set_faults(const ByteFaults& faults) { faults_ = faults; }
  void send(Output output) { waiting_.push_back(std::move(output)); }

  bool idle() const { return waiting_.empty(); }
  /// When the next byte will have left.
  std::optional<Time> next() const;

  /// Lets the bytes leave that have the time to until then, but stops behind an output with
  /// something to do after it.
  std::optional<Done> advance(Time until);

  /// The host interrupts: what has not yet begun to leave stays, except for handshakes. What was
  /// to be done after an output that was cut off is given back.
  std::vector<Done> cut(Time now);
  /// Everything stops, in the middle of a byte.
  void silence() { waiting_.clear(), sent_ = 0; }

  /// What has left since the last call.
  std::vector<Chunk> take();

 private:
  Time next_start() const;
  void leave(std::uint8_t byte, Time start);
  void put(std::uint8_t byte, Time start);

  Pace pace_;
  RandomStream random_;
  ByteFaults faults_;
  Duration byte_time_ = byte_time_of(9600);
  std::deque<Output> waiting_;
  std::size_t sent_ = 0;  ///< bytes of the first one
  Time free_ = 0;         ///< when the last byte had left
  Time turn_ = 0;         ///< begin of the turn in which the last byte began
  int in_turn_ = 0;       ///< bytes that began in it
  std::vector<Chunk> out_;
};

}  // namespace majak::sensor
