// SPDX-License-Identifier: Apache-2.0
// Encoder: a counter of a wheel's ticks becomes the way it has rolled. Counters are narrow and run
// over, records come twice, ticks get lost: what can be told from the numbers is mended and
// counted, the rest (a tick lost here and there) is noise of one resolution.
#pragma once

#include <cstdint>
#include <optional>

#include "majak/core/report.hpp"
#include "majak/core/time.hpp"

namespace majak::motion {

struct EncoderOptions {
  double ticks_per_turn = 2048;  ///< of the wheel, all edges and the gear counted
  double radius = 0.1;           ///< m, of the wheel
  int bits = 32;                 ///< of the counter, 8 ... 32
  bool is_signed = true;         ///< counts from -2^(bits-1) instead of 0
  bool reversed = false;         ///< counts down while the wheel rolls ahead
  double max_speed = 10;         ///< m/s; a faster wheel is a damaged record
};

class Encoder {
 public:
  /// Throws Error for options that make no counter.
  explicit Encoder(const EncoderOptions& options);

  /// The way rolled since the record before, m; nothing where that is not known: at the first
  /// record, after a jump, after a pause in which the wheel could have turned the counter half
  /// round, for a record that is damaged or came twice. All those but the first are counted in
  /// `report`. A counter that ran over between two records is followed the shorter way round.
  std::optional<double> add(Time time, std::int64_t counter, Report& report);

  /// m rolled a tick.
  double tick() const { return tick_; }
  /// All the way so far, m: exact, whatever the number of records.
  double way() const { return tick_ * static_cast<double>(total_); }

 private:
  std::int64_t difference(std::int64_t from, std::int64_t to) const;

  EncoderOptions options_;
  double tick_;
  std::int64_t low_, high_;  ///< least and greatest count
  bool started_ = false;
  Time time_ = 0;
  std::int64_t counter_ = 0, total_ = 0;
};

}  // namespace majak::motion
