// SPDX-License-Identifier: Apache-2.0
// ScanClock: when a scan was really measured, from when its first byte was seen.
//
// The device sends on the beat of its mirror. On the way to us a telegram can only be held up (by
// the line, an adapter that collects bytes, a busy computer), never hurried. So in the plane of
// beats and arrivals the truth is the line that touches the arrivals from below: an edge of their
// lower convex hull, the one under the middle of the time looked at. That gives the phase, and how
// much the mirror's clock runs ahead of ours or behind (Moon, Skelly, Towsley 1999: clock skew).
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "majak/core/time.hpp"

namespace majak::sensor {

struct ScanClockOptions {
  Duration period = 0;             ///< ns between two scans, nominal; > 0
  double most_skew = 0.005;        ///< share by which the true period may differ
  std::int64_t window = 3000;      ///< beats looked back at
  Duration pause = 100 * kSecond;  ///< after such a time without scans all begins anew
};

class ScanClock {
 public:
  explicit ScanClock(const ScanClockOptions& options) : options_(options) {}

  /// When the first byte of this scan would have been seen without delay; never later than
  /// `arrival`, and strictly later than the scan before. `index`: the device's own counter of
  /// mirror turns (modulo 256) if it sends one, and how many of them make one beat.
  Time stamp(Time arrival, std::optional<std::uint8_t> index = {}, int turns_per_beat = 1);

  /// Beats between the last two scans: more than 1 where the line is too slow or scans were lost, 0
  /// or less where the scan before was late by a beat and had been counted too far.
  std::int64_t last_step() const { return step_; }
  /// True period as estimated, ns.
  double period() const;

  void clear();

 private:
  struct Point {
    std::int64_t beat;
    Time arrival;
  };
  struct Line {
    double at, slope;  ///< ns at beat `from`, ns a beat
    std::int64_t from;
    double operator()(std::int64_t beat) const {
      return at + slope * static_cast<double>(beat - from);
    }
  };

  bool settled() const;
  Line line() const;
  std::int64_t next_beat(Time arrival, std::optional<std::uint8_t> index, int turns_per_beat) const;
  void add(const Point& point);

  ScanClockOptions options_;
  std::deque<Point> hull_;       ///< lower convex hull of the window
  std::optional<Point> newest_;  ///< not in it before the next scan has shown that it counts right
  std::int64_t beat_ = 0, step_ = 0;
  Time last_ = 0;
  std::optional<std::uint8_t> index_;
};

}  // namespace majak::sensor
