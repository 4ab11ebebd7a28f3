// SPDX-License-Identifier: Apache-2.0
// What a command works on: a log, or a device; the same calls on either.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "app/live.hpp"
#include "app/progress.hpp"
#include "majak/core/event.hpp"
#include "majak/io/recording.hpp"
#include "majak/io/source.hpp"

namespace majak::app {

class Input {
 public:
  /// `record`: a file that keeps what a device sends, too; empty: none. `progress` must outlive it.
  Input(const std::string& log, const io::SourceOptions& options, const DeviceOptions& device,
        const std::string& record, Progress& progress);

  std::optional<Event> next();
  const Report& report() const { return source_->report(); }
  bool live() const { return end_ != nullptr; }

 private:
  std::unique_ptr<RunEnd> end_;
  std::unique_ptr<io::RecordingWriter> recording_;
  std::unique_ptr<io::Source> source_;
};

}  // namespace majak::app
