// SPDX-License-Identifier: Apache-2.0
#include "majak/io/gps_beside.hpp"

#include <utility>

namespace majak::io {
namespace {

const char* const kOutside = "gps: fixes before the log's first event or after its last one";

}  // namespace

GpsBeside::GpsBeside(std::unique_ptr<Source> log, std::unique_ptr<Source> gps)
    : log_(std::move(log)),
      gps_(std::move(gps)),
      format_(log_->format() + " with " + gps_->format()) {}

std::optional<GpsFix> GpsBeside::next_fix() {
  while (const auto event = gps_->next()) {
    if (const auto* fix = std::get_if<GpsFix>(&*event)) return *fix;
  }
  return std::nullopt;
}

std::optional<Event> GpsBeside::next() {
  if (!begun_) {
    begun_ = true;
    event_ = log_->next();
    fix_ = next_fix();
  }
  if (fix_ && (!event_ || fix_->time <= time_of(*event_))) {
    if (!event_ || !told_) report_.count(kOutside);
    return *std::exchange(fix_, next_fix());
  }
  if (!event_) {
    finish();
    return std::nullopt;
  }
  told_ = true;
  return std::exchange(event_, log_->next());
}

void GpsBeside::finish() {
  if (finished_) return;
  finished_ = true;
  for (const auto& [what, entry] : log_->report().entries()) report_.add(what, entry);
  for (const auto& [what, entry] : gps_->report().entries()) report_.add("gps: " + what, entry);
}

}  // namespace majak::io
