// SPDX-License-Identifier: Apache-2.0
#include "majak/sensor/scan_clock.hpp"

#include <algorithm>
#include <cmath>

namespace majak::sensor {
namespace {

// A share of a beat by which an arrival may seem too early for it: the line is not yet settled.
constexpr double kEarly = 0.2;
constexpr std::int64_t kLeastWidth = 50;  // beats from which an edge tells the skew

double slope(std::int64_t beats, Duration time) {
  return static_cast<double>(time) / static_cast<double>(beats);
}

}  // namespace

void ScanClock::clear() {
  hull_.clear();
  newest_.reset();
  index_.reset();
  step_ = 0;
}

bool ScanClock::settled() const { return hull_.back().beat - hull_.front().beat >= kLeastWidth; }

double ScanClock::period() const {
  return hull_.empty() ? static_cast<double>(options_.period) : line().slope;
}

ScanClock::Line ScanClock::line() const {
  const Point& newest = hull_.back();
  const double nominal = static_cast<double>(options_.period);
  const std::int64_t middle = hull_.front().beat + (newest.beat - hull_.front().beat) / 2;
  for (std::size_t i = 1; i < hull_.size(); ++i) {
    const Point &a = hull_[i - 1], &b = hull_[i];
    if (b.beat < middle) continue;
    const double s = slope(b.beat - a.beat, b.arrival - a.arrival);
    if (!settled() || std::abs(s - nominal) > options_.most_skew * nominal) break;
    return {static_cast<double>(a.arrival), s, a.beat};
  }
  // Too little seen yet: the nominal period, touching the arrivals from below.
  Line lowest{static_cast<double>(hull_.front().arrival), nominal, hull_.front().beat};
  for (const Point& p : hull_)
    lowest.at += std::min(0.0, static_cast<double>(p.arrival) - lowest(p.beat));
  return lowest;
}

std::int64_t ScanClock::next_beat(Time arrival, std::optional<std::uint8_t> index,
                                  int turns_per_beat) const {
  const Line l = line();
  const double beats = (static_cast<double>(arrival) - l(beat_)) / l.slope + kEarly;
  const auto whole = static_cast<std::int64_t>(std::floor(beats));
  // Not later than the scan before: that one had been held up for a beat and was counted too far.
  if (!index || !index_) return beat_ + (settled() ? whole : std::max<std::int64_t>(1, whole));
  // The counter tells the beats but for multiples of its 256 turns.
  const int turns = static_cast<std::uint8_t>(*index - *index_);
  const std::int64_t told = std::max(1, turns / turns_per_beat);
  const std::int64_t around = 256 / turns_per_beat;
  const std::int64_t rounds = std::max<std::int64_t>(0, (whole - told + around / 2) / around);
  return beat_ + told + rounds * around;
}

// The hull keeps what a later line can touch; points above it and out of the window go.
void ScanClock::add(const Point& point) {
  const auto below = [&](const Point& a, const Point& b) {  // b lies on or above a ... point
    return static_cast<double>(b.arrival - a.arrival) * static_cast<double>(point.beat - a.beat) >=
           static_cast<double>(point.arrival - a.arrival) * static_cast<double>(b.beat - a.beat);
  };
  while (hull_.size() >= 2 && below(hull_[hull_.size() - 2], hull_.back())) hull_.pop_back();
  hull_.push_back(point);
  while (hull_.size() > 2 && hull_[1].beat <= point.beat - options_.window) hull_.pop_front();
}

Time ScanClock::stamp(Time arrival, std::optional<std::uint8_t> index, int turns_per_beat) {
  const bool anew = hull_.empty() || arrival - last_ > options_.pause;
  if (anew) {
    clear();
    hull_.push_back({beat_ = 0, arrival});
    index_ = index;
    return last_ = arrival;
  }
  const std::int64_t beat = next_beat(arrival, index, turns_per_beat);
  step_ = beat - beat_;
  if (newest_ && step_ >= 1) add(*newest_);
  beat_ = beat;
  index_ = index;
  newest_ = Point{beat, arrival};
  const auto told = static_cast<Time>(std::llround(line()(beat)));
  last_ = std::max(std::min(told, arrival), last_ + 1);
  return last_;
}

}  // namespace majak::sensor
