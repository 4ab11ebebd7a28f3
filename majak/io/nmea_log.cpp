// SPDX-License-Identifier: Apache-2.0
#include "majak/io/nmea_log.hpp"

#include <algorithm>
#include <utility>

namespace majak::io {
namespace {

constexpr std::size_t kLongestLine = 4096;

const char* const kUndated = "fixes without a date; stamps are seconds since the first midnight";
const char* const kBackwards = "fix stamps that run backwards; order of the file kept";
const char* const kCutOff = "the last line is cut off; left out";

}  // namespace

bool looks_like_nmea(std::string_view text) {
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const beacon::NmeaKind kind = beacon::parse_nmea(text.substr(0, end)).kind;
    if (kind == beacon::NmeaKind::gga || kind == beacon::NmeaKind::rmc) return true;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return false;
}

NmeaLog::NmeaLog(std::unique_ptr<ByteStream> bytes, std::string format)
    : lines_(std::move(bytes), kLongestLine), format_(std::move(format)) {}

Event NmeaLog::event_of(const beacon::SatelliteFix& fix) {
  if (!fix.dated) report_.count(kUndated, fix.line);
  if (last_ && fix.time < *last_) report_.count(kBackwards, fix.line);
  last_ = fix.time;
  const Vec2 p = frame_.east_north(fix.place);
  return GpsFix{.time = fix.time, .east = p.x(), .north = p.y(), .sigma = fix.sigma};
}

void NmeaLog::finish() {
  finished_ = true;
  fixes_.finish(report_);
  const Report below = lines_.report();
  for (const auto& [what, entry] : below.entries()) report_.add(what, entry);
}

std::optional<Event> NmeaLog::next() {
  for (;;) {
    if (const auto fix = fixes_.take()) return event_of(*fix);
    if (finished_) return std::nullopt;
    const auto line = lines_.next();
    if (!line) {
      finish();
    } else if (!lines_.terminated() &&
               beacon::parse_nmea(*line).kind == beacon::NmeaKind::damaged) {
      report_.count(kCutOff, lines_.line());
    } else {
      fixes_.add(*line, lines_.line(), report_);
    }
  }
}

}  // namespace majak::io
