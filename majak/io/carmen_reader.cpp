// SPDX-License-Identifier: Apache-2.0
#include "majak/io/carmen_reader.hpp"

#include <utility>

namespace majak::io {

using Kind = CarmenRecord::Kind;

CarmenReader::CarmenReader(std::unique_ptr<ByteStream> bytes, std::string format)
    : lines_(std::move(bytes)), format_(std::move(format)) {}

/// The next line that says something; false at the end of the log.
bool CarmenReader::read_record() {
  while (const auto line = lines_.next()) {
    parse_carmen_line(*line, !lines_.terminated(), record_);
    switch (record_.kind) {
      case Kind::event:
      case Kind::param:
        return true;
      case Kind::nothing:
        break;
      case Kind::unknown:
        report_.count("lines with a message that CARMEN does not know; left out", lines_.line());
        break;
      case Kind::damaged:
        report_.count(record_.problem, lines_.line());
        break;
    }
  }
  return false;
}

void CarmenReader::watch_window() {
  while (!habits_.enough() && read_record()) {
    habits_.observe(record_);
    if (record_.kind == Kind::event) window_.push_back({std::move(record_), lines_.line()});
  }
  habits_.settle();
  settled_ = true;
}

void CarmenReader::finish() {
  if (finished_) return;
  finished_ = true;
  const Report below = lines_.report();
  for (const auto& [what, entry] : below.entries()) report_.add(what, entry);
}

std::optional<Event> CarmenReader::next() {
  if (!settled_) watch_window();
  while (!window_.empty()) {
    Waiting waiting = std::move(window_.front());
    window_.pop_front();
    if (habits_.complete(waiting.record, waiting.line, report_))
      return std::move(waiting.record.event);
  }
  while (read_record()) {
    if (record_.kind != Kind::event) continue;
    if (habits_.complete(record_, lines_.line(), report_)) return std::move(record_.event);
  }
  finish();
  return std::nullopt;
}

}  // namespace majak::io
