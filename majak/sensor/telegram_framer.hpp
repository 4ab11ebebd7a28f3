// SPDX-License-Identifier: Apache-2.0
// TelegramFramer: finds the telegrams in a stream of bytes in which anything may be missing,
// doubled, flipped or added.
//
// Whatever looks like a header is a candidate until its CRC fails; then the search goes on one
// byte behind its STX, so that a good frame that begins inside of a false one is not lost. It can
// only come later: a false header waits for at most 1030 bytes, or for the silence of expire().
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "majak/core/time.hpp"
#include "majak/sensor/telegram.hpp"

namespace majak::sensor {

/// Something that was found: a telegram with a right CRC, or a handshake byte between telegrams.
struct Frame {
  enum class Kind { telegram, ack, nak };
  Kind kind = Kind::telegram;
  Telegram telegram;    ///< empty for ack and nak
  Time first_byte = 0;  ///< when its first byte began to arrive
};

class TelegramFramer {
 public:
  enum class Direction { device_to_host, host_to_device };
  struct Counts {
    std::int64_t telegrams = 0;
    std::int64_t crc_errors = 0;     ///< candidates whose CRC was wrong
    std::int64_t overlaps = 0;       ///< right CRC, but the next telegram began inside of them
    std::int64_t expired = 0;        ///< candidates that silence cut off
    std::int64_t skipped_bytes = 0;  ///< bytes that belong to nothing that was found
  };
  static constexpr Duration kTimeout = kSecond / 20;  ///< 50 ms; gaps of 14 ms are legal

  explicit TelegramFramer(Direction direction, Duration timeout = kTimeout);

  /// How long one byte takes on the line (10 / baud). With it, the bytes of one push() get times
  /// of their own, back from the last one; without, all of them begin at `now`.
  void set_byte_time(Duration byte_time) { byte_time_ = byte_time; }

  /// The last of these bytes had arrived at `now`, which never decreases. Call next() until it
  /// gives nothing after each push; then at most one longest telegram stays in memory.
  void push(std::span<const std::uint8_t> bytes, Time now);

  /// The next thing found, in the order of the stream.
  std::optional<Frame> next();

  /// If no byte has come for the timeout, an unfinished candidate will not be finished: next()
  /// goes on behind its STX. Call it when the line was read and nothing was there.
  void expire(Time now);

  /// When expire() will have something to do; nothing while no candidate is open.
  std::optional<Time> expires_at() const;

  /// Forgets everything that waits (the port was opened anew, or its baud changed).
  void clear();

  const Counts& counts() const { return counts_; }

 private:
  enum class Verdict { nothing, wait, look_behind, crc_error, overlap, good };
  struct Range {  ///< the bytes of one push()
    std::uint64_t end;
    Time last;
    Duration byte_time;
  };

  std::size_t size() const { return bytes_.size() - head_; }
  std::uint8_t at(std::size_t i) const { return bytes_[head_ + i]; }
  Time began(std::uint64_t index) const;
  bool plausible_header(std::size_t i) const;
  std::size_t total() const { return (at(2) | at(3) << 8) + kTelegramEnvelope; }
  Verdict judge() const;
  Verdict judge_overlap() const;
  std::optional<Frame> handshake() const;
  Frame take();
  void consume(std::size_t n);
  void skip();

  Direction direction_;
  Duration timeout_, byte_time_ = 0;
  std::vector<std::uint8_t> bytes_;  ///< from head_ on they are not yet judged
  std::size_t head_ = 0;
  std::uint64_t consumed_ = 0;     ///< index of bytes_[head_] in the stream
  std::uint64_t silent_from_ = 0;  ///< what began before this index will get no more bytes
  std::deque<Range> ranges_;
  Time before_ = 0;      ///< end of the byte before bytes_[head_]
  bool in_step_ = true;  ///< bytes_[head_] follows a telegram or handshake directly
  Counts counts_;
};

}  // namespace majak::sensor
