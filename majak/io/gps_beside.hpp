// SPDX-License-Identifier: Apache-2.0
// GpsBeside: a log, and between its events the fixes of another one, by time.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "majak/io/source.hpp"

namespace majak::io {

class GpsBeside final : public Source {
 public:
  /// Of `gps` only the fixes are taken; those of `log` itself go on as they are.
  GpsBeside(std::unique_ptr<Source> log, std::unique_ptr<Source> gps);

  std::optional<Event> next() override;
  const Report& report() const override { return report_; }
  const std::string& format() const override { return format_; }

 private:
  std::optional<GpsFix> next_fix();
  void finish();

  std::unique_ptr<Source> log_, gps_;
  std::string format_;
  std::optional<Event> event_;  ///< the next of the log
  std::optional<GpsFix> fix_;
  bool begun_ = false, told_ = false, finished_ = false;
  Report report_;
};

}  // namespace majak::io
