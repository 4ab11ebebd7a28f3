// SPDX-License-Identifier: Apache-2.0
#include "app/input.hpp"

#include <fmt/core.h>

#include <cstdint>
#include <span>

#include "majak/core/error.hpp"

namespace majak::app {

Input::Input(const std::string& log, const io::SourceOptions& options, const DeviceOptions& device,
             const std::string& record, Progress& progress) {
  if (!is_device(log)) {
    if (!record.empty())
      throw Error(
          fmt::format("--record: {} is no device; majak convert makes a recording of it", log));
    source_ = io::open_log(log, options);
    return;
  }
  end_ = std::make_unique<RunEnd>(device.duration);
  source_ = open_device(log, device, *end_, progress,
                        [this](std::span<const std::uint8_t> telegram, Time first_byte) {
                          if (recording_) recording_->add_telegram(telegram, first_byte);
                        });
  if (!record.empty())
    recording_ = std::make_unique<io::RecordingWriter>(record, telegrams_of(log));
}

std::optional<Event> Input::next() {
  auto event = source_->next();
  if (!recording_) return event;
  if (!event) recording_->close();
  if (event)
    if (const auto* scan = std::get_if<Scan>(&*event)) recording_->add_scan(*scan, live_clock());
  return event;
}

}  // namespace majak::app
