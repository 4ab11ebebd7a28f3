// SPDX-License-Identifier: Apache-2.0
// NmeaLog: what a satellite receiver has sent (NMEA 0183), as a Source of GpsFix.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "majak/beacon/nmea.hpp"
#include "majak/io/line_reader.hpp"
#include "majak/io/source.hpp"

namespace majak::io {

/// Does this text contain a GGA or RMC sentence with the right checksum?
bool looks_like_nmea(std::string_view text);

/// The first fix is the origin. Stamps are UTC since 1970 where the log tells a date, else seconds
/// since its first midnight.
class NmeaLog final : public Source {
 public:
  explicit NmeaLog(std::unique_ptr<ByteStream> bytes, std::string format = "NMEA log");

  std::optional<Event> next() override;
  const Report& report() const override { return report_; }
  const std::string& format() const override { return format_; }

 private:
  Event event_of(const beacon::SatelliteFix& fix);
  void finish();

  LineReader lines_;
  std::string format_;
  beacon::NmeaFixes fixes_;
  beacon::FirstFixFrame frame_;
  std::optional<Time> last_;
  bool finished_ = false;
  Report report_;
};

}  // namespace majak::io
